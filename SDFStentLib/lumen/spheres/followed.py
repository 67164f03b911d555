"""Wall round stations, followed as it moves, for the growth of a sphere there at little cost.

Of the wall the nearest point in each of some directions stands for all of it. Among so few points a
sphere climbs in a hundredth of the time that the whole wall takes, and is a little too large; how
much larger it becomes when they move is right to about a percent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...geometry import Balls, across, dot, norm
from ...validation import Floats, Indices, Points
from ..tolerances import ALIKE, OWN_WIDTH
from .climb import CORNERS, WAY_BOX, InscribedSpheres, next_boxes
from .max_min_step import LinearRows, largest_steps

_ACROSS = 6
"""Directions by side of a cube: 15 degrees each."""

_MORE = 3.0
"""Distance beyond a vessel's own wall, mm, of wall that is followed: a stent that is wider than the
vessel reaches wall that no sphere touched before it."""

_STEPS = 5
"""Steps of a climb; with more of them radii change by less than a percent."""

Around = Callable[[Points], tuple[Indices, Points]]


class FollowedWall(NamedTuple):
    """Points of the wall round n stations, and the spheres among them before they moved."""

    station: Indices
    """(k,) ascending,"""
    point: Indices
    """(k,) and a point of the surface."""
    spheres: InscribedSpheres
    """(n,)"""

    def spheres_after(
        self, states: tuple[Points, Points], shifts: Points, axes: Floats
    ) -> tuple[Indices, InscribedSpheres]:
        """Stations (t,) that moved wall touches, and the spheres (t,) there among the points.

        Parameters
        ----------
        states : pair of (m, 3) arrays
            The points of the surface before and now.
        shifts : (n, 3) array
            Moves of the stations, mm.
        axes : (n, 2, 3) array
            Two directions across each of them now.
        """
        before, now = states
        columns = zip(before.T, now.T, strict=True)
        has_moved = np.logical_or.reduce([one != other for one, other in columns])
        rows = np.flatnonzero(has_moved.take(self.point))
        station, point = self.station.take(rows), self.point.take(rows)
        starts = self.spheres.centers + shifts
        away = [
            norm(points.take(point, axis=0) - centers.take(station, axis=0))
            for points, centers in ((before, self.spheres.centers), (now, starts))
        ]
        is_touching = np.minimum(*away) <= ALIKE * self.spheres.radii.take(station)
        touched = np.unique(station[is_touching])
        number = np.full(len(starts), -1)
        number[touched] = np.arange(len(touched))
        own = number.take(self.station)
        kept = np.flatnonzero(own >= 0)
        places = now.take(self.point.take(kept), axis=0)
        walls = own.take(kept), places
        found = among_points(lambda _: walls, starts[touched], axes[touched])
        return touched, found


def followed_wall(
    wall: Balls, stations: Points, directions: Points, diameters: Floats
) -> FollowedWall:
    """The nearest point of the wall round stations (n, 3) within a vessel in every direction.

    Parameters
    ----------
    wall : Balls
        The points of the surface, of no size.
    stations, directions : (n, 3) arrays
        mm, and unit directions of the vessel.
    diameters : (n,) array
        About how wide it is, mm.
    """
    station, point = wall.near(stations, OWN_WIDTH / 2 * diameters + _MORE)
    offset = wall.middles.take(point, axis=0) - stations.take(station, axis=0)
    field = station * (6 * _ACROSS**2) + _fields(offset)
    order = np.lexsort((dot(offset, offset), field))
    is_first = np.ones(len(order), dtype=bool)
    np.not_equal(field[order[1:]], field[order[:-1]], out=is_first[1:])
    nearest = order[is_first]
    station, point = station[nearest], point[nearest]
    walls = station, wall.middles.take(point, axis=0)
    spheres = among_points(lambda _: walls, stations, across(directions))
    return FollowedWall(station, point, spheres)


def _fields(offsets: Points) -> Indices:
    """The field, of equal angles, of a cube round the origin in which each direction (n, 3) is."""
    rows = np.arange(len(offsets))
    axis = np.abs(offsets).argmax(axis=1)
    height = offsets[rows, axis]
    found = 2 * axis + (height > 0)
    for turn in (1, 2):
        slope = offsets[rows, (axis + turn) % 3] / np.abs(height)
        at = np.floor(_ACROSS * (np.arctan(slope) / (np.pi / 2) + 0.5)).astype(np.int64)
        found = found * _ACROSS + np.clip(at, 0, _ACROSS - 1)
    return np.asarray(found)


def among_points(around: Around, starts: Points, axes: Floats) -> InscribedSpheres:
    """The spheres among points that stand for a wall to which a few steps lead.

    Parameters
    ----------
    around : callable
        Gives the points (k, 3) round the centers (n, 3) that are reached, and before them to which
        center each belongs (k,), in order. Every center has one.
    starts : (n, 3) array
        mm.
    axes : (n, 2, 3) array
        Directions in which the centers move.
    """
    count = len(starts)
    centers, box = starts.copy(), np.empty(0)
    if not count:
        return InscribedSpheres(centers, box)
    numbers = np.arange(count)
    for step_number in range(_STEPS + 1):
        station, places = around(centers)
        offset = centers.take(station, axis=0) - places
        distance = norm(offset)
        radii = np.minimum.reduceat(distance, np.searchsorted(station, numbers))
        if step_number == _STEPS:
            break
        box = WAY_BOX * radii if step_number == 0 else box
        near = np.flatnonzero(distance <= (radii + CORNERS * box).take(station))
        own, apart = station.take(near), distance.take(near)
        slope = np.einsum("nij,nj->ni", axes.take(own, axis=0), offset.take(near, axis=0))
        slope /= np.maximum(apart, 1e-300)[:, None]
        rows = LinearRows(apart, slope, np.searchsorted(own, numbers), radii)
        step, height = largest_steps(rows, box)
        centers += np.einsum("ni,nij->nj", step, axes)
        box = next_boxes(step, height, box)
    return InscribedSpheres(centers, radii)
