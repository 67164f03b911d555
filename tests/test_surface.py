"""Surfaces by closed forms: box, tetrahedron, sphere, torus, and what is broken in known ways."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_files import octahedron

from benchmarks.phantoms import bent_tube, straight_tube
from SDFStentLib.geometry import (
    Surface,
    as_surface,
    cut_along,
    face_areas,
    face_normals,
    flat_fill,
    oriented_triangles,
    plane_section,
    section_around,
    signed_volume,
    state_of,
    topology,
)
from SDFStentLib.geometry.fans import fans_by_graph, fans_by_walking
from SDFStentLib.geometry.flat_fill import _ears
from SDFStentLib.validation import InputError


def _box(size=(1.0, 2.0, 3.0)):
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    return points * size, triangles


def _torus(around=24, across=12, large=3.0, small=1.0):
    u = 2 * np.pi * np.arange(around)[:, None] / around
    v = 2 * np.pi * np.arange(across) / across
    ring = large + small * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), small * np.sin(v) + 0 * u], axis=-1)
    i, j = (a.ravel() for a in np.mgrid[:around, :across])
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return points.reshape(-1, 3), np.r_[np.c_[a, b, c], np.c_[a, c, d]]


# ------------------------------------------------------------------------------------- geometry


def test_areas_volume_and_normals_of_a_box():
    points, triangles = _box()
    assert face_areas(points, triangles).sum() == pytest.approx(22, rel=1e-14)
    assert signed_volume(points, triangles) == pytest.approx(6, rel=1e-14)
    assert signed_volume(points, triangles[:, ::-1]) == pytest.approx(-6, rel=1e-14)
    outward = points[triangles].mean(axis=1) - points.mean(axis=0)
    normals = face_normals(points, triangles)
    assert np.allclose(np.abs(normals).max(axis=1), 1, rtol=0, atol=1e-15)
    assert np.all(np.einsum("ij,ij->i", normals, outward) > 0)


# ------------------------------------------------------------------------------------- topology


# ----------------------------------------------------------------------------------- orientation


@pytest.mark.parametrize("seed", range(5))
def test_any_mixture_of_windings_becomes_outward(seed):
    rng = np.random.default_rng(seed)
    points, triangles = _torus()
    both = np.r_[triangles, triangles + len(points)]
    points = np.r_[points, points + np.array([20, 0, 0])]
    mixed = both.copy()
    turned = rng.random(len(both)) < rng.random()
    mixed[turned] = mixed[turned][:, ::-1]
    oriented = oriented_triangles(points, mixed)
    agree = face_normals(points, oriented) - face_normals(points, both)
    assert np.array_equal(np.sort(oriented, axis=1), np.sort(both, axis=1))
    assert np.abs(agree).max() < 1e-12  # the same cross products from other corners
    assert topology.surface_topology(oriented).is_consistently_wound


# -------------------------------------------------------------------------------------- sections


def _area(loop, normal):
    shifted = loop.points - loop.points[0]
    following = np.roll(shifted, -1, axis=0)
    return 0.5 * np.cross(shifted, following).sum(axis=0) @ normal / np.linalg.norm(normal)


def test_a_cut_through_an_open_rim_is_an_open_polyline():
    points, triangles = _box()
    loops = plane_section(points, triangles[2:], [0, 0, 1.0], [0, 0, 1])
    assert [loop.is_closed for loop in loops] == [False]
    ends = loops[0].points[[0, -1]]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(2.0, rel=1e-14)  # the missing wall


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10**6),
    st.tuples(st.integers(-2, 2), st.integers(-2, 2), st.integers(-2, 2)).filter(any),
)
def test_a_closed_surface_is_only_ever_cut_in_closed_loops(seed, normal):
    # Planes through a vertex with small whole normals run along edges and through many vertices.
    points, triangles = _torus(8, 8)
    origin = points[np.random.default_rng(seed).integers(len(points))]
    loops = plane_section(points, triangles, origin, normal)
    assert all(loop.is_closed for loop in loops)
    for loop in loops:
        heights = (loop.points - origin) @ (np.array(normal) / np.linalg.norm(normal))
        assert np.abs(heights).max() < 1e-14 * 10


def test_the_areas_of_many_cuts_add_up_to_the_volume():
    points, triangles = _torus(24, 12)
    normal = np.array([1.0, 2.0, 2.0]) / 3
    stations = np.linspace(-5, 5, 1001)
    sections = [plane_section(points, triangles, s * normal, normal) for s in stations]
    areas = [_area(loop, normal) for loops in sections for loop in loops]
    # Trapezium rule over pieces of parabolas: 1000 steps leave about 4e-5.
    volume = np.sum(areas) * (stations[1] - stations[0])
    assert volume == pytest.approx(signed_volume(points, triangles), rel=1e-4)


# ------------------------------------------------------------------------------ parts of a surface


# A surface is one value: checked once, never changed, and its topology looked at once.


def test_nothing_of_a_surface_can_be_changed():
    made = Surface(*octahedron())
    arrays = (made.points, made.triangles, *made.neighbors, made.face_normals, made.vertex_normals)
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.points = made.points


def test_another_state_is_given_as_points_or_as_a_surface():
    made = Surface(*octahedron())
    with pytest.raises(InputError, match=r"expected .* points as before, got 1"):
        made.with_points(made.points[:1])
    with pytest.raises(InputError, match="surface points: expected finite coordinates"):
        made.with_points(np.full_like(made.points, np.inf))
    with pytest.raises(InputError, match=r"got 'ndarray'; make one of arrays by Surface\(points"):
        as_surface(np.eye(3))
    moved = made.with_points(1.1 * made.points)
    assert state_of(made, moved) is moved
    copy = Surface(moved.points, made.triangles)
    for other in (copy, moved.points, moved.points.tolist()):
        state = state_of(made, other)
        assert np.array_equal(state.points, moved.points)
        assert state.triangles is made.triangles
    with pytest.raises(InputError, match=r"after: expected .* points as before, got 1"):
        state_of(made, made.points[:1])
    turned = Surface(made.points, made.triangles[:, ::-1])
    with pytest.raises(InputError, match="after: expected the triangles of the surface before"):
        state_of(made, turned)


# Fans of faces round the vertices: the walk that is fast against the graph that is plain.


def torus(rows=12, columns=9):
    """Triangles of a closed grid in both directions."""
    number = np.arange(rows * columns).reshape(rows, columns)
    right, up = np.roll(number, -1, axis=1), np.roll(number, -1, axis=0)
    across = np.roll(right, -1, axis=0)
    first = np.stack([number, right, across], axis=2).reshape(-1, 3)
    second = np.stack([number, across, up], axis=2).reshape(-1, 3)
    return np.concatenate([first, second])


def fan_counts(triangles):
    corners = triangles.ravel()
    _, sides, is_first = topology._sorted_sides(triangles)
    starts = np.flatnonzero(is_first)
    pairs = starts[np.diff(starts, append=len(sides)) == 2]
    by_walk = fans_by_walking(corners, sides[pairs], sides[pairs + 1])
    return by_walk, fans_by_graph(corners, *topology._meeting_sides(sides, is_first))


@pytest.mark.parametrize("kept", [1.0, 0.9, 0.5])
@pytest.mark.parametrize("pinches", [0, 1, 3])
def test_fans_are_the_same_by_walking_and_by_graph(kept, pinches):
    rng = np.random.default_rng(7)
    for _ in range(10):
        triangles = torus()
        # Points far apart that become one: two fans meet there.
        number = np.arange(triangles.max() + 1)
        number[np.arange(pinches) * 20 + 5] = np.arange(pinches) * 20 + 54
        triangles = number[triangles[rng.random(len(triangles)) < kept]]
        found = topology.surface_topology(triangles)
        assert found.is_edge_manifold
        assert found.is_consistently_wound
        by_walk, by_graph = fan_counts(triangles)
        assert by_walk == by_graph
        assert found.is_vertex_manifold == (by_graph == len(np.unique(triangles)))
        if kept == 1:
            assert by_graph == len(np.unique(triangles)) + pinches


# Cutting a surface by one plane, and filling what was cut.


def circle(count, radius=3.0):
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def star(count, deep=0.3):
    polygon = circle(count)
    polygon[::2] *= deep
    return polygon


POLYGONS = {
    "triangle": circle(3),
    "circle": circle(60),
    "star": star(30),
    "narrow waist": circle(80) * [1, 0.02]
    + np.outer(np.cos(np.linspace(0, 4 * np.pi, 80)), [0, 0]),
    "square with points on its sides": np.array(
        [[x, 0] for x in range(5)]
        + [[5, y] for y in range(5)]
        + [[5 - x, 5] for x in range(5)]
        + [[0, 5 - y] for y in range(5)],
        float,
    ),
    "long beside short sides": np.vstack([circle(60)[:20], circle(60)[30:31], circle(60)[45:46]]),
    "hook": np.array([[0, 0], [4, 0], [4, 4], [3.9, 4], [3.9, 0.1], [0, 0.1]], float),
}


def area_of(polygon):
    (x, y), (end_x, end_y) = polygon.T, np.roll(polygon, -1, axis=0).T
    return float((x * end_y - y * end_x).sum() / 2)


def assert_filled(polygon, inner, triangles):
    points = np.vstack([polygon, inner])
    first, second, third = points[triangles].transpose(1, 0, 2)
    (ax, ay), (bx, by) = (second - first).T, (third - first).T
    areas = (ax * by - ay * bx) / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(area_of(polygon), rel=1e-12)
    sides = [
        (int(a), int(b)) for row in triangles for a, b in zip(row, np.roll(row, -1), strict=True)
    ]
    border = {side for side in sides if side[::-1] not in sides}
    assert len(set(sides)) == len(sides)
    assert border == {(n, (n + 1) % len(polygon)) for n in range(len(polygon))}
    # Euler: what is bounded by one curve, without a hole.
    assert len(triangles) == len(polygon) + 2 * len(inner) - 2


@pytest.mark.parametrize("name", POLYGONS)
def test_ears_fill_any_polygon(name):
    polygon = POLYGONS[name]
    assert_filled(polygon, np.zeros((0, 2)), _ears(polygon))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.2, 1.0), min_size=5, max_size=60))
def test_any_polygon_seen_from_its_middle_is_filled(radii):
    polygon = circle(len(radii)) * np.array(radii)[:, None]
    fill = flat_fill(polygon)
    assert_filled(polygon, fill.inner, fill.triangles)


def test_a_polygon_that_turns_clockwise_is_not_filled():
    assert flat_fill(circle(20)[::-1]) is None


PLANES = {
    "across": ([0, 0, 20.0], [0, 0, 1.0]),
    "between": ([0, 0, 20.123], [0, 0, -1.0]),
    "oblique": ([0, 0, 20.0], [0.5, 0.2, 1.0]),
    "very oblique": ([0, 0, 20.0], [2.0, 0.0, 1.0]),
}


def cut(surface, origin, normal):
    origin, normal = np.asarray(origin, float), np.asarray(normal, float)
    normal = normal / np.linalg.norm(normal)
    section = section_around(surface.points, surface.triangles, origin, normal)
    return section, cut_along(surface.points, surface.triangles, section, origin, normal), normal


@pytest.mark.parametrize("name", PLANES)
def test_the_area_of_a_section_is_that_of_the_ellipse(name):
    origin, normal = PLANES[name]
    section, _, unit = cut(straight_tube(radius=3.0).surface, origin, normal)
    ellipse = np.pi * 9 / abs(unit[2])
    assert section.area == pytest.approx(ellipse, rel=0.01)


@settings(max_examples=30, deadline=None)
@given(st.floats(3, 27), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_no_plane_across_a_bend_leaves_slivers_or_folds(place, first, second):
    tube = TUBE
    at = int(np.argmin(np.abs(tube.centerline.arc_length - place)))
    origin, ahead = tube.centerline.points[at], tube.centerline.points[at + 1]
    normal = (ahead - origin) / np.linalg.norm(ahead - origin) + [first, second, 0]
    _, found, _ = cut(tube.surface, origin, normal)
    assert len(found.rim)
    whole = Surface(found.points, found.triangles)
    assert whole.topology.is_watertight
    assert face_areas(found.points, found.triangles).min() > 1e-5


TUBE = bent_tube()
