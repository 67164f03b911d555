"""Surfaces by closed forms: box, tetrahedron, sphere, torus, and what is broken in known ways."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from SDFStentLib.geometry import (
    Surface,
    face_areas,
    face_normals,
    oriented_triangles,
    plane_section,
    signed_volume,
    topology,
)


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


# ---------------------------------------------------------------------------- inside or outside


def test_rays_through_vertices_and_edges_are_counted_once():
    points, triangles = _box((2.0, 2.0, 2.0))
    inside = [[1, 1, 1], [1, 1, 0.5], [0.5, 0.5, 1], [1.5, 0.5, 1]]
    outside = [[1, 1, -1], [1, 1, 3], [3, 1, 1], [-1, -1, -1], [1, 5, 1]]
    found = Surface(points, triangles).contains(np.array(inside + outside))
    assert found.tolist() == [True] * 4 + [False] * 5
    ridge = np.vstack([points, [1, 1, 5]])
    roof = np.r_[triangles[:-2], [[1, 5, 8], [5, 7, 8], [7, 3, 8], [3, 1, 8]]]
    assert topology.surface_topology(roof).is_closed
    along = np.array([[1.0, 1, 1], [1, 1, 4], [1, 1, 6]])
    assert Surface(ridge, roof).contains(along).tolist() == [True, True, False]


# ------------------------------------------------------------------------------ parts of a surface
