"""Ways into the vessels beside a stent: beyond both of its ends, and into its branches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import (
    Surface,
    arc_lengths,
    closest_points,
    cut,
    length,
    norm,
    point_at,
    without_repeats,
)
from ..validation import Indices, Points
from .extended_axis import ExtendedAxis
from .lumen_way import through_lumen
from .ostia import Ostium
from .tree_around import ends_around, place_of

MEASURED = 20.0
"""Length of a neighbor that is looked at, mm."""

SHORTEST = 1.0
"""A way is longer, mm."""

_OBLIQUE = 6.0
"""A branch's line is longer up to its opening by at most so many times the opening's distance from
the axis: more would be a branch that leaves at less than 10 degrees."""

_LEAVES = 0.5
"""A way that is farther from the axis than so many radii of an ostium leaves the vessel there."""


PROXIMAL, DISTAL = "the vessel proximal of the stent", "the vessel distal of the stent"
"""Names of what goes on beyond its ends."""


class NeighborWay(NamedTuple):
    """A way into a vessel beside a stent."""

    name: str
    points: Points
    """(n, 3) from the stent on, mm."""


def end_ways(axis: ExtendedAxis) -> tuple[NeighborWay, ...]:
    """The vessel beyond the ends of the stent, as far as it goes on."""
    first, ways = axis.before + axis.stent_length, []
    if axis.before > SHORTEST:
        start = cut(axis.points, 0.0, axis.before)[::-1]
        ways.append(NeighborWay(PROXIMAL, start))
    if axis.after > SHORTEST:
        end = cut(axis.points, first, np.inf)
        ways.append(NeighborWay(DISTAL, end))
    return tuple(ways)


class BranchWays:
    """Ways into the branches of a stented vessel: along a centerline, or through the lumen.

    Parameters
    ----------
    surface : Surface
        In which the stent lies, mm.
    axis : ExtendedAxis
        Of the stent.
    centerline : Centerline or None
        Of the surface.
    """

    def __init__(self, surface: Surface, axis: ExtendedAxis, centerline: Centerline | None) -> None:
        self.surface, self.axis, self.centerline = surface, axis, centerline
        self._lines: list[Points] = []
        self._reach = 0.0

    def into(self, ostium: Ostium) -> Points | None:
        """(n, 3) from the opening on; None where the branch has no way of some length."""
        if self.centerline is None:
            return self._through(ostium)
        return self._along(ostium)

    def number(self, way: Points) -> int:
        """Of the centerline's branch on which a way begins, from 1."""
        assert self.centerline is not None
        place = self.centerline.project(point_at(way, np.array([SHORTEST]))[0])
        holds = [place.index in branch[1:] for branch in self.centerline.branches]
        return holds.index(True) + 1

    def _along(self, ostium: Ostium) -> Points | None:
        """Of the ways from the axis to the ends of the tree the one that passes the opening
        nearest to its middle.
        """
        best, nearest = None, _size(ostium) + 1e-6
        for line in self._lines_past(ostium):
            # No point of a line is farther from its nearest corner than half a step.
            if norm(line - ostium.center).min() > nearest + np.diff(arc_lengths(line)).max() / 2:
                continue
            # Only the part that leaves the axis for good is a branch.
            on_axis = self._beside_axis(line, _LEAVES * _size(ostium))
            own = line[on_axis[-1] if len(on_axis) else 0 :]
            if len(without_repeats(own)) < 2:
                continue
            found = closest_points(own, ostium.center[None])
            first = float(found.arc_lengths[0])
            if found.distances[0] < nearest - 1e-6 and length(own) - first > SHORTEST:
                nearest = float(found.distances[0])
                best = cut(own, first, first + MEASURED)
        return best

    def _beside_axis(self, line: Points, distance: float) -> Indices:
        """Which points of a line are nearer to the axis, ascending."""
        low, high = self.axis.points.min(axis=0), self.axis.points.max(axis=0)
        may = np.flatnonzero(((line > low - distance) & (line < high + distance)).all(axis=1))
        return may[closest_points(self.axis.points, line[may]).distances < distance]

    def _lines_past(self, ostium: Ostium) -> list[Points]:
        """Lines from both ends of the axis that go on far enough beyond the opening."""
        assert self.centerline is not None
        apart = closest_points(self.axis.points, ostium.center[None]).distances[0]
        reach = length(self.axis.points) + _OBLIQUE * float(apart) + MEASURED
        if reach > self._reach:
            self._reach, self._lines = reach, list(_lines_from(self.centerline, self.axis, reach))
        return self._lines

    def _through(self, ostium: Ostium) -> Points | None:
        """From sphere to sphere, first the way from the axis to the opening."""
        start = closest_points(self.axis.points, ostium.center[None]).points[0]
        way = through_lumen(self.surface, np.array([start, ostium.center]), MEASURED)
        way = np.concatenate([ostium.center[None], way])
        return way if length(way) > SHORTEST else None


def _lines_from(tree: Centerline, axis: ExtendedAxis, reach: float) -> Iterator[Points]:
    """The ways (n, 3) from both ends of the axis into the tree, so far from the axis at least."""
    stops = [tree.project(stop) for stop in (axis.points[0], axis.points[-1])]
    ends = set().union(*(ends_around(tree, stop, reach) for stop in stops))
    # Distal ends first: of two that share a way the first one counts.
    for end in sorted(ends, key=lambda node: (tree.parent[node] < 0, node)):
        for stop in stops:
            line = tree.path(stop, place_of(tree, end)).points
            if len(line) > 1:
                yield line


def _size(ostium: Ostium) -> float:
    """Radius of the circle with the area of the opening, mm."""
    return float(np.sqrt(ostium.area / np.pi))
