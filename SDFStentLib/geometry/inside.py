"""Exact inside test for a surface, open or closed, wound in whatever way.

A place is inside of a part of the surface when that goes round it: its winding number, the sum of
the signed crossings of a ray, is not 0. Jacobson, Kavan and Sorkine-Hornung 2013, doi
10.1145/2461912.2461916, take the same number of an open surface as it is, a fraction; here every
hole has its fan first, so that it is whole, and sharp also beside a wide opening of a short vessel.
A ray through an edge or a vertex is taken as one beside it, the same for all triangles there
(Edelsbrunner and Muecke 1990, doi 10.1145/77635.77639), and every sign is exact: the answer is
never wrong because of where the corners of the mesh are.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices, Points, Triangles
from .distance import closest_points_on_triangles
from .exact import turn_signs, volume_signs
from .rows import blocks_of, norm, ranges

_BLOCK = 1 << 19
"""Pairs of query and triangle that are looked at together; some 50 MB of temporaries."""

_CELLS = 256
"""Cells of the raster along each side: each holds about one triangle of a fine mesh."""

_ON = 1e-12
"""Distance, over the largest coordinate, up to which a place counts as on the surface: rounding."""


class _Pairs(NamedTuple):
    """Pairs (p,) of a query and a triangle that the vertical line through the query may meet."""

    query: Indices
    face: Indices


class Inside:
    """Inside test for closed parts of a surface, see `Surface.contains`.

    Parameters
    ----------
    points : (n, 3) array
    corners : (3, m) array
        First, second and third corners of the triangles; every part of them is closed and wound
        alike throughout.
    part : (m,) array of int
        Number of the part to which each triangle belongs.
    """

    def __init__(self, points: Points, corners: Triangles, part: Indices) -> None:
        # Coordinates in rows of their own: NumPy takes several times longer over rows of three.
        self._columns, self._corners = np.ascontiguousarray(points.T), corners
        self._part, self._part_count = part, int(part.max()) + 1
        self._on = _ON * float(np.abs(self._columns).max())
        self._low, self._high = _extents(self._columns[0], corners)

    def contains(self, queries: Points) -> Flags:
        """Whether each query (k, 3) lies inside of a part, or on the surface."""
        result = np.zeros(len(queries), dtype=bool)
        order = np.argsort(queries[:, 0], kind="stable")
        ordered = np.ascontiguousarray(queries[order].T)
        crossed, counts = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
        for pairs in self._pairs(ordered):
            result[order[self._touched(ordered, pairs)]] = True
            query, part, count = self._crossings(ordered, pairs)
            crossed.append(query * self._part_count + part)
            counts.append(count)
        keys, number = np.unique(np.concatenate(crossed), return_inverse=True)
        winding = np.bincount(number.reshape(-1), np.concatenate(counts), len(keys))
        result[order[keys[winding != 0] // self._part_count]] = True
        return result

    def _pairs(self, queries: Floats) -> Iterator[_Pairs]:
        """Pairs that may meet, in blocks; the queries (3, k) come in the order of x."""
        if not queries.size:
            return
        x, y, _ = queries
        met = np.flatnonzero((self._low <= x[-1] + self._on) & (self._high >= x[0] - self._on))
        sides = _extents(self._columns[1], self._corners.take(met, axis=1))
        low = np.stack([self._low.take(met), sides[0]]) - self._on
        high = np.stack([self._high.take(met), sides[1]]) + self._on
        near = np.flatnonzero(_may_hold(low, high, queries[:2]))
        met, low, high = met.take(near), low.take(near, axis=1), high.take(near, axis=1)
        first = np.searchsorted(x, low[0], side="left")
        counts = np.searchsorted(x, high[0], side="right") - first
        for faces in blocks_of(counts, _BLOCK):
            face = np.repeat(faces, counts[faces])
            query = ranges(first[faces], counts[faces])
            at = y.take(query)
            # Most faces lie beside the line.
            kept = np.flatnonzero((low[1].take(face) <= at) & (at <= high[1].take(face)))
            yield _Pairs(query.take(kept), met.take(face.take(kept)))

    def _touched(self, queries: Floats, pairs: _Pairs) -> Indices:
        """The queries that lie on a triangle."""
        corners = self._columns[2].take(self._corners.take(pairs.face, axis=1))
        z = queries[2].take(pairs.query)
        near = (corners.min(axis=0) - self._on <= z) & (z <= corners.max(axis=0) + self._on)
        query, face = pairs.query[near], pairs.face[near]
        places = np.ascontiguousarray(queries.take(query, axis=1).T)
        triangles = self._columns.take(self._corners.take(face, axis=1), axis=1)
        nearest = closest_points_on_triangles(places, triangles.transpose(2, 1, 0))
        return query[norm(nearest - places) <= self._on]

    def _crossings(self, queries: Floats, pairs: _Pairs) -> tuple[Indices, Indices, Indices]:
        """Query, part and sign of every triangle above a query; the sign is that of the side it
        shows."""
        query, face = pairs
        flat = queries[:2].take(query, axis=1)
        seen = np.zeros(len(query), dtype=np.int64)
        y = self._columns[1].take(self._corners.take(face, axis=1))
        is_above = y > flat[1]
        for k in range(3):
            # A side that goes up in y, or down, and runs past the query on the right in x.
            spans = np.flatnonzero(is_above[k] != is_above[k - 2])
            ends = [self._corners[side].take(face.take(spans)) for side in (k, k - 2)]
            start, end = (self._columns[:2].take(corner, axis=1) for corner in ends)
            turn = turn_signs(start, end, flat.take(spans, axis=1))
            goes_up = np.where(is_above[k].take(spans), -1, 1)
            seen[spans] += np.where(turn == goes_up, goes_up, 0)
        met = np.flatnonzero(seen)
        query, face, seen = query[met], face[met], seen[met]
        corners = [self._columns.take(corner.take(face), axis=1) for corner in self._corners]
        side = volume_signs((corners[0], corners[1], corners[2]), queries.take(query, axis=1))
        above = side * seen < 0
        return query[above], self._part[face[above]], seen[above]


def _may_hold(low: Floats, high: Floats, places: Floats) -> Flags:
    """Mask (m,) of the boxes from low to high (2, m) that may hold one of some places (2, k).

    Places are counted in a raster whose summed-area table gives the count in any rectangle at once:
    Crow 1984, doi 10.1145/964965.808600.
    """
    origin, end = places.min(axis=1, keepdims=True), places.max(axis=1, keepdims=True)
    width = np.where(end > origin, end - origin, 1.0)
    beside = np.logical_and.reduce((low <= end) & (high >= origin))
    near = np.flatnonzero(beside)

    def cells(corners: Floats) -> Indices:
        at = (np.clip(corners, origin, end) - origin) * (_CELLS / width)
        return np.minimum(at.astype(np.int64), _CELLS - 1)

    raster = np.zeros((_CELLS + 1, _CELLS + 1), dtype=np.int64)
    np.add.at(raster[1:, 1:], tuple(cells(places)), 1)
    sums = raster.cumsum(axis=0).cumsum(axis=1).ravel()
    first, last = cells(low.take(near, axis=1)), cells(high.take(near, axis=1)) + 1
    first[0] *= _CELLS + 1
    last[0] *= _CELLS + 1
    count = sums.take(last[0] + last[1]) - sums.take(last[0] + first[1])
    count += sums.take(first[0] + first[1]) - sums.take(first[0] + last[1])
    beside[near] = count > 0
    return beside


def _extents(values: Floats, corners: Triangles) -> tuple[Floats, Floats]:
    """Lowest and highest (m,) of the values of every triangle's corners (3, m)."""
    first, second, third = (values.take(corner) for corner in corners)
    return (
        np.minimum(np.minimum(first, second), third),
        np.maximum(np.maximum(first, second), third),
    )
