"""The axis of a stent, led on through the vessel beyond both of its ends."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import Surface, cut, length, without_repeats
from ..validation import Floats, InputError, Points, as_number, as_points, read_only
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

    points: Points
    """(n, 3) mm."""
    before: float
    """Length proximal of the stent, mm."""
    stent_length: float
    """mm."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", read_only(self.points))

    @property
    def of_stent(self) -> Points:
        """(k, 3) the part along the stent, mm."""
        return cut(self.points, self.before, self.before + self.stent_length)

    @property
    def after(self) -> float:
        """Length distal of the stent, mm."""
        return length(self.points) - self.before - self.stent_length


def extended_axis(
    surface: Surface,
    stent_axis: ArrayLike,
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
    stent_axis : array_like, shape (n, 3)
        From the proximal to the distal end, mm.
    centerline : Centerline, optional
    reach : float
        Wanted length beyond each end, mm.

    Raises
    ------
    InputError
        An axis without length, or a reach below 0.
    """
    axis = without_repeats(as_points(stent_axis, "stent_axis", minimum=2))
    if len(axis) < 2:
        raise InputError("stent_axis: expected two different points at least, got one place.")
    as_number(reach, "reach", unit="mm", minimum=0)

    sides = [axis[::-1], axis]
    if reach == 0:
        ways = [axis[:0], axis[:0]]
    elif centerline is None:
        ways = through_lumen(surface, sides, reach)
    else:
        ways = [_along_tree(centerline, side, reach) for side in sides]
    before, after = ways[0][::-1], ways[1]
    return ExtendedAxis(
        np.concatenate([before, axis, after]),
        length(np.concatenate([before, axis[:1]])),
        length(axis),
    )


def _along_tree(tree: Centerline, axis: Points, reach: float) -> Points:
    """The tree's points from the end of the axis on, the first ones drawn to that end."""
    place = tree.project(axis[-1])
    radius = place.inscribed_radius if place.inscribed_radius > 0 else 1.0
    heading = heading_of(axis, radius)
    above = int(tree.parent[place.index])
    sides = [(place.index, above), (above, place.index)]
    ends = [tree.points[_ahead(tree, *side, radius)] for side in sides]
    came_from, node = sides[int(np.argmax([(end - place.point) @ heading for end in ends]))]
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
            ahead = heading_of(np.array(way), radius) if travelled > radius else heading
            after = onward[_straightest(tree, node, onward, ahead, 2 * radius)]
        node = after
    line = without_repeats(np.array(way))
    if len(line) < 2:
        return line[:0]
    line = cut(line, 0.0, reach)
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    fading = np.clip(1 - along / _FADING, 0, 1)[:, None]
    return np.asarray((line + fading * (axis[-1] - place.point))[1:])


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
