"""What is told of lesions once a wall has moved past their line, or beside it."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from benchmarks.phantoms import stenosed_tube, straight_tube, vascular_tree
from SDFStentLib.centerline import Centerline
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import in_caps, inscribed_spheres, measured_after, measured_at, moved_wall
from SDFStentLib.plan import read_input_files
from SDFStentLib.report import document_json, residual_facts
from SDFStentLib.report.branches import branches_fact
from SDFStentLib.report.lesions import stent_lesion_sentences, treated_lesion_facts
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import (
    Residual,
    TreatedLesion,
    Treatment,
    lesions_of_treated,
    residual_of,
    told_first,
    treated_lesions,
)
from SDFStentLib.vessel import (
    Lesion,
    NeighborLumen,
    NeighborStations,
    NeighborWay,
    Ostium,
    VesselStates,
    find_lesions,
    lesions_after,
)


class Tube(NamedTuple):
    surface: Surface
    centerline: Centerline
    lesion: Lesion
    count: int
    """Points of its own."""

    def pushed_aside(self, far: float) -> Surface:
        """Its lesion carried sideways by up to so many mm."""
        points = self.surface.points.copy()
        there = np.exp(-(((points[:, 2] - self.lesion.point[2]) / 8) ** 2))
        points[:, 0] += np.where(np.arange(len(points)) < self.count, far * there, 0.0)
        return Surface(points, self.surface.triangles)


@pytest.fixture(scope="module")
def tube():
    """Between other vessels: spheres outside of the lumen do not get lost."""
    made, other = stenosed_tube(3.0, 1.4, 60, edge_length=0.8), straight_tube(3.0, 60, 0.8)
    beside = [other.points + place for place in ([-9, 0, 0], [-1, 9, 0], [-1, -9, 0])]
    first = len(made.points) + len(other.points) * np.arange(3)
    points = np.vstack([made.points, *beside])
    surface = Surface(
        points, np.vstack([made.triangles, *(other.triangles + number for number in first)])
    )
    (lesion,) = find_lesions(surface, made.centerline)
    return Tube(surface, made.centerline, lesion, len(made.points))


@pytest.mark.parametrize("name", ["su0243", "tree_narrowed"])
def test_what_is_told_of_a_treatment_does_not_depend_on_what_has_been_measured(data_dir, name):
    """Lesions of main vessels come first; of the others only those that may matter are needed."""
    files = (data_dir / f"{name}_{part}_mm.vtp" for part in ("surface", "centerline"))
    vessel = read_input_files(*files).vessel
    tree = vessel.tree_lesions
    assert all(one is other for one, other in zip(tree.every, tree.first, strict=False))
    settings, was_enough = DeploymentSettings(certify=False), []
    for lesion in tree.every[:4]:
        stent = Stent(6.0, length=24.0, placement=AtCenter(lesion.point))
        result = Treatment(vessel.surface, [stent], vessel.centerline, settings).result
        states = result.surface, vessel.surface
        every = treated_lesions(tree.every, result.stents, *states)
        told = told_first(tree, result.stents, *states)
        was_enough.append(told is not None)
        for one, other in zip(told or (), lesions_of_treated(every, result.stents), strict=False):
            assert (one.number, one.stents) == (other.number, other.stents)
            assert one.before is other.before
            assert one.after.percent_diameter == other.after.percent_diameter
            assert one.after.point == other.after.point
        if told is not None:
            assert len(told) == len(lesions_of_treated(every, result.stents))
    assert {*was_enough} == {False, True}


@pytest.mark.parametrize("is_told_what_moved", [False, True])
def test_a_lesion_whose_line_is_outside_of_the_lumen_has_no_diameter(tube, is_told_what_moved):
    after = tube.pushed_aside(6.0)
    moved = moved_wall(tube.surface, after) if is_told_what_moved else None
    (left,) = lesions_after([tube.lesion], after, moved)
    assert math.isnan(left.minimum_diameter)
    assert math.isnan(left.percent_diameter)
    assert math.isnan(left.percent_area)


def test_a_line_of_which_a_part_is_outside_has_no_narrowest_place(tube):
    """Beside the throat it leaves the lumen: what it tells elsewhere is not the narrowest."""
    points = tube.surface.points.copy()
    beside = tube.lesion.point[2] + 3.0
    there = np.exp(-(((points[:, 2] - beside) / 2) ** 2))
    points[:, 0] += np.where(np.arange(len(points)) < tube.count, 6.0 * there, 0.0)
    (left,) = lesions_after([tube.lesion], Surface(points, tube.surface.triangles))
    assert np.isfinite(left.diameters).sum() >= 2
    assert math.isnan(left.minimum_diameter)


def test_every_statement_says_that_it_is_not_known(tube):
    lesion = tube.lesion
    stent = Stent(5.0, placement=AtCenter(lesion.point), length=12.0)
    placed = Treatment(tube.surface, [stent], tube.centerline).result.stents
    (treated,) = treated_lesions([lesion], placed, tube.pushed_aside(6.0))
    assert math.isnan(treated.after.percent_diameter)
    assert treated.stents == (1,)
    other = TreatedLesion(2, lesion, replace(lesion, percent_diameter=20.0), (1,))
    section = json.loads(document_json(treated_lesion_facts(treated).as_dict()))["after"]
    assert section["percent_diameter"] is None
    assert section["minimum"]["diameter_mm"] is None
    (sentence,) = stent_lesion_sentences([treated], 1)
    assert "-> not known" in sentence
    assert "the wall was moved past the line" in sentence
    # The narrowest place left may be the one that is not known.
    residual = residual_of([other, treated], placed)
    assert math.isnan(residual.percent)
    section = residual_facts(residual).as_dict()
    assert section["words"].startswith("not known, as in lesion 1, within stent 1")
    assert json.loads(document_json(section))["minimum_mm"] is None


def test_a_neighbor_whose_way_is_outside_of_the_lumen_has_no_diameter(tube):
    after = tube.pushed_aside(6.0)
    states = VesselStates(tube.surface, tube.surface, after, after)
    middle = tube.lesion.point[2]
    way = np.column_stack([np.zeros((9, 2)), np.linspace(middle - 4, middle + 4, 9)])
    beside = NeighborStations(states, [NeighborWay("branch", Line(way))])
    assert len(beside.points)
    measured = [
        measured_at(surface, beside.points, beside.directions) for surface in (tube.surface, after)
    ]
    (lumen,) = beside.lumens(*measured)
    assert math.isnan(lumen.after)
    assert not lumen.is_narrowed
    assert beside.outside.tolist() == [[False] * len(beside.points), [True] * len(beside.points)]


def test_stations_outside_of_the_vessel_have_no_sphere(tube):
    """Searched from there it lies beside the vessel, or grows until it is out of all of it."""
    after = tube.pushed_aside(6.0)
    middle = tube.lesion.point[2]
    points = np.column_stack([np.zeros((5, 2)), np.linspace(middle - 2, middle + 2, 5)])
    ways = np.tile([0.0, 0, 1], (5, 1))
    before, moved = measured_at(tube.surface, points, ways), moved_wall(tube.surface, after)
    searched = measured_after(before, moved, after, in_caps(after))
    assert not after.contains(searched.spheres.centers[searched.spheres.radii > 0]).any()
    spared = measured_after(before, moved, after, in_caps(after), ~after.contains(points))
    assert np.isnan(spared.spheres.radii).all()
    np.testing.assert_array_equal(spared.equivalent, searched.equivalent)


def test_the_summary_names_a_branch_whose_lumen_is_not_known():
    way = np.array([[0.0, 0, 0], [0, 0, 5]])
    lost = NeighborLumen("branch 2", Line(way), 1.0, 4.1, math.nan, by_area=False)
    opening = Ostium(lost.name, way[0], 2.0, 6.0, 12.0, 0.0)
    beside = SimpleNamespace(
        number=1,
        branches=(opening,),
        neighbors=(lost,),
        axis=SimpleNamespace(deployed_length=10.0),
        again=None,
    )
    assert branches_fact([beside]).words == "Branches: 1 with a lumen that is not known: branch 2."


# Lesions beside a treatment stay what they are, and are not measured again.


@pytest.fixture(scope="module")
def tree_with_two_lesions():
    made = vascular_tree(6, 1.0, {0: 0.4, 5: 0.4})
    return made, find_lesions(made.surface, made.centerline)


def test_a_lesion_beside_the_stent_is_that_of_before(tree_with_two_lesions):
    made, found = tree_with_two_lesions
    assert len(found) == 2
    for treated in found:
        (other,) = (lesion for lesion in found if lesion is not treated)
        stent = Stent(treated.reference_diameter, placement=AtCenter(treated.point), length=12.0)
        result = Treatment(
            made.surface, [stent], made.centerline, DeploymentSettings(certify=False)
        ).result
        plain = treated_lesions(found, result.stents, result.surface)
        fast = treated_lesions(found, result.stents, result.surface, made.surface)
        number = found.index(other)
        assert fast[number].after is other
        for one, exact in zip(fast, plain, strict=True):
            for name in ("minimum_diameter", "percent_diameter", "minimum_area", "percent_area"):
                values = getattr(one.after, name), getattr(exact.after, name)
                assert values[0] == pytest.approx(values[1], abs=2e-3), name
            np.testing.assert_allclose(one.after.point, exact.after.point, atol=0.1)
            assert one.stents == exact.stents
        assert plain[found.index(treated)].after.percent_diameter < 10
        assert fast[found.index(treated)].after is not treated


@pytest.mark.parametrize(("shift", "side"), [(-4.0, "distal"), (4.0, "proximal"), (0.0, "within")])
def test_what_is_left_is_the_narrowest_place_of_the_vessel_wherever_it_lies(shift, side):
    """By another way: spheres along the whole tube, against its 6 mm."""
    made = stenosed_tube(edge_length=0.5, length=60.0)
    lesions = find_lesions(made.surface, made.centerline)
    length = 12.0 if shift else 30.0
    stent = Stent(5.4, placement=AtCenter((0, 0, 30 + shift)), length=length)
    result = Treatment(
        made.surface, [stent], made.centerline, DeploymentSettings(certify=False)
    ).result
    left = residual_of(treated_lesions(lesions, result.stents, result.surface), result.stents)
    line = made.axis_at(np.linspace(5, 55, 501))
    widths = 2 * inscribed_spheres(result.surface.points, made.triangles, line).radii
    assert left.minimum == pytest.approx(widths.min(), abs=0.01)
    assert left.percent == pytest.approx(100 * (1 - widths.min() / 6), abs=1)
    assert left.side == side
    axis = result.stents[0].axis.points[:, 2]
    away = max(left.point[2] - axis.max(), axis.min() - left.point[2], 0)
    assert left.distance == pytest.approx(away, abs=0.2)


@pytest.mark.parametrize(
    ("side", "distance", "said"),
    [
        ("proximal", 0.03, "just before stent 1"),
        ("distal", 1.2, "1 mm beyond stent 1"),
        ("between", 0.4, "between stents, just beyond stent 1"),
        ("within", 0.0, "within stent 1"),
    ],
)
def test_where_the_narrowest_place_left_lies_is_told_without_a_distance_of_nothing(
    side, distance, said
):
    assert Residual(20.0, 4.0, 5.0, (0, 0, 0), 1, side, 1, distance).place() == said
