"""Wall inside of a stent that no inscribed sphere sees: pushed out, or told by the certificate."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from deployment_cases import phantom

from SDFStentLib.deformation import DeploymentSettings, deploy
from SDFStentLib.deformation.wall_around import WallAround
from SDFStentLib.deformation.wall_check import wall_check
from SDFStentLib.field import CapsuleChain, RadiusShares
from SDFStentLib.geometry import Line, SurfaceIndex
from SDFStentLib.lumen import inscribed_spheres


def depth_of(surface, axis, radius):
    """How far facets reach into a cylinder, mm: dense samples against every piece of its axis."""
    weights = np.array([(i, j, 8 - i - j) for i in range(9) for j in range(9 - i)]) / 8
    places = np.einsum("pc,tcx->tpx", weights, surface.points[surface.triangles]).reshape(-1, 3)
    nearest, beside = np.full(len(places), np.inf), np.zeros(len(places), dtype=bool)
    at, total = 0.0, np.linalg.norm(np.diff(axis, axis=0), axis=1).sum()
    for start, end in pairwise(axis):
        way = end - start
        share = np.clip((places - start) @ way / (way @ way), 0, 1)
        distance = np.linalg.norm(places - start - share[:, None] * way, axis=1)
        along = at + share * np.linalg.norm(way)
        closer = distance < nearest
        nearest[closer] = distance[closer]
        beside[closer] = ((along > radius) & (along < total - radius))[closer]
        at += np.linalg.norm(way)
    return float((radius - nearest[beside]).max())


@pytest.fixture(scope="module")
def a_wide_coarse_tube():
    return phantom("straight_tube", radius=4.4, length=40.0, edge_length=4.0)


@pytest.mark.parametrize("influence", [0.05, 6.5])
def test_edges_that_cut_into_a_stent_between_corners_beside_it_are_pushed_out(
    a_wide_coarse_tube, influence
):
    """Off the middle of a wide lumen, where the spheres are as wide as that."""
    surface = a_wide_coarse_tube.surface
    angle = 2 * np.pi / np.unique(np.round(np.arctan2(*surface.points[:, :2].T), 6)).size / 2
    beside = 0.6 * np.array([np.sin(angle), np.cos(angle), 0])
    axis = np.linspace([0, 0, 8], [0, 0, 32], 40) + beside
    assert depth_of(surface, axis, 3.7) > 0.05 * 3.7
    settings = DeploymentSettings(influence_distance=influence)
    result = deploy(surface, settings.chain(axis), 3.7, settings)
    assert result.certificate.passed, result.certificate.sentence()
    assert depth_of(result.surface, axis, 3.7) < 0.01 * 3.7


def test_capsules_that_cut_the_bends_of_the_axis_are_not_certified():
    """The wall lies on the capsules, inside of the stent along the axis as it was given."""
    made = phantom("bent_tube", edge_length=1.2)
    axis = made.axis_at(np.linspace(14, 30, 20))
    for capsule_length, is_right in ((1.0, True), (8.0, False)):
        settings = DeploymentSettings(capsule_length=capsule_length)
        result = deploy(made.surface, settings.chain(axis), 3.4, settings)
        depth = depth_of(result.surface, axis, 3.4)
        assert (depth < 0.03 * 3.4) == is_right
        assert result.certificate.passed == is_right
    (check,) = result.certificate.lumen
    assert not check.is_narrow
    assert not check.is_wide
    assert check.wall.depth == pytest.approx(depth, abs=0.02)
    assert f"wall {check.wall.depth:.2f} mm inside of the stent" in result.certificate.sentence()
    assert check.as_dict()["wall"]["inside_mm"] == check.wall.depth


def test_the_depth_is_the_shortest_way_out_wherever_in_a_triangle_it_is():
    """Also between the places that are looked at everywhere, and at an end."""
    rng = np.random.default_rng(5001)
    chain = CapsuleChain.along([[0, 0, 0], [0, 0, 20.0]])
    weights = np.array([(i, j, 60 - i - j) for i in range(61) for j in range(61 - i)]) / 60
    found, expected = [], []
    for _ in range(40):
        middle = np.array([rng.uniform(3.9, 4.2), 0, rng.choice([-0.5, 0, 0.4, 8, 19.8, 20.3])])
        corners = middle + rng.uniform(-0.9, 0.9, (3, 3))
        check = wall_check(corners, np.array([[0, 1, 2]]), chain, 4.0)
        places = weights @ corners
        ways = [4.0 - np.hypot(*places[:, :2].T), places[:, 2], 20.0 - places[:, 2]]
        found.append(check.depth)
        expected.append(max(np.min(ways, axis=0).max(), 0.0))
    told = np.array(found) > 0
    assert 10 < told.sum() < 40
    np.testing.assert_allclose(np.array(found)[told], np.array(expected)[told], atol=0.06)
    assert max(np.array(expected)[~told]) < 0.03 * 4.0
    assert (np.array(found) > 0.03 * 4.0).any()


def test_a_stent_with_a_steep_step_is_left_by_the_shortest_way_along_it():
    shares = RadiusShares(np.array([0, 0.5, 0.51, 1]), np.array([0.6, 0.6, 1, 1]))
    chain = CapsuleChain.along([[0, 0, 0], [0, 0, 20.0]], shares=shares)
    triangle = np.array([[3.0, 0, 10.3], [3.0, 0.1, 10.4], [3.0, -0.1, 10.4]])
    check = wall_check(triangle, np.array([[0, 1, 2]]), chain, 4.0)
    assert check.prescribed == 4.0
    # Not 1 mm to the radius of 4 mm: the step, 0.2 mm long and 1.6 mm high, is nearer.
    assert check.depth == pytest.approx(0.325 * 1.6 / np.hypot(1.6, 0.2), abs=0.01)


@pytest.mark.parametrize("edge_length", [0.7, 1.2])
def test_what_the_wall_tells_of_a_station_is_what_searches_find(edge_length):
    tube = phantom("branching_pulmonary_artery", edge_length=edge_length)
    points, triangles = tube.surface.points, tube.surface.triangles
    line = tube.centerline
    stations = line.path(line.points[line.roots[0]], line.points[line.leaves[0]]).points[8:-8]
    exact = SurfaceIndex(points, triangles).distances(stations).distance
    # Not even where the box is too small to hold what is nearest.
    for reach in (30.0, 0.1):
        around = WallAround(points, triangles, stations, reach)
        np.testing.assert_array_equal(around.distances(stations), exact)

    directions = Line(stations).directions
    spheres = inscribed_spheres(points, triangles, stations, directions)
    room = WallAround(points, triangles, stations, 30.0).room(stations, directions)
    holds = np.linalg.norm(spheres.centers - stations, axis=1) < spheres.radii
    assert holds.mean() > 0.9
    assert (room >= spheres.radii - 1e-9)[holds].all()
    assert (room < 1.05 * spheres.radii).any()
    assert (room > 1.05 * spheres.radii).any()
