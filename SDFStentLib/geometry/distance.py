"""Exact distance from points to a triangle surface.

A triangle lies inside a thin round disc about its centroid. The distance to the disc is a lower
bound of the distance to the triangle, and cheap; only triangles whose disc comes near enough are
looked at exactly. Nothing is ever missed, however uneven the mesh is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Floats, Indices, Points, Triangles
from .rows import dot, norm

_BLOCK = 128
"""Queries looked at together; each may meet some thousand triangles at the centre of a tube."""

_PAIR_BLOCK = 4096
"""Pairs looked at together: their temporaries stay in the processor's cache."""

_SLACK = 1e-12
"""Relative widening of bounds, against rounding."""


class SurfaceDistance(NamedTuple):
    """Distance (n,), mm; nearest point (n, 3) of the surface, mm; triangle (n,) it lies on."""

    distance: Floats
    closest_point: Points
    triangle: Indices


class NearPairs(NamedTuple):
    """Pairs (p,) of query and triangle, sorted by query."""

    query: Indices
    triangle: Indices


def closest_points_on_triangles(queries: Points, corners: Floats) -> Points:
    """Nearest point of triangle i to query i.

    The nearest of the foot on the plane (where it lies inside) and the feet on the three sides.
    Every one of them is a point of the triangle, so that the distance to a needle is never too
    small.

    Parameters
    ----------
    queries : (n, 3) array
    corners : (n, 3, 3) array
        Triangle, corner, coordinate.
    """
    first = corners[:, 0]
    u, v, offset = corners[:, 1] - first, corners[:, 2] - first, queries - first
    uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
    pu, pv = dot(offset, u), dot(offset, v)
    squared_area = uu * vv - uv * uv
    safe = np.where(squared_area > 0, squared_area, 1.0)
    s, t = (vv * pu - uv * pv) / safe, (uu * pv - uv * pu) / safe
    is_inside = (squared_area > 0) & (s >= 0) & (t >= 0) & (s + t <= 1)

    best = first + np.clip(pu / np.where(uu > 0, uu, 1.0), 0, 1)[:, None] * u
    offset = queries - best
    best_distance = dot(offset, offset)
    for candidate, usable in (
        (first + np.clip(pv / np.where(vv > 0, vv, 1.0), 0, 1)[:, None] * v, True),
        (_foot_on_third_side(queries, corners), True),
        (first + s[:, None] * u + t[:, None] * v, is_inside),
    ):
        offset = queries - candidate
        distance = dot(offset, offset)
        is_better = usable & (distance < best_distance)
        best[is_better] = candidate[is_better]
        best_distance[is_better] = distance[is_better]
    return best


class SurfaceIndex:
    """Triangles of a surface, prepared for many questions about what lies near.

    Parameters
    ----------
    points, triangles : (k, 3) and (m, 3) arrays
        Known to be sound.

    Attributes
    ----------
    corners : (m, 3, 3) array
        Triangle, corner, coordinate, mm.

    Notes
    -----
    Triangles are sorted into classes of similar size, each with its own tree of centroids: a few
    huge triangles do not widen the search among the small ones.
    """

    def __init__(self, points: Points, triangles: Triangles) -> None:
        # Imported here: scipy costs half a second, which a first frame should not pay.
        from scipy.spatial import cKDTree

        self.corners: Floats = points[triangles]
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        self._centroids = (a + b + c) / 3.0
        arms = [corner - self._centroids for corner in (a, b, c)]
        squared = np.maximum.reduce([dot(arm, arm) for arm in arms])
        self._disc_radii = np.sqrt(squared)
        normals = np.cross(arms[1] - arms[0], arms[2] - arms[0])
        lengths = norm(normals)
        self._normals = normals / np.where(lengths > 0, lengths, 1.0)[:, None]
        # Rounding tilts the normal of a needle: its disc gets the thickness that this costs.
        self._thickness = np.maximum.reduce([np.abs(dot(arm, self._normals)) for arm in arms])
        self._trees = [
            (cKDTree(self._centroids[members], balanced_tree=False, compact_nodes=False), members)
            for members in _size_classes(self._disc_radii)
        ]

    def distances(self, queries: Points) -> SurfaceDistance:
        """Distance, nearest point and triangle of every query (n, 3)."""
        distance = np.empty(len(queries))
        closest = np.empty((len(queries), 3))
        triangle = np.empty(len(queries), dtype=np.int64)
        for start in range(0, len(queries), _BLOCK):
            block = slice(start, start + _BLOCK)
            distance[block], closest[block], triangle[block] = self._distances(queries[block])
        return SurfaceDistance(distance, closest, triangle)

    def near(self, queries: Points, radii: Floats) -> NearPairs:
        """Pairs of query (n, 3) and triangle: all that come within `radii` (n,), and few more."""
        parts = []
        for tree, members in self._trees:
            reach = radii * (1 + _SLACK) + self._disc_radii[members].max()
            found = tree.query_ball_point(queries, reach, return_sorted=False)
            counts = np.array([len(hits) for hits in found], dtype=np.int64)
            if counts.sum():
                hits = np.concatenate([np.asarray(hits, dtype=np.int64) for hits in found])
                parts.append((np.repeat(np.arange(len(queries)), counts), members[hits]))
        if not parts:
            return NearPairs(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
        query, triangle = (np.concatenate(column) for column in zip(*parts, strict=True))
        is_near = self.lower_bounds(queries[query], triangle) <= radii[query] * (1 + _SLACK)
        query, triangle = query[is_near], triangle[is_near]
        if len(parts) > 1:
            order = np.argsort(query, kind="stable")
            query, triangle = query[order], triangle[order]
        return NearPairs(query, triangle)

    def lower_bounds(self, queries: Points, triangle: Indices) -> Floats:
        """Distance (p,) from query i to the disc round triangle i: never above the true one."""
        offset = queries - self._centroids[triangle]
        height = dot(offset, self._normals[triangle])
        aside = np.sqrt(np.maximum(dot(offset, offset) - height**2, 0.0))
        aside = np.maximum(aside - self._disc_radii[triangle], 0.0)
        above = np.maximum(np.abs(height) - self._thickness[triangle], 0.0)
        return np.sqrt(above**2 + aside**2) * (1 - _SLACK)

    def closest_points(self, queries: Points, triangle: Indices) -> Points:
        """Nearest point (p, 3) of triangle i to query i."""
        closest = np.empty_like(queries)
        for start in range(0, len(queries), _PAIR_BLOCK):
            block = slice(start, start + _PAIR_BLOCK)
            corners = self.corners[triangle[block]]
            closest[block] = closest_points_on_triangles(queries[block], corners)
        return closest

    def _distances(self, queries: Points) -> SurfaceDistance:
        bound = np.full(len(queries), np.inf)
        for tree, _ in self._trees:
            bound = np.minimum(bound, tree.query(queries)[0])
        query, triangle = self.near(queries, bound)
        closest = self.closest_points(queries[query], triangle)
        distance = norm(queries[query] - closest)
        order = np.lexsort((distance, query))
        first = order[np.searchsorted(query[order], np.arange(len(queries)))]
        return SurfaceDistance(distance[first], closest[first], triangle[first])


def _size_classes(sizes: Floats) -> list[Indices]:
    """Members of each class; in a class the largest size is at most twice the smallest.

    Everything below 1/64 of the typical size is one class: a search there is narrow anyway.
    """
    typical = np.median(sizes)
    floor = max(typical, np.finfo(float).tiny) / 64
    level = np.floor(np.log2(np.maximum(sizes, floor) / floor)).astype(np.int64)
    # The common sizes stay together: one wide class costs less than two trees.
    level[(sizes <= 2 * typical)] = 0
    return [np.flatnonzero(level == number) for number in np.unique(level)]


def _foot_on_third_side(queries: Points, corners: Floats) -> Points:
    start, side = corners[:, 1], corners[:, 2] - corners[:, 1]
    squared = dot(side, side)
    fraction = dot(queries - start, side) / np.where(squared > 0, squared, 1.0)
    return start + np.clip(fraction, 0, 1)[:, None] * side
