"""Ways into the vessels beside a stent: beyond both of its ends, and into its branches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, closest_points, cut, length, point_at, without_repeats
from ..validation import Floats, Points
from .extended_axis import ExtendedAxis
from .lumen_way import through_lumen
from .ostia import Ostium

MEASURED = 20.0
"""Length of a neighbor that is looked at, mm."""

SHORTEST = 1.0
"""A way is longer, mm."""

_LEAVES = 0.5
"""A way that is farther from the axis than so many radii of an ostium leaves the vessel there."""


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
        ways.append(NeighborWay("the vessel proximal of the stent", start))
    if axis.after > SHORTEST:
        end = cut(axis.points, first, np.inf)
        ways.append(NeighborWay("the vessel distal of the stent", end))
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
        self._lines = [] if centerline is None else list(_lines_from(centerline, axis))

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
        for line, apart in self._lines:
            # Only the part that leaves the axis for good is a branch.
            on_axis = np.flatnonzero(apart < _LEAVES * _size(ostium))
            own = line[on_axis[-1] if len(on_axis) else 0 :]
            if len(without_repeats(own)) < 2:
                continue
            found = closest_points(own, ostium.center[None])
            first = float(found.arc_lengths[0])
            if found.distances[0] < nearest - 1e-6 and length(own) - first > SHORTEST:
                nearest = float(found.distances[0])
                best = cut(own, first, first + MEASURED)
        return best

    def _through(self, ostium: Ostium) -> Points | None:
        """From sphere to sphere, first the way from the axis to the opening."""
        start = closest_points(self.axis.points, ostium.center[None]).points[0]
        way = through_lumen(self.surface, np.array([start, ostium.center]), MEASURED)
        way = np.concatenate([ostium.center[None], way])
        return way if length(way) > SHORTEST else None


def _lines_from(tree: Centerline, axis: ExtendedAxis) -> Iterator[tuple[Points, Floats]]:
    """The ways (n, 3) from both ends of the axis to all ends of the tree, and how far off it."""
    for end in np.r_[tree.leaves, tree.roots]:
        for stop in (axis.points[0], axis.points[-1]):
            line = tree.path(tree.project(stop), tree.project(tree.points[end])).points
            if len(line) > 1:
                yield line, closest_points(axis.points, line).distances


def _size(ostium: Ostium) -> float:
    """Radius of the circle with the area of the opening, mm."""
    return float(np.sqrt(ostium.area / np.pi))
