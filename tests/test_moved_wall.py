"""After a treatment only what the moved wall comes near is measured again; nothing is missed."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import ONE_ANATOMY, vessel_named

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import measured_after, measured_at, moved_wall
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment, treated_lesions
from SDFStentLib.vessel import find_lesions


@pytest.fixture(scope="module", params=["stenosis", "branches", *ONE_ANATOMY])
def treated(request):
    """A vessel, its centerline, and what came of a short stent in the middle of its longest way."""
    made = vessel_named(request)
    line = made.centerline
    leaf = line.leaves[np.argmax(line.arc_length[line.leaves])]
    way = line.path(line.points[line.roots[0]], line.points[leaf])
    middle = len(way.points) // 2
    diameter = 2.4 * float(np.nanmedian(way.inscribed_radius[middle - 5 : middle + 5]))
    stent = Stent(diameter, placement=AtCenter(way.points[middle]), length=1.5 * diameter)
    settings = DeploymentSettings(certify=False)
    return made, way, Treatment(made.surface, [stent], line, settings).result


def stations_along(way):
    """All 4 mm, but at the ends of the vessel."""
    places = Line(way.points).cut(5.0, float(way.length) - 5.0).resampled(4.0).points
    return places, Line(places).directions


def test_what_is_not_measured_again_is_what_a_whole_search_finds(treated):
    made, way, result = treated
    places, directions = stations_along(way)
    before = measured_at(made.surface, places, directions)
    moved = moved_wall(made.surface, result.surface)
    found = measured_after(before, moved, result.surface)
    plain = measured_at(result.surface, places, directions)
    np.testing.assert_allclose(found.spheres.radii, plain.spheres.radii, atol=1e-3)
    np.testing.assert_allclose(found.equivalent, plain.equivalent, atol=1e-3)
    assert not np.allclose(found.spheres.radii, before.spheres.radii, atol=1e-2)


def test_lesions_after_are_those_of_a_whole_search(treated):
    made, _, result = treated
    lesions = find_lesions(made.surface, made.centerline)
    fast = treated_lesions(lesions, result.stents, result.surface, made.surface)
    plain = treated_lesions(lesions, result.stents, result.surface)
    for one, exact in zip(fast, plain, strict=True):
        assert one.after.minimum_diameter == pytest.approx(exact.after.minimum_diameter, abs=1e-3)
        assert one.after.percent_diameter == pytest.approx(exact.after.percent_diameter, abs=0.02)
        np.testing.assert_allclose(one.after.minimum_area, exact.after.minimum_area, rtol=1e-3)
        assert (one.stents, one.is_left_beyond) == (exact.stents, exact.is_left_beyond)
