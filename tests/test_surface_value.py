"""A surface is one value: checked once, never changed, and its topology looked at once."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mesh_files import octahedron

from SDFStentLib.geometry import (
    Precision,
    Surface,
    as_surface,
    state_of,
)
from SDFStentLib.validation import InputError


def test_nothing_of_a_surface_can_be_changed():
    made = Surface(*octahedron())
    arrays = (made.points, made.triangles, *made.neighbors, made.face_normals, made.vertex_normals)
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.points = made.points


@pytest.mark.parametrize(
    ("points", "triangles", "message"),
    [
        (np.zeros((2, 3)), [[0, 1, 1]], "surface points: expected at least 3 points, got 2"),
        (np.zeros((3, 2)), [[0, 1, 2]], r"surface points: expected shape \(n, 3\)"),
        (np.full((3, 3), np.nan), [[0, 1, 2]], "surface points: expected finite coordinates"),
        (np.eye(3), [[0, 1, 3]], "surface triangles: expected point indices from 0 to 2"),
        (np.eye(3), np.empty((0, 3), int), "surface triangles: expected at least one triangle"),
    ],
)
def test_what_is_no_surface_is_refused(points, triangles, message):
    with pytest.raises(InputError, match=message):
        Surface(points, triangles)


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


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"dtype": np.int32}, "dtype: expected a floating type such as float32, got int32"),
        ({"dtype": "nonsense"}, "dtype: expected a floating type"),
        ({"scale": 0.0}, "scale: expected a number greater than 0"),
        ({"dtype": np.float32, "scale": 1e39}, "expected coordinates that fit into float32"),
    ],
)
def test_what_is_no_precision_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        Precision(**values).stored(np.eye(3))


# Fans of faces round the vertices: the walk that is fast against the graph that is plain.
