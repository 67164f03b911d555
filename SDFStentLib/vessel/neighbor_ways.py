"""Ways into the vessels beside a stent: beyond both of its ends, and into its branches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line, Surface
from ..lumen import CENTERED, NOTHING, REACH, SPACING, ExtendedAxis, through_lumen
from ..validation import Points
from .ostia import Ostium
from .tree_around import LinesFromAxis

_OBLIQUE = 6.0
"""A branch's line is longer up to its opening by at most so many times the opening's distance from
the axis: more would be a branch that leaves at less than 10 degrees."""

PROXIMAL, DISTAL = "the vessel proximal of the stent", "the vessel distal of the stent"
"""Names of the vessel beyond its ends."""


class NeighborWay(NamedTuple):
    """A way into a vessel beside a stent."""

    name: str
    line: Line
    """The line from the stent on."""


def end_ways(axis: ExtendedAxis) -> tuple[NeighborWay, ...]:
    """Ways beyond the ends of the stent, as far as the axis goes on."""
    first, ways = axis.before + axis.stent_length, []
    if axis.before > SPACING:
        start = axis.line.cut(0.0, axis.before).reversed()
        ways.append(NeighborWay(PROXIMAL, start))
    if axis.after > SPACING:
        ways.append(NeighborWay(DISTAL, axis.line.cut(first, np.inf)))
    return tuple(ways)


class BranchWays:
    """Ways into the branches of a stented vessel: along a centerline, or through the lumen.

    Parameters
    ----------
    surface : Surface
        Surface in which the stent lies, mm.
    axis : ExtendedAxis
        Axis of the stent.
    centerline : Centerline or None
        Centerline of the surface.
    """

    def __init__(self, surface: Surface, axis: ExtendedAxis, centerline: Centerline | None) -> None:
        self.surface, self.axis, self.centerline = surface, axis, centerline

    def into(self, ostia: Sequence[Ostium]) -> list[Line | None]:
        """The ways from every opening on; None where a branch has no way of some length."""
        if not ostia:
            return []
        feet = self.axis.line.nearest(np.array([ostium.center for ostium in ostia]))
        if self.centerline is None:
            return self._through(feet.points, ostia)
        reach = self.axis.line.length + _OBLIQUE * float(feet.distances.max()) + REACH
        beside = CENTERED * max(_size(ostium) for ostium in ostia)
        lines = LinesFromAxis(self.centerline, self.axis.line, reach, beside)
        return [_past(ostium, lines) for ostium in ostia]

    def _through(self, feet: Points, ostia: Sequence[Ostium]) -> list[Line | None]:
        """The way from sphere to sphere, first that from the axis to the opening."""
        starts = [np.array([foot, ostium.center]) for foot, ostium in zip(feet, ostia, strict=True)]
        ways = through_lumen(self.surface, starts, REACH)
        lines = [Line(np.concatenate([s[1:], way])) for s, way in zip(starts, ways, strict=True)]
        return [line if line.length > SPACING else None for line in lines]


def _past(ostium: Ostium, lines: LinesFromAxis) -> Line | None:
    """The line from the axis to most outlets that passes an opening near its middle.

    Where none does, that which passes nearest to it, the first of those equally near.
    """
    best, nearest = None, _size(ostium) + NOTHING
    for own in lines.leaving(CENTERED * _size(ostium), ostium.center, nearest):
        found = own.nearest(ostium.center[None])
        first = float(found.arc_lengths[0])
        if found.distances[0] < nearest - NOTHING and own.length - first > SPACING:
            nearest = float(found.distances[0])
            best = own.cut(first, first + REACH)
            if nearest < CENTERED * _size(ostium):
                break
    return best


def _size(ostium: Ostium) -> float:
    """Radius of the circle with the area of the opening, mm."""
    return float(np.sqrt(ostium.area / np.pi))
