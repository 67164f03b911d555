"""The planes between which a segment of a vessel is cut out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..centerline import Centerline, Location
from ..geometry import ClosedSurface, closest_points, length, point_at
from ..validation import InputError, Points, as_point
from .cut_planes import SAME, CutPlane, PlaneFinder
from .segment import cut_segment
from .vessel_parts import VesselParts

INSIDE = 1.0
"""A branch that ends within a segment lies in it so far before its end, mm."""


def segment_planes(
    vessel: VesselParts, start: Points, end: Points, *, close_branches: bool = False
) -> tuple[CutPlane, ...]:
    """The planes that bound a segment: at its start, at its end, and before closed branches.

    Parameters
    ----------
    vessel : VesselParts
    start, end : (3,) arrays
        Places in the vessel, mm; the segment is what lies on the way between them.
    close_branches : bool
        Whether vessels that leave the way are cut off, each where a plane first meets only it.

    Raises
    ------
    InputError
        A place that is not in the vessel, two that are one, or a plane that meets another vessel,
        an end of the surface or nothing closed.
    """
    tree = vessel.tree
    places = (
        tree.project(as_point(start, "segment start")),
        tree.project(as_point(end, "segment end")),
    )
    way = tree.path(*places).points
    if length(way) <= SAME:
        raise InputError(
            "segment: expected two places apart, got such that are nearest to the same one of the "
            f"centerline, {vessel.said(places[0].point)}; move one of them, or check their unit "
            "(mm, cm) and frame (RAS, LPS)."
        )
    finder = PlaneFinder(vessel)
    planes = [
        CutPlane(_name(vessel, place), line[0], finder.end_direction(line, place, word))
        for place, line, word in zip(places, (way, way[::-1]), ("start", "end"), strict=True)
    ]
    closings = _closings(vessel, finder, places[0], way, planes) if close_branches else []
    return (*planes, *closings)


def _closings(
    vessel: VesselParts, finder: PlaneFinder, start: Location, way: Points, ends: list[CutPlane]
) -> list[CutPlane]:
    """Planes before the branches that leave a way between two planes."""
    found: list[CutPlane] = []
    lumen = _lumen(vessel, ends)
    for side in _side_lines(vessel.tree, start, way):
        if lumen.contains(point_at(side, [length(side) - INSIDE]))[0]:
            found.append(_closing(vessel, finder.first_across(side, way, lumen), side))
            lumen = _lumen(vessel, [*ends, *found])
    return found


def _lumen(vessel: VesselParts, planes: list[CutPlane]) -> ClosedSurface:
    surface = cut_segment(vessel, planes).surface
    return ClosedSurface(surface.points, surface.triangles)


def _closing(vessel: VesselParts, found: tuple[Points, Points] | None, side: Points) -> CutPlane:
    """A plane that closes a branch."""
    if found is None:
        name = _name(vessel, vessel.tree.project(side[-1]))
        raise InputError(
            f"segment: expected a plane that meets only {name} to close it before "
            f"{vessel.said(side[-1])}, there is none; keep the branches, or choose other places."
        )
    name = _name(vessel, vessel.tree.project(found[0]))
    return CutPlane(name, *found, is_closed=True)


def _side_lines(tree: Centerline, start: Location, way: Points) -> Iterator[Points]:
    """From where they leave a way: lines (k, 3) to every end of the tree beside it."""
    root = tree.ancestry(start.index)[0]
    for tip in (*tree.leaves, *tree.roots):
        if tree.ancestry(tip)[0] != root:
            continue
        line = tree.path(start, tree.points[tip]).points
        last = int(np.flatnonzero(closest_points(way, line).distances <= SAME)[-1])
        if length(line[last:]) > INSIDE:
            yield line[last:]


def _name(vessel: VesselParts, place: Location) -> str:
    """Of the branch at a place."""
    return vessel.branch_names[vessel.branch_of(place)]
