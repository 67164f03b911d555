"""Wall inside of a stent that no inscribed sphere sees: pushed out, or told by the certificate."""

from itertools import pairwise

import numpy as np
import pytest
from deployment_cases import anatomy, arc, phantom
from scipy.spatial import KDTree

from SDFStentLib.deformation import DeploymentSettings, deploy
from SDFStentLib.deformation.wall_around import WallAround
from SDFStentLib.deformation.wall_check import wall_check
from SDFStentLib.field import CapsuleChain, RadiusShares, fractions_of
from SDFStentLib.geometry import Line, SurfaceIndex
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.stent import AlongAxis, AtCenter, Shape, Stent, StentEnd, Waist
from SDFStentLib.treatment import Treatment


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


# Stents whose radius changes within an edge of the mesh: the wall against a plain measurement.

STEPS = {
    "step": Shape(table=((0, 6.6), (0.5, 6.6), (0.51, 9.0), (1, 9.0))),
    "ridge": Shape(table=((0, 7.0), (0.45, 7.0), (0.5, 9.0), (0.55, 7.0), (1, 7.0))),
    "groove": Shape(waist=Waist(6.6, 0.5, 2.0)),
    "short flares": Shape(start=StentEnd(10.0, 1.0), end=StentEnd(10.0, 1.0)),
    "flat ends": Shape(start=StentEnd(10.0, 1.5), cap_height=0.1),
    "saw": Shape(table=tuple((i / 10, 8.0 + (i % 2)) for i in range(11))),
}
"""Of 8 to 9 mm in a stent of 16 mm, on edges of 0.5 to 1 mm."""

TOLERANCE = 0.03
"""Share of the stent's radius by which the wall of a certified stent may lie inside."""

ALONG = 0.05
"""Of the profile along a bent axis of nodes every millimeter, mm; in a step that is half of it."""


def dense(surface, near, reach) -> np.ndarray:
    """Places all over the triangles that come near to some points."""
    triangles = surface.triangles
    close = KDTree(near).query(surface.points[triangles].mean(axis=1))[0] < reach
    weights = np.array([(i, j, 10 - i - j) for i in range(11) for j in range(11 - i)]) / 10
    return np.einsum("pc,tcx->tpx", weights, surface.points[triangles[close]]).reshape(-1, 3)


def over_profile(surface, axis, profile) -> np.ndarray:
    """Distance of the wall from the axis over the stent's radius there, by dense samples of both.

    Rows of this share and of the part of the axis that lies before its foot; the ends left out.
    """
    at = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))])
    fine = np.linspace(0, at[-1], int(at[-1] / 0.02))
    line = np.column_stack([np.interp(fine, at, column) for column in axis.T])
    wall = dense(surface, line[::20], 1.2 * profile.widest)
    distance, nearest = KDTree(line).query(wall)
    part = fine[nearest] / at[-1]
    shifted = part + np.array([[-ALONG], [0], [ALONG]]) / at[-1]
    prescribed = np.interp(shifted, profile.fractions, profile.diameters).min(axis=0)
    share = 2 * distance / prescribed
    beside = (nearest > 10) & (nearest < len(line) - 11)
    return np.column_stack([share, part])[beside]


def treated(vessel, shape, ends=(12.0, 28.0), diameter=8.0):
    axis = vessel.axis_at(np.linspace(*ends, 200))
    stent = Stent(max(row[1] for row in shape.table) if shape.table else diameter,
                  placement=AlongAxis(axis), shape=shape)  # fmt: skip
    return Treatment(vessel.surface, [stent], vessel.centerline)


def assert_certified_without_wall_inside(treatment, tolerance=TOLERANCE):
    result = treatment.result
    assert result.certificate.passed, result.certificate.sentence()
    (stent,) = result.stents
    shares = over_profile(result.surface, stent.axis.points, stent.axis.profile)
    assert shares[:, 0].min() > 1 - tolerance


@pytest.mark.parametrize(
    ("phantom_name", "edge_length"),
    [("stenosed_tube", 0.5), pytest.param("bent_tube", 1.0, marks=pytest.mark.bench)],
)
@pytest.mark.parametrize("name", STEPS)
def test_no_wall_lies_inside_of_a_steep_stent(name, phantom_name, edge_length):
    vessel = phantom(phantom_name, edge_length=edge_length)
    assert_certified_without_wall_inside(treated(vessel, STEPS[name]))


def test_a_long_edge_is_looked_at_in_more_places():
    vessel = phantom("stenosed_tube", radius=5.0, throat_radius=3.5, edge_length=3.0)
    step = Shape(table=((0, 10.0), (0.5, 10.0), (0.51, 13.0), (1, 13.0)))
    assert_certified_without_wall_inside(treated(vessel, step), 0.02)  # three places leave 0.03


@pytest.mark.parametrize("shape", [
    Shape(waist=Waist(7.0, 0.5, 3.0)),
    Shape(table=((0, 8.0), (0.4, 10.0), (0.45, 8.0), (1, 9.0))),
])  # fmt: skip
def test_in_a_patients_vessel_no_wall_lies_inside_of_a_certified_stent(data_dir, shape):
    vessel = anatomy(data_dir, "pulmonary")
    tree = vessel.centerline
    left = tree.points[max(tree.leaves, key=lambda leaf: tree.points[leaf][0])]
    path = tree.path(tree.points[tree.roots[0]], left)
    center = path.points[np.searchsorted(np.linspace(0, path.length, len(path.points)), 60.0)]
    stent = Stent(10.0, placement=AtCenter(center), length=20.0, shape=shape)
    assert_certified_without_wall_inside(Treatment(vessel.surface, [stent], tree))


def test_the_certificate_notices_wall_inside_of_a_wide_part_that_no_sphere_sees():
    treatment = treated(phantom("stenosed_tube", edge_length=0.5), STEPS["ridge"])
    for _ in treatment:
        pass
    deployment = treatment._stages[0].deployment
    (check,) = deployment.lumen_checks(treatment.surface, deployment.result.surface)
    assert check.passed
    points = deployment.result.surface.points.copy()
    on_ridge = (np.abs(points[:, 2] - 20) < 0.7) & (points[:, 0] > 4)
    points[on_ridge, :2] *= 0.92
    dented = deployment.result.surface.with_points(points)
    (check,) = deployment.lumen_checks(treatment.surface, dented)
    assert not check.is_narrow
    assert not check.passed
    found = over_profile(dented, deployment.chain.nodes, STEPS["ridge"].along(9.0, 16.0))[:, 0]
    # The way out is across the ridge's slope: 1 mm of radius over 0.8 mm of length.
    across = (1 - found.min()) * check.wall.prescribed * 0.8 / np.hypot(1, 0.8)
    assert check.wall.depth == pytest.approx(across, abs=0.04)
    assert f"wall {check.wall.depth:.2f} mm inside of the stent" in check.fault()
    assert check.as_dict()["wall"]["inside_mm"] == check.wall.depth


def test_feet_on_an_axis_of_few_nodes_are_those_on_the_curve():
    """Outside of a bend many points are nearest to a single node."""
    bend = 12.0
    nodes = arc(bend, 90.0, count=20)
    axis, back = Line(nodes), Line(nodes[::-1])
    angle = np.linspace(0.02, np.pi / 2 - 0.02, 500)
    for side in (-4.0, 4.0):
        far = bend + side
        points = np.column_stack([far * np.sin(angle), 0 * angle, bend - far * np.cos(angle)])
        found = fractions_of(points, axis)
        np.testing.assert_allclose(found, angle / (np.pi / 2), rtol=0, atol=1e-3)
        np.testing.assert_allclose(fractions_of(points, back), 1 - found, atol=1e-12)
    beyond = np.array([[-3.0, 0, 1.0], [bend + 1, 0, bend + 2.0]])
    assert fractions_of(beyond, axis).tolist() == [0.0, 1.0]
