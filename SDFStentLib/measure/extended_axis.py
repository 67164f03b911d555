"""The axis of a stent, led on through the vessel beyond both of its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import Surface, cut, length, without_repeats
from ..validation import InputError, Points, as_number, as_points, read_only
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

    At a junction the way goes on in the straightest direction. It ends where vessel or
    centerline end.

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

    def beyond(toward_end: Points) -> Points:
        if reach == 0:
            return toward_end[:0]
        if centerline is None:
            return through_lumen(surface, toward_end, reach)
        return _along_tree(centerline, toward_end, reach)

    before, after = beyond(axis[::-1])[::-1], beyond(axis)
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
    neighbors = _neighbors(tree)
    above = int(tree.parent[place.index])
    sides = [(above, place.index), (place.index, above)]
    ends = [tree.points[_ahead(tree, neighbors, *side, radius)] for side in sides]
    came_from, node = sides[int(np.argmax([(end - place.point) @ heading for end in ends]))]
    way, travelled = [place.point], 0.0
    # Ends: never back, and the tree has no circle.
    while True:
        travelled += float(np.linalg.norm(tree.points[node] - way[-1]))
        way.append(tree.points[node])
        onward = [n for n in neighbors[node] if n != came_from]
        if travelled >= reach or not onward:
            break
        heading = heading_of(np.array(way), radius) if travelled > radius else heading
        tips = [tree.points[_ahead(tree, neighbors, node, n, 2 * radius)] for n in onward]
        turns = [(tip - way[-1]) @ heading / np.linalg.norm(tip - way[-1]) for tip in tips]
        came_from, node = node, onward[int(np.argmax(turns))]
    line = without_repeats(np.array(way))
    if len(line) < 2:
        return line[:0]
    line = cut(line, 0.0, reach)
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    fading = np.clip(1 - along / _FADING, 0, 1)[:, None]
    return np.asarray((line + fading * (axis[-1] - place.point))[1:])


def _neighbors(tree: Centerline) -> list[list[int]]:
    found: list[list[int]] = [[] for _ in tree.points]
    for child, parent in enumerate(tree.parent.tolist()):
        if parent >= 0:
            found[child].append(parent)
            found[parent].append(child)
    return found


def _ahead(
    tree: Centerline, neighbors: list[list[int]], came_from: int, node: int, distance: float
) -> int:
    """The node about `distance` mm onward; branches so near part slowly."""
    start = tree.points[came_from]
    # Ends: never back, and the tree has no circle.
    while np.linalg.norm(tree.points[node] - start) < distance:
        onward = [n for n in neighbors[node] if n != came_from]
        if not onward:
            break
        came_from, node = node, onward[0]
    return node
