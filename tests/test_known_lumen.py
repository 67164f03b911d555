"""A vessel before treatment is measured once, station by station."""

from __future__ import annotations

import gc
import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import measured_at, measured_once, open_at_ends
from SDFStentLib.phantoms import stenosed_tube
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Treatment


@pytest.fixture
def a_tube():
    return stenosed_tube()


def test_what_was_measured_with_a_cap_is_not_taken_for_what_has_none(a_tube):
    points = np.array([[0.0, 0.0, z] for z in (0.5, 1.0, 1.5)])
    along = np.tile([0.0, 0.0, 1.0], (3, 1))
    without = open_at_ends(a_tube.surface, points)
    assert len(without.triangles) + len(without.caps) == len(a_tube.surface.triangles)
    assert len(without.caps)
    capped = measured_once(a_tube.surface, points, along)
    opened = measured_once(a_tube.surface, points, along, without)
    plain = measured_at(a_tube.surface, points, along, without.triangles)
    np.testing.assert_array_equal(opened.spheres.radii, plain.spheres.radii)
    assert (opened.spheres.radii != capped.spheres.radii).any()


def test_the_surroundings_of_a_place_are_surveyed_once_for_all_diameters(a_tube):
    def survey(surface, height=20.0, diameter=6.0, line=a_tube.centerline):
        stent = Stent(diameter, placement=AtCenter([0, 0, height]), length=12.0)
        return Treatment(surface, [stent], line).survey

    surface = Surface(a_tube.points, a_tube.triangles)
    first = survey(surface)
    assert survey(surface, diameter=6.5) is first
    assert survey(surface, height=21.0) is not first
    again = survey(surface)  # the last one only is kept
    assert again is not first
    np.testing.assert_array_equal(again.axis.points, first.axis.points)
    np.testing.assert_array_equal(again.before.inscribed_diameter, first.before.inscribed_diameter)
    same_line = replace(a_tube.centerline)
    assert survey(surface, line=same_line) is not again
    gone = weakref.ref(surface)
    del surface
    gc.collect()
    assert gone() is None


def test_what_is_measured_beside_the_deployment_is_what_the_result_measures(a_tube):
    def treatment():
        stent = Stent(6.0, placement=AtCenter([0, 0, 20.0]), length=12.0)
        surface = a_tube.surface.with_points(a_tube.points)
        return Treatment(surface, [stent], a_tube.centerline, DeploymentSettings(certify=False))

    plain, beside = treatment().result.stents[0], treatment()
    with ThreadPoolExecutor(max_workers=1) as pool:
        survey = pool.submit(getattr, beside, "survey")
        for _ in beside:
            pass
        before = survey.result().before
    told = beside.result.stents[0]
    assert told.around_before is before
    for one, other in ((told.around_before, plain.around_before), (told.after, plain.after)):
        np.testing.assert_array_equal(one.inscribed_diameter, other.inscribed_diameter)
        np.testing.assert_array_equal(one.equivalent_diameter, other.equivalent_diameter)
