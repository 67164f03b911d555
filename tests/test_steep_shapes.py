"""Stents whose radius changes within an edge of the mesh: the wall against a plain measurement."""

from __future__ import annotations

import numpy as np
import pytest
from deployment_cases import anatomy, arc, phantom
from scipy.spatial import KDTree

from SDFStentLib.field import fractions_of
from SDFStentLib.geometry import Line
from SDFStentLib.stent import AlongAxis, AtCenter, Shape, Stent, StentEnd, Waist
from SDFStentLib.treatment import Treatment

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
    path = tree.path(tree.points[tree.roots[0]], tree.points[np.sort(tree.leaves)[0]])
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
