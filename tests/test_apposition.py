"""Where a stent hangs free, how neighbors fare, and diameters beyond its ends."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from deployment_cases import anatomy
from ostium_truth import RayCaster
from vtkmodules.vtkFiltersCore import vtkImplicitPolyDataDistance

from SDFStentLib import phantoms
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Line
from SDFStentLib.stent import AlongAxis, AtCenter, Stent, stent_axis
from SDFStentLib.treatment import Treatment, lumen_into
from SDFStentLib.treatment.warnings import narrowed_neighbors
from SDFStentLib.vessel import NeighborLumen, Ostium, apposition
from SDFStentLib.vessel.apposition import GAP


def test_a_stent_that_touches_no_wall_covers_no_branch():
    made = phantoms.branching_pulmonary_artery()
    tree = made.centerline
    way = tree.path(tree.points[tree.roots[0]], tree.points[tree.leaves[0]])
    place = Line(way.points).at([24.0])[0]
    settings = DeploymentSettings(certify=False)
    found = {}
    for diameter in (0.6, 12.0):
        stent = Stent(diameter, length=14, placement=AtCenter(place))
        (treated,) = Treatment(made.surface, [stent], tree, settings).result.stents
        found[diameter] = treated.apposition.is_loose, [one.is_free for one in treated.branches]
    assert found == {0.6: (True, [True]), 12.0: (False, [False])}


def free_by_vtk(surface, axis, radius):
    """Share of places on a stent that are farther than the gap from any wall, along its axis."""
    distance = vtkImplicitPolyDataDistance()
    distance.SetInput(RayCaster(surface.points, surface.triangles).polydata)
    at = np.r_[0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))]
    along, half = np.linspace(0, at[-1], 41), radius / 2
    middle, ahead, behind = (
        np.column_stack([np.interp(np.clip(along + by, 0, at[-1]), at, one) for one in axis.T])
        for by in (0, half, -half)
    )
    first = np.cross(ahead - behind, [0.3, 0.5, 0.8])
    second = np.cross(ahead - behind, first)
    first, second = (v / np.linalg.norm(v, axis=1)[:, None] for v in (first, second))
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None, None]
    places = middle + radius * (np.cos(angles) * first + np.sin(angles) * second)
    away = [abs(distance.EvaluateFunction(place)) > GAP for place in places.reshape(-1, 3)]
    return along, np.reshape(away, (48, 41)).mean(axis=0)


@pytest.mark.parametrize("name", ["off the middle", "stenosis", "pulmonary", "vmtk_aorta"])
def test_contact_is_that_of_distances_to_the_surface_by_vtk(data_dir, name):
    if name in ("pulmonary", "vmtk_aorta"):
        vessel = anatomy(data_dir, name)
        tree = vessel.centerline
        path = tree.path(tree.points[tree.roots[0]], tree.points[np.sort(tree.leaves)[0]])
        center = tree.project(path.points[3 * len(path.points) // 10])
        width = 2.1 * float(center.inscribed_radius)
        stent = Stent(width, placement=AtCenter(center.point), length=20.0)
    else:
        is_narrowed, tree = name == "stenosis", None
        vessel = phantoms.stenosed_tube() if is_narrowed else phantoms.straight_tube()
        beside = np.array([0.0 if is_narrowed else 0.6, 0, 0])
        axis = vessel.axis_at(np.linspace(8, 32, 40)) + beside
        stent = Stent(5.0, placement=AlongAxis(axis))
    settings = DeploymentSettings(certify=False)
    result = Treatment(vessel.surface, [stent], tree, settings).result
    (done,) = result.stents
    along, expected = free_by_vtk(result.surface, done.axis.points, stent.radius)
    found = done.apposition
    share = np.interp(along, found.arc_length, found.free_share)
    assert 0.1 < expected.mean() < 0.7
    assert share.mean() == pytest.approx(expected.mean(), abs=0.02)
    assert np.abs(share - expected).mean() < 0.03
    assert found.free_length == pytest.approx((expected > 0.1).mean() * along[-1], abs=1.0)


def test_a_short_thin_stent_from_which_all_wall_is_far_hangs_free():
    tube = phantoms.straight_tube(radius=9.0, length=60, edge_length=1.5)
    (stretch,) = apposition(tube.surface, [[0, 0, 29.0], [0, 0, 31.0]], 2.0).stretches
    assert (stretch.start, stretch.end, stretch.share) == pytest.approx((0, 2, 1.0))
    assert stretch.largest_gap == pytest.approx(7.0, abs=0.1)


@pytest.mark.parametrize(
    ("is_known", "name"),
    [(True, "branch of 15.3 mm at 19 mm"), (False, "side branch of 14.6 mm at 19 mm")],
)
def test_a_covered_branch_that_is_pinched_is_told(data_dir, is_known, name):
    """With the tree and the faces of a vessel, and without both."""
    file = read_surface(data_dir / "pulmonary_surface_cm.vtp", units="cm")
    tree = read_centerline(data_dir / "pulmonary_centerline_cm.vtp", units="cm")
    stent = Stent(20, length=25, placement=AtCenter((27.16, -54.26, 67.09)))
    if not is_known:
        stent = Stent(20, placement=AlongAxis(stent_axis(stent, tree).points))
    result = Treatment(
        file.surface,
        [stent],
        tree if is_known else None,
        DeploymentSettings(certify=False),
        faces=file.faces if is_known else None,
    ).result
    (treated,) = result.stents
    *ends, branch = treated.neighbors
    assert {end.name for end in ends} <= {
        "the vessel proximal of the stent",
        "the vessel distal of the stent",
    }
    assert branch.name == treated.branches[0].name == name
    assert branch.before == pytest.approx(9.03, abs=0.05)
    assert branch.after == pytest.approx(7.37, abs=0.05)
    assert branch.is_narrowed
    assert "narrowed from 9.0" in str(branch.caution())
    assert not any(end.is_narrowed for end in ends)
    told = [str(caution) for caution in result.warnings if caution.kind == "neighbor-narrowed"]
    assert len(told) == 1
    assert f"The lumen of {name} is narrowed from 9.0" in told[0]


def lumen_along(path, name="side branch 1"):
    return NeighborLumen(name, Line(path), 5.0, 4.0, 3.0, by_area=False)


def test_of_two_branches_with_one_name_both_are_told_and_of_one_branch_the_worst():
    def treated(number, *lumens, again=None):
        ostia = [Ostium(one.name, one.path.points[0], 2.0, 4.0, 12.0, 1.0) for one in lumens]
        axis = SimpleNamespace(deployed_length=10.0)
        return SimpleNamespace(
            number=number, branches=ostia, neighbors=lumens, again=again, axis=axis
        )

    first = lumen_along([[0, 0, 0], [20, 0, 0]])
    worse = replace(lumen_along([[0, 1, 0], [20, 1, 0]]), after=2.0)
    other = lumen_along([[0, 9, 0], [20, 9, 0]])
    wide = replace(lumen_along([[0, 9, 0], [20, 9, 0]]), after=4.0)
    end = lumen_along([[0, 0, 0], [0, 0, 20]], "the vessel distal of the stent")
    stents = [treated(1, first, other), treated(2, worse, wide), treated(3, end)]
    # Stent 4 is dilated again as stent 5: the vessel beyond is one, too.
    stents += [treated(4, end, again=5), treated(5, replace(end, after=2.5))]
    for stent in stents[2:]:
        stent.branches = []
    told = list(narrowed_neighbors(stents, lambda number: f"Stent {number}: "))
    labels = ["Stents 1 and 2: ", "Stent 1: ", "Stent 3: ", "Stents 4 and 5: "]
    assert [one.label for one in told] == labels
    assert [one.numbers["after_mm"] for one in told] == [2.0, 3.0, 3.0, 2.5]
    assert [one.stent for one in told] == [None, 1, 3, None]
    assert [lumen_into(one, stents[0]) for one in stents[0].branches] == [first, other]
    assert str(told[0]).endswith("5 mm beyond its origin.")
    assert str(told[2]).endswith("5 mm beyond the end of the stent.")
