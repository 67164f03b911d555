"""A surface is one value: checked once, never changed, and its topology looked at once."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mesh_files import octahedron

from SDFStentLib.geometry import Surface, as_surface, state_of, topology
from SDFStentLib.geometry.fans import fans_by_graph, fans_by_walking
from SDFStentLib.validation import InputError


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
