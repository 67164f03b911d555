"""A stent to look at: where its struts are, how many, how they are joined, and no twist."""

import json
from pathlib import Path

import numpy as np
import pytest
from polydata_cases import read_by_vtk
from tube_files import deploy, plan_of, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

from benchmarks.phantoms import straight_tube
from SDFStentLib.cli import main
from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Line, carried
from SDFStentLib.stent import (
    AlongAxis,
    LatticeDesign,
    Shape,
    Stent,
    StentEnd,
    Waist,
    stent_axis,
    stent_lattice,
)
from SDFStentLib.stent.lattice import straight_lattice
from SDFStentLib.treatment.profile import with_profile

DESIGNS = [
    LatticeDesign(crowns=8, rings=5),
    LatticeDesign(crowns=5, rings=1, link_every=1),
    LatticeDesign("open", crowns=8, rings=5),
    LatticeDesign("open", crowns=6, rings=4, link_every=3),
    LatticeDesign("open", crowns=9, rings=7, link_every=1),
]
designs = pytest.mark.parametrize("design", DESIGNS, ids=str)


def arc(radius=20.0, angle=1.5, count=60_001):
    """An arc in the plane z = 0 about the origin, so fine that its chords are it to 1e-8 mm."""
    at = np.linspace(0, angle, count)
    return radius * np.stack([np.cos(at), np.sin(at), 0 * at], axis=1)


def helix(radius=12.0, pitch=8.0, turns=1.25, count=4001):
    at = np.linspace(0, 2 * np.pi * turns, count)
    return np.stack([radius * np.cos(at), radius * np.sin(at), pitch * at / (2 * np.pi)], axis=1)


# Struts


@designs
def test_struts_lie_on_the_radius_and_between_the_ends(design):
    lattice = straight_lattice(18.0, 3.5, design)
    np.testing.assert_allclose(np.hypot(*lattice.points[:, :2].T), 3.5, atol=1e-12)
    assert lattice.points[:, 2].min() == pytest.approx(-9, abs=1e-12)
    assert lattice.points[:, 2].max() == pytest.approx(9, abs=1e-12)
    assert len(np.unique(lattice.lines)) == len(lattice.points)


# Where it lies


def a_stent(axis, diameter=6.0, **more):
    stent = Stent(diameter, placement=AlongAxis(axis), **more)
    return stent, stent_axis(stent)


@designs
def test_along_an_arc_the_struts_lie_on_the_radius_around_it(design):
    line = arc()
    lattice = stent_lattice(*a_stent(line), design)
    x, y, z = lattice.points.T
    # From the circle in space, which the axis is; away from the ends, where directions are exact.
    distance = np.hypot(np.hypot(x, y) - 20, z)
    at = np.arctan2(y, x) * 20
    inside = (at > 3) & (at < Line(line).length - 3)
    np.testing.assert_allclose(distance[inside], 3, atol=1e-6)
    np.testing.assert_allclose(distance, 3, atol=2e-6)
    assert inside.mean() > 0.5


def test_a_shape_is_followed_and_grows_in_proportion():
    tube = straight_tube(radius=2.0, length=40.0)
    shape = Shape(waist=Waist(4.5, 0.4), end=StentEnd(8.0, 5.0))
    stent = Stent(6.0, placement=AlongAxis(tube.axis_at([10, 30])), shape=shape)
    axis = with_profile(stent_axis(stent), stent, tube.surface)
    design = LatticeDesign(rings=9, crimped_diameter=2.0)
    for expansion, widest in ((1.0, 8.0), (0.5, 5.0), (0.0, 2.0)):
        points = stent_lattice(stent, axis, design, expansion).points
        along = (points[:, 2] - 10) / 20
        wanted = axis.profile.at(along) / 2 * widest / 8
        np.testing.assert_allclose(np.hypot(*points[:, :2].T), wanted, atol=1e-6)


# Without twist


def double_reflection(points, along, first):
    """Normals of minimal twist by Wang and others (ACM TOG 27, 2008): two mirrors a step."""
    normals = [first]
    for here, there, old, new in zip(points, points[1:], along, along[1:], strict=False):
        way = there - here
        mirrored = [one - 2 / (way @ way) * (way @ one) * way for one in (normals[-1], old)]
        other = new - mirrored[1]
        size = other @ other
        turned = mirrored[0] - (2 / size * (other @ mirrored[0]) * other if size > 0 else 0)
        normals.append(turned)
    return np.array(normals)


def test_a_body_is_carried_without_twist():
    """Against mirrors, and against the torsion of a helix: -tau L to the Frenet normal."""
    radius, pitch = 12.0, 8.0
    line = helix(radius, pitch)
    total = Line(line).length
    at = np.linspace(-total / 2, total / 2, 400)
    seam = carried(np.stack([0 * at + 1, 0 * at, at], axis=1), Line(line), window=0.2)
    spine = carried(np.stack([0 * at, 0 * at, at], axis=1), Line(line), window=0.2)
    normals = seam - spine
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-9)

    own = Line(line).directions
    truth = double_reflection(line, own, normals[0] - (normals[0] @ own[0]) * own[0])
    wanted = np.stack(
        [np.interp(at + total / 2, Line(line).arc_lengths, one) for one in truth.T], 1
    )
    np.testing.assert_allclose(normals, wanted, atol=2e-3)

    rise = pitch / (2 * np.pi)
    torsion = rise / (radius**2 + rise**2)
    phase = np.linspace(0, 2 * np.pi * 1.25, 400)
    inward = -np.stack([np.cos(phase), np.sin(phase), 0 * phase], axis=1)
    tangent = np.stack([-radius * np.sin(phase), radius * np.cos(phase), 0 * phase + rise], 1)
    across = np.cross(tangent / np.linalg.norm(tangent, axis=1, keepdims=True), inward)
    angle = np.unwrap(np.arctan2(np.sum(normals * across, 1), np.sum(normals * inward, 1)))
    np.testing.assert_allclose((angle - angle[0])[5:-5], (-torsion * (at - at[0]))[5:-5], atol=2e-3)


# The stents as a file: struts, or the user's straight mesh, where the plan puts them.


def read(path):
    data = read_by_vtk(Path(path))
    cells = data.GetCellData()
    arrays = {
        cells.GetArrayName(number): vtk_to_numpy(cells.GetArray(number))
        for number in range(cells.GetNumberOfArrays())
    }
    return data, vtk_to_numpy(data.GetPoints().GetData()), arrays


def test_the_stents_of_a_plan_are_told_apart_and_open_cells_drawn_open(a_folder):
    device = {"name": "mine", "cell": "open", "generic": True, "foreshortening_fraction": 0.0}
    stents = [
        {"diameter": 6, "length": 8, "placement": {"center": [0, 0, 1.2]}, "enabled": False},
        {"diameter": 6, "length": 8, "placement": {"center": [0, 0, 1.7]}},
        {"diameter": 6.5, "length": 8, "placement": {"center": [0, 0, 2.4]}, "device": device},
    ]
    Path("plan.json").write_text(json.dumps(plan_of(*stents)), encoding="utf-8")
    assert main(["run", "plan.json", "-o", "out", "--export-device", "d.vtp", "--quiet"]) == 0
    data, points, arrays = read("d.vtp")
    assert np.unique(arrays["Stent"]).tolist() == [2, 3]
    assert np.unique(arrays["Stent"][arrays["IsLink"] == 1]).tolist() == [3]
    for number, radius, middle in ((2, 0.3, 1.7), (3, 0.325, 2.4)):
        own = [
            data.GetCell(int(cell)).GetPointId(place)
            for cell in np.flatnonzero(arrays["Stent"] == number)
            for place in range(data.GetCell(int(cell)).GetNumberOfPoints())
        ]
        np.testing.assert_allclose(np.hypot(*points[own, :2].T), radius, atol=1e-7)
        assert np.mean([points[own, 2].min(), points[own, 2].max()]) == pytest.approx(middle)


def test_a_straight_mesh_of_ones_own_is_laid_where_the_stent_is(a_folder):
    body = straight_tube(radius=2.0, length=16.0, edge_length=1.0)
    centered = body.points - [0, 0, 8]
    write_wall(Path("mesh.vtp"), centered / 10, body.triangles)
    assert deploy("--export-device", "d.vtp", "--device-mesh", "mesh.vtp", "--quiet") == 0
    made = read_surface("d.vtp", "cm")
    np.testing.assert_array_equal(made.surface.triangles, body.triangles)
    # The axis is z, upward or downward; the middle of the stent is at 20 mm.
    np.testing.assert_allclose(np.abs(made.points[:, 2] - 20), np.abs(centered[:, 2]), atol=1e-6)
    np.testing.assert_allclose(
        np.hypot(*made.points[:, :2].T), np.hypot(*centered[:, :2].T), atol=1e-6
    )
