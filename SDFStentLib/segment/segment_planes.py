"""The planes at the two ends of a segment of a vessel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, repeat
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, Location
from ..geometry import Line
from ..validation import InputError, Points, as_point
from ..vessel import VesselParts
from .cut_planes import SAME, CutPlane, PlaneFinder
from .open_segment import OpenSegment, bounded, segment_between

DIGITS = 4
"""Digits of the coordinates of a place in a sentence, as users choose it by typing them."""


WORDS = ("start", "end")
"""Words for the two ends of a segment."""

TRIES = 4
"""Number of other places that are tried for the advice in a sentence."""

Places = tuple[Location, Location]
Lines = tuple[Line, Line]
"""The way from one end of a segment to the other, and back."""


class _Move(NamedTuple):
    """A place to which an end of a segment can be moved."""

    by: float
    """Distance of the move along the way, mm."""
    place: Points


_Moves = tuple[_Move | None, ...]
"""Moves of the start and of the end; None for one that stays."""

_NOWHERE: _Moves = (None, None)


class SegmentEnds(NamedTuple):
    """The two ends of a segment of a vessel."""

    start: Location
    way: Line
    """The way on the centerline from its start to its end."""
    finder: PlaneFinder
    opened: OpenSegment
    """The part of the vessel between the planes there."""
    moved: tuple[float, float] = (0.0, 0.0)
    """Distance of each end from where it was wanted, mm."""


def segment_ends(
    vessel: VesselParts,
    start: Points,
    end: Points,
    *,
    nearest: bool = False,
    treated: VesselParts | None = None,
) -> SegmentEnds:
    """The ends of the segment that planes at two places bound.

    Parameters
    ----------
    vessel : VesselParts
    start, end : (3,) arrays
        Places in the vessel, mm; the segment lies on the way between them.
    nearest : bool
        Whether an end at which every plane meets another vessel moves into the segment, as far as
        needed.
    treated : VesselParts, optional
        The vessel after treatment: planes have to meet it alone in that state, too.

    Raises
    ------
    InputError
        A place that is not in the vessel, two places that are one, or a plane that meets another
        vessel, an end of the surface or no closed curve. Places that the message advises bound a
        segment.
    """
    tree = vessel.tree
    places = tree.ends_of_path(as_point(start, "segment start"), as_point(end, "segment end"))
    way = tree.path(*places).line
    if way.length <= SAME:
        raise InputError(
            "segment: expected two places apart, got such that are nearest to the same one of the "
            f"centerline, {vessel.said(places[0].point)}; move one of them, or check their unit "
            "(mm, cm) and frame (RAS, LPS)."
        )
    finder, lines = PlaneFinder(vessel, treated), (way, way.reversed())
    for place, line, word in zip(places, lines, WORDS, strict=True):
        finder.check_inside(line, place, word)
    planes, faults = _planes(finder, places)
    moves = _NOWHERE
    if any(faults):
        moves = _moves(finder, lines, faults)
        if not nearest or moves == _NOWHERE:
            raise InputError(_refusal(finder, lines, faults, moves))
        places = _moved(tree, lines, moves)
        planes, _ = _planes(finder, places)
    by = [0.0 if move is None else move.by for move in moves]
    opened = segment_between(vessel, planes)
    return SegmentEnds(places[0], tree.path(*places).line, finder, opened, (by[0], by[1]))


def _planes(finder: PlaneFinder, places: Places) -> tuple[tuple[CutPlane, ...], tuple[str, ...]]:
    """The planes across the vessel at two places, facing each other, and the fault of each."""
    way = finder.vessel.tree.path(*places).line
    planes, faults = [], []
    for place, line in zip(places, (way, way.reversed()), strict=True):
        plane = CutPlane(finder.vessel.branch_name(place), line.points[0], finder.direction(line))
        planes.append(plane)
        faults.append(finder.fault(plane.origin, plane.normal))
    return tuple(planes), tuple(faults)


def _refusal(finder: PlaneFinder, lines: Lines, faults: Sequence[str], moves: _Moves) -> str:
    """The faults of the places of the planes, and the places to which to move them."""
    said = []
    for word, line, fault, move in zip(WORDS, lines, faults, moves, strict=True):
        if fault:
            advice = "choose another place"
            if move is not None:
                place = finder.vessel.said(move.place)
                advice = f"move it {move.by:.1f} mm into the segment, to {place}"
            said.append(
                f"segment {word}: expected a plane that meets only this vessel, the one at "
                f"{finder.vessel.said(line.points[0])}, {fault}; {advice}"
            )
    return "; ".join(said) + "."


def _moves(finder: PlaneFinder, lines: Lines, faults: Sequence[str]) -> _Moves:
    """Places nearby that bound a segment together; None for an end that stays or has none."""
    tried = [
        _free(finder, line) if fault else repeat(None)
        for line, fault in zip(lines, faults, strict=True)
    ]
    for moves in islice(zip(*tried, strict=False), TRIES):
        if sum(move.by for move in moves if move is not None) >= lines[0].length:
            break
        planes, left = _planes(finder, _moved(finder.vessel.tree, lines, moves))
        if not any(left) and not bounded(finder.vessel, planes).apart:
            return moves
    return _NOWHERE


def _moved(tree: Centerline, lines: Lines, moves: _Moves) -> Places:
    """First points of the lines, moved where a move is given."""
    first, last = (
        tree.project(line.points[0] if move is None else move.place)
        for line, move in zip(lines, moves, strict=True)
    )
    return first, last


def _free(finder: PlaneFinder, line: Line) -> Iterator[_Move]:
    """Places along a line at which a plane meets only the vessel there, rounded as
    in a sentence."""
    for step in finder.steps(line):
        if not finder.fault(step.place, step.direction):
            typed = [float(f"{value:.{DIGITS}g}") for value in step.place]
            yield _Move(step.along, np.array(typed))
