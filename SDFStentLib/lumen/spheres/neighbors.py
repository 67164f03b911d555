"""Spheres of stations in a row, held against each other: what one holds bounds the next from below.

A climb ends at a local maximum; in a pocket of a rough or folded wall that is no measure of the
lumen. A neighbor's sphere cuts the plane of a station in a disk without wall, and round the foot of
its center there is as much room as the plane leaves of it. Where the disks from before and behind
meet, the lumen runs through there; a station whose sphere is smaller than both sides tell is stuck.
One side alone proves nothing: at an ostium it is the parent vessel's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...geometry import dot, norm
from ...validation import Flags, Floats, Points
from ..tolerances import ALIKE

_REACH = 4
"""Number of stations on each side that are asked: as many may be stuck together."""


class Room(NamedTuple):
    """Bounds on the lumen in each station's plane, from the spheres on one side of it."""

    places: Points
    """(n, 3) feet of their centers,"""
    radii: Floats
    """(n,) least radius of a sphere there, mm; 0 where they give none."""
    disks: Floats
    """(n,) radius of the disk round there that holds no wall, mm."""


def rooms(
    stations: Points, directions: Points, centers: Points, radii: Floats
) -> tuple[Room, Room]:
    """The room that spheres before and behind each station leave in its plane.

    Spheres ask only stations that lie nearer to theirs than their radius.
    """
    before, behind = (_room(stations, directions, centers, radii, way) for way in (-1, 1))
    return before, behind


def are_stuck(radii: Floats, before: Room, behind: Room) -> Flags:
    """Mask (n,) of the spheres that are clearly smaller than both sides imply."""
    meet = norm(before.places - behind.places) < before.disks + behind.disks
    return meet & (np.minimum(before.radii, behind.radii) > ALIKE * radii)


def _room(stations: Points, directions: Points, centers: Points, radii: Floats, way: int) -> Room:
    count = len(stations)
    found = Room(stations.copy(), np.zeros(count), np.zeros(count))
    for step in range(1, min(_REACH, count - 1) + 1):
        own, other = slice(step, None), slice(None, count - step)
        if way > 0:
            own, other = other, own
        height = dot(centers[other] - stations[own], directions[own])
        room = radii[other] - np.abs(height)
        is_near = norm(stations[other] - stations[own]) < radii[other]
        is_more = np.flatnonzero(is_near & (room > found.radii[own]))
        at, by = (np.arange(count)[rows][is_more] for rows in (own, other))
        found.places[at] = centers[by] - height[is_more, None] * directions[at]
        found.radii[at] = room[is_more]
        found.disks[at] = np.sqrt(radii[by] ** 2 - height[is_more] ** 2)
    return found
