"""Distances, inscribed spheres, diameters and stretch."""

import numpy as np
import pytest
from deployment_cases import phantom
from plain_measuring import measured_around
from seeds import seeds
from test_vessel_ends import LENGTH, RADIUS, a_capped_duct, a_circle

from benchmarks.phantoms import stenosed_tube, straight_tube
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import (
    DiameterProfile,
    ExtendedAxis,
    axis_stations,
    diameter_profile,
    displacements,
    equivalent_diameters,
    extended_axis,
    face_stretches,
    inscribed_spheres,
)
from SDFStentLib.plan import read_input_files
from SDFStentLib.validation import InputError


def a_tube(outline, heights):
    """Open tube with the cross-section `outline` (k, 2), scaled by nothing, at `heights`."""
    outline, heights = np.asarray(outline, float), np.asarray(heights, float)
    count = len(outline)
    points = np.concatenate(
        [np.column_stack([outline, np.full(count, height)]) for height in heights]
    )
    ring = np.arange(count)
    after = (ring + 1) % count
    layers = [
        np.concatenate(
            [
                np.column_stack([base + ring, base + after, base + count + after]),
                np.column_stack([base + ring, base + count + after, base + count + ring]),
            ]
        )
        for base in range(0, count * (len(heights) - 1), count)
    ]
    return points, np.concatenate(layers)


def an_ellipse(count, a, b, turn=0.0):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False) + turn
    return np.column_stack([a * np.cos(angle), b * np.sin(angle)])


def a_round_tube(radius=4.0, count=40, length=40.0, spacing=1.0):
    return a_tube(an_ellipse(count, radius, radius), np.arange(0, length + spacing / 2, spacing))


def stations(*rows):
    return np.array(rows, dtype=float)


def upward(count):
    return np.tile([0.0, 0.0, 1.0], (count, 1))


def largest_circle_in_convex_polygon(outline):
    """Chebyshev center by linear programming: an oracle that shares nothing with the search."""
    from scipy.optimize import linprog

    sides = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([sides[:, 1], -sides[:, 0]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    limits = np.einsum("ij,ij->i", normals, outline)
    solved = linprog(
        [0, 0, -1],
        A_ub=np.column_stack([normals, np.ones(len(outline))]),
        b_ub=limits,
        bounds=[(None, None)] * 3,
    )
    return -solved.fun


# Inscribed spheres


@pytest.mark.parametrize("seed", range(4))
def test_the_sphere_in_a_random_convex_polygon_is_its_largest_circle(seed):
    from scipy.spatial import ConvexHull

    scattered = np.random.default_rng(seed).normal(size=(14, 2)) * [4, 2]
    outline = scattered[ConvexHull(scattered).vertices]
    points, triangles = a_tube(outline, np.arange(0, 61, 3.0))
    starts = np.array([np.append(w @ outline, 30.0) for w in _weights(seed, len(outline), 6)])
    found = inscribed_spheres(points, triangles, starts, upward(6))
    expected = largest_circle_in_convex_polygon(outline)
    np.testing.assert_allclose(found.radii, expected, rtol=0, atol=1e-4)


def _weights(seed, corners, count):
    return np.random.default_rng(seed + 100).dirichlet(np.ones(corners), size=count)


def test_a_sphere_does_not_pass_through_the_wall_into_a_larger_vessel_beside():
    narrow, wide = an_ellipse(24, 1, 1), an_ellipse(48, 6, 6) + np.array([7.05, 0])
    first, first_triangles = a_tube(narrow, np.arange(0, 41, 0.5))
    second, second_triangles = a_tube(wide, np.arange(0, 41, 0.5))
    points = np.concatenate([first, second])
    triangles = np.concatenate([first_triangles, second_triangles + len(first)])
    assert len(triangles) > 4000, "large enough that the search is first made on a part of it"
    found = inscribed_spheres(points, triangles, stations([0.9, 0, 20], [0, 0.5, 21]), upward(2))
    np.testing.assert_allclose(found.radii, np.cos(np.pi / 24), rtol=0, atol=1e-5)


# Cross-sections and profiles


def test_a_plane_through_vertices_still_finds_its_closed_loop():
    from scipy.spatial.transform import Rotation

    points, triangles = a_round_tube(radius=4.0, count=24)
    area = 24 / 2 * 16 * np.sin(2 * np.pi / 24)
    rotation = Rotation.from_euler("xyz", [0.3, 1.1, -0.7])
    centers = np.column_stack([np.zeros((30, 2)), np.arange(5.0, 35.0)])
    found = equivalent_diameters(
        rotation.apply(points) + 3,
        triangles,
        rotation.apply(centers) + 3,
        rotation.apply(upward(30)),
    )
    np.testing.assert_allclose(found, 2 * np.sqrt(area / np.pi), rtol=0, atol=1e-6)


def test_outside_every_loop_there_is_no_equivalent_diameter():
    tube = a_round_tube(radius=4.0)
    found = equivalent_diameters(*tube, stations([5, 0, 20], [0, 0, 90]), upward(2))
    assert np.isnan(found).all()
    with pytest.raises(InputError, match="directions: expected one for each of the 1 centers"):
        equivalent_diameters(*tube, [[0, 0, 1]], upward(2))
    with pytest.raises(InputError, match="directions: expected no zero vector"):
        equivalent_diameters(*tube, [[0, 0, 1]], [[0, 0, 0]])


def test_stations_far_apart_have_the_places_and_planes_of_the_axis_not_of_its_chords():
    """Along a hairpin every 12 mm: positions fell behind by a tenth, and sections lay askew."""
    made = phantom("hairpin_tube", edge_length=0.8)
    (line,) = (
        made.centerline.points[made.centerline.ancestry(leaf)] for leaf in made.centerline.leaves
    )
    far, near = (diameter_profile(made.surface, line, spacing) for spacing in (12.0, 1.0))
    assert len(far.arc_length) == 1 + round(Line(line).length / 12)
    assert far.arc_length[-1] == pytest.approx(Line(line).length, abs=0.05)
    np.testing.assert_allclose(np.diff(far.arc_length), far.arc_length[1], rtol=0.01)
    for name in ("inscribed_diameter", "equivalent_diameter"):
        of_near = np.interp(far.arc_length, near.arc_length, getattr(near, name))
        np.testing.assert_allclose(getattr(far, name)[1:-1], of_near[1:-1], atol=0.03)


def test_the_part_of_a_profile_holds_the_stations_between_two_positions():
    profile = a_profile([8, 6, 4, 6, 8])
    part = profile.over(1, 3)
    np.testing.assert_array_equal(part.inscribed_diameter, [6, 4, 6])
    np.testing.assert_array_equal(part.arc_length, [1, 2, 3])
    with pytest.raises(InputError, match=r"a part of 0 to 4 mm that holds a station, got 1\.2 to"):
        profile.over(1.2, 1.8)


def test_stations_outside_the_surface_have_no_diameter_and_it_is_said_where():
    points, triangles = a_round_tube(radius=4.0, length=20)
    profile = diameter_profile(Surface(points, triangles), [[0, 0, -5], [0, 0, 25]], spacing=1.0)
    outside = (profile.arc_length < 4) | (profile.arc_length > 26)
    inside = (profile.arc_length > 6) & (profile.arc_length < 24)
    assert np.isnan(profile.inscribed_diameter[outside]).all()
    assert np.isnan(profile.equivalent_diameter[outside]).all()
    assert np.isfinite(profile.inscribed_diameter[inside]).all()
    assert any(
        "No inscribed diameter at" in str(gap) and "0.0 to" in str(gap) for gap in profile.gaps
    )
    assert profile.minimum > 0


def a_profile(inscribed, equivalent=None):
    inscribed = np.array(inscribed, dtype=float)
    equivalent = inscribed if equivalent is None else np.array(equivalent, dtype=float)
    count = len(inscribed)
    return DiameterProfile(np.arange(count), np.zeros((count, 3)), inscribed, equivalent)


# Stretch


def test_stretches_of_an_affine_map_are_its_singular_values():
    rng = np.random.default_rng(7)
    points = np.column_stack([rng.normal(size=(60, 2)), np.zeros(60)])
    triangles = np.arange(60).reshape(-1, 3)
    gradient = rng.normal(size=(3, 2))
    after = points[:, :2] @ gradient.T + [1, 2, 3]
    largest, smallest = np.linalg.svd(gradient, compute_uv=False)
    found = face_stretches(Surface(points, triangles), after)
    np.testing.assert_allclose(found.largest, largest, rtol=1e-8)
    # The difference of two nearly equal roots loses some digits in needles.
    np.testing.assert_allclose(found.smallest, smallest, rtol=1e-6)
    np.testing.assert_allclose(found.area, largest * smallest, rtol=1e-6)


def test_displacements_are_lengths():
    np.testing.assert_allclose(displacements([[0, 0, 0]], [[3, 4, 0]]), 5)


# One profile over a stent and its surroundings, against profiles of the whole vessel.


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


def test_between_a_stent_and_the_inlet_of_a_patient_it_is_as_wide(data_dir, sweep):
    made = sweep.vessel("pulmonary")
    tree = made.centerline
    leaf = tree.points[np.sort(tree.leaves)[0]]
    way = tree.path(tree.points[tree.roots[0]], leaf).points
    axis = extended_axis(made.surface, Line(way).cut(6.0, 32.0).points, tree)
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


@pytest.mark.parametrize("seed", seeds(1, 4))
def test_a_throat_between_two_stations_is_as_narrow_as_it_is(seed):
    random = np.random.default_rng([seed, 12])
    for _ in range(3):
        throat, length = random.uniform(0.8, 2.0), random.uniform(3.0, 6.0)
        made = stenosed_tube(3.0, throat, 30, 0.2, stenosis_length=length)
        first, last = 15 - random.uniform(4, 6), 15 + random.uniform(4, 6)
        profile = diameter_profile(made.surface, made.axis_at(np.array([first, last])))
        assert profile.minimum == pytest.approx(2 * throat, rel=0.01)
        assert first + profile.minimum_arc_length == pytest.approx(15, abs=0.2)
        left = profile.over(0, 13 - first)
        assert left.minimum == left.inscribed_diameter.min()
        beside = profile.taken(np.abs(first + profile.arc_length - 15) > 1)  # on both sides
        assert beside.minimum == beside.inscribed_diameter.min()


def test_a_profile_through_a_lesion_is_as_narrow_as_the_lesion(data_dir):
    files = (data_dir / f"su0243_{kind}_mm.vtp" for kind in ("surface", "centerline"))
    vessel = read_input_files(*map(str, files)).vessel
    assert len(vessel.lesions) > 9
    for lesion in vessel.lesions:
        # At an ostium the narrowest place is at one end, with no station on both sides of it.
        minimum = diameter_profile(vessel.surface, lesion.line, 0.25).minimum
        assert minimum == pytest.approx(lesion.minimum_diameter, rel=0.005)
