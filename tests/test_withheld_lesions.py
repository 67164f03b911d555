"""What is left of a lesion where a wall has moved past its line: not known, and told so."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from SDFStentLib.centerline import Centerline
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.lumen import measured_at, moved_wall
from SDFStentLib.phantoms import stenosed_tube, straight_tube
from SDFStentLib.report import document_json, residual_fact, summary
from SDFStentLib.report.lesions import (
    residual_section,
    stent_lesion_sentences,
    treated_lesion_section,
)
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import TreatedLesion, Treatment, residual_of, treated_lesions
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
    section = json.loads(document_json(treated_lesion_section(treated)))["after"]
    assert section["percent_diameter"] is None
    assert section["minimum"]["diameter_mm"] is None
    (sentence,) = stent_lesion_sentences([treated], 1)
    assert "-> not known" in sentence
    assert "the wall was moved past the line" in sentence
    # The narrowest place left may be the one that is not known.
    residual = residual_of([other, treated], placed)
    assert math.isnan(residual.percent)
    assert residual_fact(residual).words.startswith("not known, as in lesion 1, within stent 1")
    assert json.loads(document_json(residual_section(residual)))["minimum_mm"] is None


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
    told = summary._branches([beside])
    assert told == "Branches: 1 with a lumen that is not known: branch 2."
