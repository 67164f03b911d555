"""Wall round a stent: the room in it, and the share of that which is the lumen's own.

The far wall of a neighboring vessel faces away from the stent as well, but is joined to the stented
lumen only by walls that do not. A sharp limit between own and foreign would let a hair's breadth
decide whether wall is drawn in by a millimeter or not, so wall becomes foreign by degrees.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry import (
    across,
    bits,
    closest_points_on_triangles,
    compacted,
    connected,
    may_meet_box,
    norm,
    product,
)
from ..lumen import LocalSurface
from ..validation import Flags, Floats, Points, Triangles

WITNESSES = 3000
"""Number of points of the wall, about, by which the room round a station is judged."""

SIDES, ASIDE = 12, np.deg2rad(45.0)
"""Number of directions across the axis, and the angle that a witness may lie aside of one: so every
direction across has a witness within 60 degrees."""

TOGETHER, PAIRS = 8, 4096
"""Number of stations, each of which has a bit, and of pairs with triangles, looked at together."""

ROUNDING = 1e-12
"""Rounding of a squared distance, over the largest square that takes part in it."""


class WallAround:
    """The triangles of a surface in the box round a stent, in numbers of their own.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Points and triangles of the whole surface.
    axis : (k, 3) array
        Points of the axis, mm.
    reach : float
        Distance by which the box reaches beyond the axis, mm.

    Attributes
    ----------
    faces : (t,) array
        Numbers of the triangles in the whole surface.
    points, triangles : (p, 3) and (t, 3) arrays
        The triangles in the box and the points that they use, mm.
    """

    def __init__(self, points: Points, triangles: Triangles, axis: Points, reach: float) -> None:
        self._whole, self._reach = (points, triangles), reach
        self._low, self._high = axis.min(axis=0), axis.max(axis=0)
        self._middle = (self._low + self._high) / 2
        is_near = may_meet_box(points, triangles, self._low - reach, self._high + reach)
        self.faces = np.flatnonzero(is_near)
        self.points, self.triangles = compacted(points, triangles.take(self.faces, axis=0))

    def within(self, reach: float) -> Flags:
        """Whether each of the triangles (t,) may lie in a smaller box."""
        return may_meet_box(self.points, self.triangles, self._low - reach, self._high + reach)

    def distances(self, stations: Points) -> Floats:
        """Exact distance (k,) from stations on the axis to the whole surface, mm.

        The nearest place of a triangle is the foot on its plane or on a side. So its squared
        distance is less than that of its nearest corner by a third of the square of its longest
        side at most, and only few triangles need a closer look.
        """
        found = np.full(len(stations), np.inf)
        for first in range(0, len(stations) if len(self.points) else 0, TOGETHER):
            some = slice(first, first + TOGETHER)
            self._shorten(found[some], stations[some])
        # Triangles out of the box are farther away than this.
        if (found > self._reach).any():
            return LocalSurface(*self._whole, stations).distances(stations)
        return found

    def room(self, stations: Points, directions: Points) -> Floats:
        """Upper bound (k,) of the radius, mm, of spheres that hold a station and have their middle
        across.

        A middle at x from a station, in a direction that makes up to 60 degrees with that of a
        witness at w, is x^2 - x w + w^2 or less from the witness, squared: less than w^2 where x
        is less than w, else not more than x^2. There the sphere would not hold the station.

        Parameters
        ----------
        stations, directions : (k, 3) arrays
            Places on the axis, mm, and unit directions along it.
        """
        witnesses = self.points[:: max(1, len(self.points) // WITNESSES)]
        angles = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
        circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        found = np.empty(len(stations))
        for number, sides in enumerate(circle @ across(directions)):
            offset = witnesses - stations[number]
            away = norm(offset)
            is_there = product(sides, offset.T) >= np.cos(ASIDE) * away
            found[number] = np.where(is_there, away, np.inf).min(axis=1, initial=np.inf).max()
        return found

    @cached_property
    def _corners(self) -> tuple[Points, Floats, Floats]:
        """Corners and the squares that a distance needs, for `_shorten`.

        Points (3, p) from the middle of the box, mm; half of their squared lengths (p,); and half
        of the slack (p,): a third of the squared longest side of the triangles at a point, and
        rounding.
        """
        corners = np.ascontiguousarray((self.points - self._middle).T)
        halves = np.einsum("ij,ij->j", corners, corners) / 2
        ends = [corners.take(corner, axis=1) for corner in self.triangles.T]
        sides = (ends[k] - ends[k - 1] for k in range(3))
        longest = np.maximum.reduce([np.einsum("ij,ij->j", side, side) for side in sides])
        slack = np.zeros(len(halves))
        for corner in self.triangles.T:
            np.maximum.at(slack, corner, longest / 6)
        return corners, halves, slack + ROUNDING * halves.max()

    def _shorten(self, found: Floats, stations: Points) -> None:
        """Lower the distances (k,) of up to eight stations, where there is wall."""
        corners, halves, slack = self._corners
        # Half of the squared distances, without the station's own square, which is the same for
        # all.
        squares = halves - product(stations - self._middle, corners)
        nearest = squares.min(axis=1, keepdims=True)
        near = bits(squares <= nearest + slack)[0]
        one, other, third = (near.take(corner) for corner in self.triangles.T)
        may_be = one | other | third
        rows = np.flatnonzero(may_be)
        station, row = np.nonzero(np.unpackbits(may_be[None, rows], axis=0, count=len(stations)))
        for first in range(0, len(station), PAIRS):
            pairs = slice(first, first + PAIRS)
            places = stations.take(station[pairs], axis=0)
            triangles = self.triangles.take(rows.take(row[pairs]), axis=0)
            closest = closest_points_on_triangles(places, self.points.take(triangles, axis=0))
            np.minimum.at(found, station[pairs], norm(places - closest))


FOREIGN = 0.01
"""Share of the tissue gap from which on wall is foreign.

Wall keeps that share where it is turned from the stent by 64 degrees, none up to 60, all from 120
on.
"""


def own_share(sides: NDArray[np.int64], tissue: Floats, nearest: int) -> Floats:
    """Shares (n,), from 1 to 0, with which vertices are wall of the lumen of one of them.

    A chain is as strong as its weakest link: the most foreign vertex on the best way there decides.

    Parameters
    ----------
    sides : (m, 2) array
        Pairs of vertices that are joined.
    tissue : (n,) array
        Share of the tissue gap that each vertex keeps from the stent, in [0, 1].
    nearest : int
        A vertex that is certain to be of the stented lumen, without tissue.
    """
    # Column by column: a reduction over rows of two takes several times as long.
    first, second = sides.T
    is_free, may_be = tissue == 0, tissue < FOREIGN
    joins_free = is_free[first] & is_free[second]
    # Connected free wall is a single node of the graph that has to be searched.
    count, part = connected(len(tissue), first[joins_free], second[joins_free])
    keeps = np.zeros(count)
    keeps[part] = tissue
    bridges = part[sides[may_be[first] & may_be[second] & ~joins_free]]
    start, end = np.concatenate([bridges, bridges[:, ::-1]]).T
    worst = np.full(count, np.inf)
    worst[part[nearest]] = 0
    # Ends: every pass but the last lowers a value to one of finitely many.
    while True:
        reached = worst.copy()
        np.minimum.at(reached, end, np.maximum(worst[start], keeps[end]))
        if (reached == worst).all():
            break
        worst = reached
    return 1 - np.minimum(worst[part] / FOREIGN, 1)
