"""Side branches of a segment, each cut off where a plane first meets only that branch."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from heapq import merge
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from ..geometry import Line, Surface
from ..validation import Points
from .cut_planes import SAME, CutPlane, TriedPlace
from .open_segment import OpenSegment
from .segment import closed_segment
from .segment_planes import SegmentEnds

INSIDE = 1.0
"""Distance before its end, mm, at which a branch that ends within a segment lies in it."""

ALIKE = 2.0
"""Largest ratio of the widths at which a cut side branch counts as the same in two states of a
vessel."""


STUB = 1.5
"""Length, in diameters, kept of a side branch that becomes an outlet: flow turns into it."""


class OpenBranch(NamedTuple):
    """A side branch that no plane cuts off."""

    name: str
    place: Points
    """(3,) place where its centerline leaves the way, mm."""


class ClosedBranches(NamedTuple):
    """A segment without its side branches, in each of its states."""

    states: tuple[OpenSegment, ...]
    left: tuple[OpenBranch, ...]
    """The branches that stay open in each state, at least in part."""


def close_side_branches(
    ends: SegmentEnds, states: Sequence[OpenSegment], *, as_outlets: bool = False
) -> ClosedBranches:
    """Cut off the vessels that leave the way between two planes, each where a plane meets it alone.

    Parameters
    ----------
    ends : SegmentEnds
    states : sequence of OpenSegment
        The segments that the same planes bound in states of the vessel, the native one first. A
        branch is cut by one plane in all of them, or stays open in all.
    as_outlets : bool
        Whether the openings become outlets instead of wall; then a `STUB` of each branch stays.
    """
    lumen = closed_segment(ends.opened).surface
    sides = _sides_within(ends, lumen)
    kept = tuple(states)
    closed: set[int] = set()
    seen: set[bytes] = set()
    # The nearest places come first, so that no branch is cut before the one it comes from.
    steps = (_steps(ends, side, number, closed) for number, side in enumerate(sides))
    for step, number in merge(*steps, key=lambda one: one[0].along):
        key = np.round([step.place, step.direction], 6).tobytes()
        if number in closed or key in seen:
            continue
        seen.add(key)  # branches that have not parted share their places
        stub = 2 * STUB * float(ends.finder.wall.query(step.place)[0])
        if as_outlets and step.along < stub:
            continue
        plane = _plane(ends, step, lumen)
        if plane is not None and as_outlets:
            plane = replace(plane, is_closed=False)
        found = None if plane is None else _all_cut(kept, plane)
        if found is not None:
            kept = found
            closed.update(i for i, side in enumerate(sides) if _is_on(side, step.place))
    rest = closed_segment(kept[0]).surface
    left = [side for side in sides if _ends_in(side, rest)]
    return ClosedBranches(kept, tuple(_named(ends, left)))


def _sides_within(ends: SegmentEnds, lumen: Surface) -> list[Line]:
    """Lines from where side branches leave the way to the ends of the tree within the segment."""
    tree, found = ends.finder.vessel.tree, []
    root = tree.ancestry(ends.start.index)[0]
    for tip in (*tree.leaves, *tree.roots):
        if tree.ancestry(tip)[0] != root:
            continue
        line = tree.path(ends.start, tree.points[tip]).points
        last = int(np.flatnonzero(ends.way.nearest(line).distances <= SAME)[-1])
        side = Line(line[last:])
        if side.length > INSIDE and _ends_in(side, lumen):
            found.append(side)
    return found


def _ends_in(side: Line, lumen: Surface) -> bool:
    return bool(lumen.contains(side.at([side.length - INSIDE]))[0])


def _steps(
    ends: SegmentEnds, side: Line, number: int, closed: Collection[int]
) -> Iterator[tuple[TriedPlace, int]]:
    """Places along a side branch, until it is closed."""
    steps = takewhile(lambda _: number not in closed, ends.finder.steps(side))
    return ((step, number) for step in steps)


def _plane(ends: SegmentEnds, step: TriedPlace, lumen: Surface) -> CutPlane | None:
    """The plane across a side branch at a place; None where it has not parted or is not alone."""
    finder = ends.finder
    if not finder.has_parted(step.place, ends.way) or not lumen.contains(step.place[None])[0]:
        return None
    if finder.fault(step.place, step.direction):
        return None
    name = finder.vessel.branch_name(finder.vessel.tree.project(step.place))
    return CutPlane(name, step.place, -step.direction, is_closed=True)


def _all_cut(states: Sequence[OpenSegment], plane: CutPlane) -> tuple[OpenSegment, ...] | None:
    """States without the part beyond a plane; None where that part is not the same in all."""
    cut = [found for state in states if (found := state.cut_off(plane)) is not None]
    areas = [one.areas[-1] for one in cut]
    if len(cut) < len(states) or max(areas) > ALIKE**2 * min(areas):
        return None
    return tuple(cut)


def _is_on(side: Line, place: Points) -> bool:
    return bool(side.nearest(place[None]).distances[0] <= SAME)


def _named(ends: SegmentEnds, sides: Sequence[Line]) -> Iterator[OpenBranch]:
    """The branches by the names of their ends; one stands for all that leave at one place."""
    vessel = ends.finder.vessel
    lines = [side.points for side in sides]
    for origin in dict.fromkeys(tuple(line[0]) for line in lines):
        own = [line for line in lines if tuple(line[0]) == origin]
        shared = min(len(line) for line in own)
        same = np.all([line[:shared] == own[0][:shared] for line in own], axis=(0, 2))
        last = int(np.flatnonzero(same)[-1])
        place = vessel.tree.project(own[0][max(last, 1)])
        yield OpenBranch(vessel.branch_name(place), own[0][0])
