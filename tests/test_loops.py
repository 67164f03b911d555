"""Nothing waits for ever: every loop ends for a reason that stands beside it."""

from __future__ import annotations

import numpy as np
import pytest
from trees import unbranched

from SDFStentLib.cli import main
from SDFStentLib.cli.demo import _written_patient
from SDFStentLib.geometry import Line, SurfaceIndex
from SDFStentLib.lumen import LocalSurface
from SDFStentLib.lumen.spheres import climb, inscribed
from SDFStentLib.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.phantoms.field import Rim
from SDFStentLib.phantoms.junction import _rim_loop
from SDFStentLib.validation import InputError


@pytest.fixture(scope="module")
def the_patient(tmp_path_factory):
    """A folder with the surface and the centerline of the demo."""
    folder = tmp_path_factory.mktemp("loops")
    _written_patient(branching_pulmonary_artery(), folder)
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "deploy -o out.vtp --center -26.510415359278095 0 36 --diameter 8.217 --length 19.11"
        " --straighten 0.5",
        "deploy -o out.vtp --center 17.320665289765397 -5.114567101086642 30.282713418689042"
        " --diameter 10.419 --length 25.31 --straighten 1",
        "measure --spacing 9",
    ],
)
def test_a_station_on_a_vertex_of_a_closed_end_is_measured(
    the_patient, command, monkeypatch, capsys
):
    monkeypatch.chdir(the_patient)
    name, *options = command.split()
    code = main([name, "surface.vtp", "--centerline", "centerline.vtp", *options])
    said = capsys.readouterr().err
    assert code in (0, 3), said
    assert all(line.startswith("warning: ") for line in said.splitlines()), said


@pytest.mark.parametrize("seed", range(5))
def test_a_local_surface_misses_nothing_of_the_whole_one(seed):
    random = np.random.default_rng(seed)
    tube = stenosed_tube(edge_length=1.5)
    points, triangles = tube.points, tube.triangles
    centers = points[random.integers(0, len(points), 2)]
    local, whole = LocalSurface(points, triangles, centers), SurfaceIndex(points, triangles)
    for scale in (0.0, 1e-12, 0.1, 3.0, 20.0, 1e3):
        queries = centers + scale * random.normal(size=(2, 3))
        radii = scale * random.random(2)
        found, expected = local.near(queries, radii), whole.near(queries, radii)
        for query in range(2):
            corners = [
                np.sort(index.corners[pairs.triangle[pairs.query == query]].reshape(-1, 9), axis=0)
                for index, pairs in ((local.index, found), (whole, expected))
            ]
            np.testing.assert_array_equal(*corners)
        exact = whole.distances(queries).distance
        np.testing.assert_allclose(local.distances(queries), exact, rtol=1e-14, atol=0)


def test_a_rim_that_meets_itself_is_refused():
    rim = Rim(np.zeros(3), np.array([0.0, 0, 1]), 1.0)
    triangles = np.array([[0, 1, 2], [2, 3, 4], [4, 5, 6]])
    with pytest.raises(InputError, match="edge_length: expected rims that are one loop each"):
        _rim_loop(np.zeros((7, 3)), triangles, rim)


@pytest.mark.parametrize(("length", "spacing"), [(1e6, 1e-20), (1.0, 1e-320), (20.001, 1e-3)])
def test_a_line_is_made_anew_with_a_bounded_number_of_segments(length, spacing):
    with pytest.raises(InputError, match="spacing: expected at least"):
        Line([[0, 0, 0], [length, 0, 0]]).resampled(spacing)
    with pytest.raises(InputError, match="spacing: expected at least"):
        unbranched([[0, 0, 0], [length, 0, 0]]).resampled(spacing)
    assert len(Line([[0, 0, 0], [20.0, 0, 0]]).resampled(1e-3)) == 20_001


def test_a_climb_that_does_not_settle_ends_with_the_exact_radius_of_where_it_is(monkeypatch):
    tube = stenosed_tube(edge_length=1.5)
    monkeypatch.setattr(climb, "_ROUNDS", 1)
    axis = [[0.5, 0, 10], [0.5, 0, 20], [0.5, 0, 30]]
    spheres = inscribed.inscribed_spheres(tube.points, tube.triangles, axis)
    exact = SurfaceIndex(tube.points, tube.triangles).distances(spheres.centers).distance
    np.testing.assert_allclose(spheres.radii, exact, rtol=1e-12)
    settled = SurfaceIndex(tube.points, tube.triangles).distances(np.asarray(axis)).distance
    assert (spheres.radii >= settled).all()
