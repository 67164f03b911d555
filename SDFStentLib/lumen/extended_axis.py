"""The axis of a stent, led on through the vessel beyond both of its ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import dist

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import Line, Surface, as_line
from ..validation import Floats, InputError, Points, as_number
from .lumen_way import heading_of, through_lumen

REACH = 20.0
"""How far beyond an end of the stent its surroundings are looked at, mm."""

_FADING = 10.0
"""Length over which the way changes from the stent's axis to the centerline, mm."""


@dataclass(frozen=True)
class ExtendedAxis:
    """A stent's axis and the way beyond its ends, proximal to distal.

    Positions on it count from the proximal end of the stent: negative proximal of it.
    """

    line: Line
    before: float
    """Length proximal of the stent, mm."""
    stent_length: float
    """mm."""

    @property
    def points(self) -> Points:
        """(n, 3) mm."""
        return self.line.points

    @cached_property
    def of_stent(self) -> Line:
        """The part along the stent."""
        return self.line.cut(self.before, self.before + self.stent_length)

    @property
    def after(self) -> float:
        """Length distal of the stent, mm."""
        return self.line.length - self.before - self.stent_length


def extended_axis(
    surface: Surface,
    stent_axis: Line | ArrayLike,
    centerline: Centerline | None = None,
    *,
    reach: float = REACH,
) -> ExtendedAxis:
    """The axis led on along the centerline, without one through the middle of the lumen.

    At a junction the way goes on to the root, or from there on in the straightest direction. It
    ends where vessel or centerline end.

    Parameters
    ----------
    surface : Surface
        mm.
    stent_axis : Line or array_like, shape (n, 3)
        From the proximal to the distal end, mm.
    centerline : Centerline, optional
    reach : float
        Wanted length beyond each end, mm.

    Raises
    ------
    InputError
        An axis without length, or a reach below 0.
    """
    line = as_line(stent_axis, "stent_axis").without_repeats()
    if len(line) < 2:
        raise InputError("stent_axis: expected two different points at least, got one place.")
    as_number(reach, "reach", unit="mm", minimum=0)

    axis = line.points
    sides = [line.reversed(), line]
    if reach == 0:
        ways = [axis[:0], axis[:0]]
    elif centerline is None:
        ways = through_lumen(surface, [side.points for side in sides], reach)
    else:
        ways = [_along_tree(centerline, side, reach) for side in sides]
    before, after = ways[0][::-1], ways[1]
    return ExtendedAxis(
        Line(np.concatenate([before, axis, after])),
        Line(np.concatenate([before, axis[:1]])).length,
        line.length,
    )


def _along_tree(tree: Centerline, axis: Line, reach: float) -> Points:
    """The tree's points from the end of the axis on, the first ones drawn to that end."""
    end = axis.points[-1]
    place = tree.project(end)
    radius = place.inscribed_radius if place.inscribed_radius > 0 else 1.0
    heading = heading_of(axis, radius)
    above = int(tree.parent[place.index])
    sides = [(place.index, above), (above, place.index)]
    tips = [tree.points[_ahead(tree, *side, radius)] for side in sides]
    came_from, node = sides[int(np.argmax([(tip - place.point) @ heading for tip in tips]))]
    way, travelled = [place.point], 0.0
    # Ends: never back, and the tree has no circle.
    while True:
        travelled += dist(tree.points[node], way[-1])
        way.append(tree.points[node])
        onward = _onward(tree, came_from, node)
        if travelled >= reach or not onward:
            break
        above = int(tree.parent[node])
        came_from, after = node, above if above in onward else onward[0]
        if len(onward) > 1 and after != above:
            ahead = heading_of(Line(np.array(way)), radius) if travelled > radius else heading
            after = onward[_straightest(tree, node, onward, ahead, 2 * radius)]
        node = after
    line = Line(np.array(way)).without_repeats()
    if len(line) < 2:
        return line.points[:0]
    line = line.cut(0.0, reach)
    fading = np.clip(1 - line.arc_lengths / _FADING, 0, 1)[:, None]
    return np.asarray((line.points + fading * (end - place.point))[1:])


def _straightest(
    tree: Centerline, node: int, onward: list[int], heading: Floats, distance: float
) -> int:
    """Which of the ways onward from a junction leads straight on, looked at from so far away."""
    tips = [tree.points[_ahead(tree, node, n, distance)] - tree.points[node] for n in onward]
    return int(np.argmax([tip @ heading / np.linalg.norm(tip) for tip in tips]))


def _onward(tree: Centerline, came_from: int, node: int) -> list[int]:
    return [n for n in tree.neighbors.of(node) if n != came_from]


def _ahead(tree: Centerline, came_from: int, node: int, distance: float) -> int:
    """The node about `distance` mm onward; branches so near part slowly."""
    start = tree.points[came_from]
    # Ends: never back, and the tree has no circle.
    while dist(tree.points[node], start) < distance:
        onward = _onward(tree, came_from, node)
        if not onward:
            break
        came_from, node = node, onward[0]
    return node
