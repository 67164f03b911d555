"""One profile over a stent and its surroundings, against profiles of the whole vessel."""

from __future__ import annotations

import numpy as np
import pytest
from plain_measuring import measured_around
from test_closed_ends import LENGTH, RADIUS, a_capped_duct, a_circle

from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import ExtendedAxis, axis_stations, diameter_profile, extended_axis
from SDFStentLib.phantoms import straight_tube


def test_the_stent_is_a_slice_of_its_surroundings():
    tube = straight_tube(length=60.0)
    axis = extended_axis(tube.surface, [[0, 0, 20.3], [0, 0, 41.0]], tube.centerline)
    stations = axis_stations(axis)
    around, own = measured_around(tube.surface, stations), stations.own
    alone = diameter_profile(tube.surface, axis.of_stent)
    np.testing.assert_allclose(around.arc_length[own], alone.arc_length, atol=1e-9)
    np.testing.assert_allclose(around.inscribed_diameter[own], alone.inscribed_diameter, atol=1e-3)
    np.testing.assert_allclose(
        around.equivalent_diameter[own], alone.equivalent_diameter, atol=1e-3
    )


@pytest.mark.parametrize("gap", [0.0, 1.0, 2.5, 6.0])
def test_a_stent_before_a_cap_is_in_a_vessel_as_wide_as_it_is(gap):
    """Stations beyond the stent, too: a piece shorter than the vessel is wide has one open end."""
    surface = Surface(*a_capped_duct(a_circle()))
    line = np.array([[0.1, 0, 1e-9], [0.1, 0, LENGTH]])
    axis = ExtendedAxis(Line(line), gap, 15.0)
    profile = measured_around(surface, axis_stations(axis))
    np.testing.assert_allclose(
        profile.inscribed_diameter, 2 * RADIUS * np.cos(np.pi / 32), rtol=1e-4
    )


@pytest.mark.parametrize("start", [6.0])
def test_between_a_stent_and_the_inlet_of_a_patient_it_is_as_wide(start, data_dir, sweep):
    made = sweep.vessel("pulmonary")
    tree = made.centerline
    leaf = tree.points[np.sort(tree.leaves)[0]]
    way = tree.path(tree.points[tree.roots[0]], leaf).points
    axis = extended_axis(made.surface, Line(way).cut(start, start + 26.0).points, tree)
    stations = axis_stations(axis)
    around = measured_around(made.surface, stations)
    whole = diameter_profile(made.surface, way)
    at = Line(way).nearest(stations.points).arc_lengths
    before = (around.arc_length < 0) & (at > 0.5)
    expected = np.interp(at, whole.arc_length, whole.inscribed_diameter)
    np.testing.assert_allclose(around.inscribed_diameter[before], expected[before], rtol=0.02)


@pytest.mark.parametrize("rounding", [-1e-13, 0.0, 1e-13])
def test_a_stent_that_ends_where_the_way_ends_but_for_rounding_has_stations(rounding):
    """The rest of the way, 3e-15 mm long, was cut off and refused: no deployment had a report."""
    line = np.array([[0.0, 0, 0], [0, 0, 4.0], [0, 4.0, 5.0], [0.1, 9.0, 7.0]])
    total = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    stations = axis_stations(ExtendedAxis(Line(line), 5.0, float(total - 5.0 + rounding)))
    # Stations cut the corners of the line.
    assert stations.arc_length[-1] == pytest.approx(total - 5.0, abs=0.01)
    assert stations.own.stop == len(stations.points)
