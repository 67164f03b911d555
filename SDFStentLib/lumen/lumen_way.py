"""Ways through a lumen without centerline, from sphere to sphere, all of them side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry import Line, Surface, dot, norm
from ..validation import Floats, Points
from .spheres import SphereSearch, Until

_STEP = 0.5
"""Step, as a fraction of the radius."""

_WITHIN = 0.9
"""Share of a sphere's radius within which a way goes on: where it has come through an opening into
a wider vessel, half of that vessel's radius may lead out of the lumen."""

_NARROWEST = 0.05
"""Inscribed radius below which a lumen ends, mm."""

_NOTHING = 1e-6
"""Less than this, mm, is not gone on for: rounding could keep it from ever being done."""

_CLOSELY = 1e-4
"""What the search for a sphere on the way promises to gain at least, mm. Where a lumen is flat the
middle is known far less well than the radius, and ways that go on from there part at a junction: at
0.01 they led up to 15 mm apart, by how the search begins."""


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
    middles, radii = search.spheres(last, along / norm(along)[:, None], Until(_CLOSELY))
    goes_on = np.flatnonzero(radii > _NARROWEST)
    heading = np.zeros((len(axes), 3))
    for way in goes_on.tolist():
        heading[way] = heading_of(Line(axes[way]), float(radii[way]))
    # The sphere of an axis that ends in an opening may lie beside its end.
    room = np.maximum(_room(last - middles, heading, radii), _WITHIN * search.distances(last))
    goes_on = goes_on[room[goes_on] > _NARROWEST]
    travelled = np.zeros(len(axes))
    # Ends: every step goes on by half the narrowest radius at least, the room, or what is left.
    while len(goes_on):
        whole = _STEP * radii[goes_on]
        step = np.minimum(np.minimum(whole, room[goes_on]), reach - travelled[goes_on])
        ahead = last[goes_on] + step[:, None] * heading[goes_on]
        centers, wide = search.spheres(ahead, heading[goes_on], Until(_CLOSELY))
        # A sphere that shrinks so fast stands before the end of the vessel.
        is_open = wide > radii[goes_on] - 0.5 * step
        goes_on, whole, wide = goes_on[is_open], whole[is_open], wide[is_open]
        # Half the way to the middle: the way bends no faster than the vessel.
        following = (ahead[is_open] + centers[is_open]) / 2
        moved = following - last[goes_on]
        travelled[goes_on] += norm(moved)
        turned = heading[goes_on] + 0.5 * moved / whole[:, None]
        heading[goes_on], radii[goes_on] = turned / norm(turned)[:, None], wide
        last[goes_on] = following
        room[goes_on] = _room(following - centers[is_open], heading[goes_on], wide)
        for way, place in zip(goes_on.tolist(), following, strict=True):
            found[way].append(place)
        goes_on = goes_on[(room[goes_on] > _NARROWEST) & (travelled[goes_on] < reach - _NOTHING)]
    return [np.reshape(way, (-1, 3)) for way in found]


def _room(offset: Points, heading: Points, radii: Floats) -> Floats:
    """How far (n,) a way may go on in a sphere from an offset to its middle; 0 beside it."""
    along = dot(offset, heading)
    left = along**2 - dot(offset, offset) + (_WITHIN * radii) ** 2
    return np.where(left > 0, np.sqrt(np.maximum(left, 0.0)) - along, 0.0)


def heading_of(axis: Line, window: float) -> Floats:
    """Unit direction in which a line ends, over its last `window` mm."""
    total = axis.length
    way = axis.points[-1] - axis.cut(max(0.0, total - window), total).points[0]
    return np.asarray(way / np.linalg.norm(way))
