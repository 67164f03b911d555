"""A stent as a film that lies in space, and the facts of any view."""

from dataclasses import replace

import numpy as np
import pytest

from SDFStentLib.report import Sight, stent_stretch, view_axes, view_toward
from SDFStentLib.validation import InputError
from SDFStentLib.view import ArmView, ViewWishes


@pytest.fixture(scope="module")
def sight(result):
    (stent,) = result.told.final_stents
    return Sight(stent_stretch(stent, result.lesions), result.vessel, "RAS")


def test_a_film_shows_the_tube_where_it_is(sight, result):
    """Of 6 mm and upright in the middle, with the head up; right of a RAS view is the left side."""
    film = sight.film(result.inputs.surface.surface, ArmView(0, 0))
    assert film.axes == pytest.approx(np.array([[-1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    assert film.middle == pytest.approx([0, 0, 20], abs=1e-6)
    count = len(film.gray)
    pixel = film.side / count
    for away in (-15, 15):  # mm, far from the narrowing
        row = round(count / 2 + away / pixel)
        dark = film.gray[row] < 250
        assert dark.sum() * pixel == pytest.approx(6.0, abs=0.3)
        assert np.flatnonzero(dark).mean() == pytest.approx(count / 2, abs=1)
    bar = film.gray[count - 16] == 0
    assert bar.sum() * pixel == pytest.approx(film.bar, abs=pixel)


def test_struts_are_dark_where_they_are_in_the_picture(sight, result):
    wall = result.treatment.surface
    (stent,) = result.told.final_stents
    bare = sight.film(wall, ArmView(0, 0))
    with_struts = sight.film(wall, ArmView(0, 0), [stent.lattice().curves])
    changed = np.argwhere(with_struts.gray != bare.gray)
    assert len(changed) > 500
    assert (with_struts.gray[tuple(changed.T)] == 60).all()
    pixel = bare.side / len(bare.gray)
    away = (changed - len(bare.gray) / 2) * pixel
    assert np.abs(away[:, 0]).max() == pytest.approx(9, abs=0.5)  # 18 mm long
    assert np.abs(away[:, 1]).max() == pytest.approx(3.25, abs=0.3)


def test_any_view_has_its_facts_and_any_direction_its_view(sight):
    facts = sight.facts_from(ArmView(30, -20))
    assert facts.value("foreshortening_percent") == pytest.approx(6.03, abs=0.01)  # 1 - cos 20
    toward = view_axes(ArmView(30, -20), "RAS")[2]
    assert view_toward(5 * toward, "RAS") == pytest.approx((30, -20))
    assert sight.told(ViewWishes()).facts[0].value("words") == "LAO 0, CRA 0"


def test_nothing_is_seen_without_a_frame_or_a_centerline(sight, result):
    with pytest.raises(InputError, match="RAS or LPS"):
        replace(sight, known=None)
    with pytest.raises(InputError, match="centerline"):
        replace(sight, vessel=replace(result.vessel, centerline=None))
