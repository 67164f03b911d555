"""The part of a surface that can move, and which side of it the lumen is on."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import phantom
from mesh_files import open_tube

from SDFStentLib.deformation.patch import Patch
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Surface


@pytest.fixture(scope="module")
def tube():
    return open_tube(radius=3.0, length=30.0, around=16, along=20)


def middle_of(points, low=10, high=20):
    return np.flatnonzero((points[:, 2] > low) & (points[:, 2] < high))


def normals_of(points, triangles, active, axis):
    patch = Patch.around(Surface(points, triangles), active)
    field = CapsuleChain.along(axis).field(points[active])
    vertices = patch.points(points, points[active])
    return patch.outward_normals(vertices, field.direction, field.distance), field.direction


@pytest.mark.parametrize("winding", ["outward", "inward"])
def test_normals_point_out_of_the_lumen_whatever_the_winding(tube, winding):
    points, triangles = tube
    wound = triangles if winding == "outward" else triangles[:, ::-1]
    normals, direction = normals_of(points, wound, middle_of(points), [[0.0, 0, 5], [0, 0, 25]])
    # Diagonals of the quads tilt a vertex normal by a few degrees.
    assert np.einsum("ij,ij->i", normals, direction).min() > 0.98


def test_mixed_winding_tells_no_side(tube):
    points, triangles = tube
    turned = np.random.default_rng(3).random(len(triangles)) < 0.4
    wound = np.where(turned[:, None], triangles[:, ::-1], triangles)
    patch = Patch.around(Surface(points, wound), middle_of(points))
    field = CapsuleChain.along([[0.0, 0, 5], [0, 0, 25]]).field(points[middle_of(points)])
    vertices = patch.points(points, points[middle_of(points)])
    assert patch.outward_normals(vertices, field.direction, field.distance) is None


@pytest.mark.parametrize("winding", ["outward", "inward"])
def test_the_wall_of_a_vessel_beside_the_stented_one_looks_back_at_the_stent(winding):
    made = phantom("tube_with_neighbor")
    active = middle_of(made.points)
    axis = made.axis_at(np.linspace(10, 30, 50))
    wound = made.triangles if winding == "outward" else made.triangles[:, ::-1]
    normals, direction = normals_of(made.points, wound, active, axis)
    facing = np.einsum("ij,ij->i", normals, direction)
    x, y, _ = made.points[active].T
    own = np.hypot(x, y) < 3.5
    # The own wall is a narrowing cone, at most 25 degrees from the direction.
    assert facing[own].min() > 0.8
    # The neighbor's axis is at x = 8: its near side faces the stent, its far side does not.
    assert facing[~own & (x < 6) & (np.abs(y) < 1)].max() < -0.8
    assert facing[~own & (x > 10) & (np.abs(y) < 1)].min() > 0.8
