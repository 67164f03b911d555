"""The axis of a stent, continued through the vessel beyond both of its ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import dist

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import Centerline
from ..geometry import Line, Surface, as_line, dot, norm
from ..validation import Floats, InputError, Points, as_number
from .spheres import SphereSearch, Until
from .tolerances import CENTERED, FINEST, NOTHING, TOLERANCE, WITHIN


def through_lumen(surface: Surface, axes: Sequence[Points], reach: float) -> list[Points]:
    """Points (n, 3) beyond the ends of some axes, for `reach` mm or to the end of the lumen.

    Each sphere's center is free in the plane across the way so far.
    """
    found: list[list[Points]] = [[] for _ in axes]
    if not axes:
        return []
    last = np.array([axis[-1] for axis in axes])
    search = SphereSearch(surface, last, reach)
    along = np.array([axis[-1] - axis[-2] for axis in axes])
    middles, radii = search.spheres(last, along / norm(along)[:, None], Until(TOLERANCE))
    goes_on = np.flatnonzero(radii > FINEST / 2)
    heading = np.zeros((len(axes), 3))
    for way in goes_on.tolist():
        heading[way] = heading_of(Line(axes[way]), float(radii[way]))
    # The sphere of an axis that ends in an opening may lie beside its end.
    room = np.maximum(_room(last - middles, heading, radii), WITHIN * search.distances(last))
    goes_on = goes_on[room[goes_on] > FINEST / 2]
    traveled = np.zeros(len(axes))
    # Ends, since every step is at least half the narrowest radius, the room, or the rest.
    while len(goes_on):
        whole = CENTERED * radii[goes_on]
        step = np.minimum(np.minimum(whole, room[goes_on]), reach - traveled[goes_on])
        ahead = last[goes_on] + step[:, None] * heading[goes_on]
        centers, wide = search.spheres(ahead, heading[goes_on], Until(TOLERANCE))
        # A sphere that shrinks this fast is near the end of the vessel.
        is_open = wide > radii[goes_on] - 0.5 * step
        goes_on, whole, wide = goes_on[is_open], whole[is_open], wide[is_open]
        # Half the way to the middle: the way bends no faster than the vessel.
        following = (ahead[is_open] + centers[is_open]) / 2
        moved = following - last[goes_on]
        traveled[goes_on] += norm(moved)
        turned = heading[goes_on] + 0.5 * moved / whole[:, None]
        heading[goes_on], radii[goes_on] = turned / norm(turned)[:, None], wide
        last[goes_on] = following
        room[goes_on] = _room(following - centers[is_open], heading[goes_on], wide)
        for way, place in zip(goes_on.tolist(), following, strict=True):
            found[way].append(place)
        goes_on = goes_on[(room[goes_on] > FINEST / 2) & (traveled[goes_on] < reach - NOTHING)]
    return [np.reshape(way, (-1, 3)) for way in found]


def _room(offset: Points, heading: Points, radii: Floats) -> Floats:
    """Distance (n,) that a way may go on in a sphere from an offset to its middle; 0 beside it.

    Where it has come through an opening into a wider vessel, half of that vessel's radius may lead
    out of the lumen.
    """
    along = dot(offset, heading)
    left = along**2 - dot(offset, offset) + (WITHIN * radii) ** 2
    return np.where(left > 0, np.sqrt(np.maximum(left, 0.0)) - along, 0.0)


def heading_of(axis: Line, window: float) -> Floats:
    """Unit direction (3,) in which a line ends, over its last `window` mm."""
    total = axis.length
    way = axis.points[-1] - axis.cut(max(0.0, total - window), total).points[0]
    return np.asarray(way / np.linalg.norm(way))


REACH = 20.0
"""Distance beyond an end of the stent up to which its surroundings are looked at, and over
which the way changes from its axis to the centerline, mm."""


@dataclass(frozen=True)
class ExtendedAxis:
    """A stent's axis and the way beyond its ends, proximal to distal.

    Positions on it count from the proximal end of the stent: negative proximal of it.
    """

    line: Line
    before: float
    """Length proximal of the stent, mm."""
    stent_length: float
    """Length of the stent, mm."""

    @property
    def points(self) -> Points:
        """The points (n, 3) of the axis, mm."""
        return self.line.points

    @cached_property
    def of_stent(self) -> Line:
        """The part of the axis along the stent."""
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
    """The axis continued along the centerline; without a centerline, through the middle of the
    lumen.

    At a junction it goes on toward the root, or away from it in the straightest direction. It
    ends where the vessel or the centerline ends.

    Parameters
    ----------
    surface : Surface
        mm.
    stent_axis : Line or array_like, shape (n, 3)
        Axis of the stent from its proximal to its distal end, mm.
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
    """The tree's points from the end of the axis on; the first ones are drawn to that end."""
    end = axis.points[-1]
    place = tree.project(end)
    radius = place.inscribed_radius if place.inscribed_radius > 0 else 1.0
    heading = heading_of(axis, radius)
    above = int(tree.parent[place.index])
    sides = [(place.index, above), (above, place.index)]
    tips = [tree.points[_ahead(tree, *side, radius)] for side in sides]
    came_from, node = sides[int(np.argmax([(tip - place.point) @ heading for tip in tips]))]
    way, traveled = [place.point], 0.0
    # Ends: never back, and the tree has no circle.
    while True:
        traveled += dist(tree.points[node], way[-1])
        way.append(tree.points[node])
        onward = _onward(tree, came_from, node)
        if traveled >= reach or not onward:
            break
        above = int(tree.parent[node])
        came_from, after = node, above if above in onward else onward[0]
        if len(onward) > 1 and after != above:
            ahead = heading_of(Line(np.array(way)), radius) if traveled > radius else heading
            after = onward[_straightest(tree, node, onward, ahead, 2 * radius)]
        node = after
    line = Line(np.array(way)).without_repeats()
    if len(line) < 2:
        return line.points[:0]
    line = line.cut(0.0, reach)
    fading = np.clip(1 - line.arc_lengths / REACH, 0, 1)[:, None]
    return np.asarray((line.points + fading * (end - place.point))[1:])


def _straightest(
    tree: Centerline, node: int, onward: list[int], heading: Floats, distance: float
) -> int:
    """The way onward from a junction that leads straight on, as seen over this distance."""
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
