"""Exact distance from points to a triangle surface.

A triangle lies inside a thin round disc about its centroid. The distance to the disc is a lower
bound of the distance to the triangle, and cheap; only triangles whose disc comes near enough are
looked at exactly. Nothing is ever missed, however uneven the mesh is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..validation import Floats, Indices, Points, Triangles
from .near_balls import Balls
from .rows import dot, in_blocks, norm, used_points

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_BLOCK = 128
"""Queries looked at together; each may meet some thousand triangles at the center of a tube."""

_PAIR_BLOCK = 4096
"""Pairs looked at together: their temporaries stay in the processor's cache."""

_TOUCHING = 1e-6
"""Distance, mm, below which a point counts as on a surface."""

_TISSUE = 6.0
"""Distance, mm, beyond which a wall across does not matter: about where motion fades out."""

_BALLS = (0.2, 0.4, 0.8, 1.6, 3.0)
"""Radii, mm, of balls beside a place in which a wall across is looked for."""

_FACING = 0.5
_NEAREST = 6

_SLACK = 1e-12
"""Relative widening of bounds, against rounding."""


class SurfaceDistance(NamedTuple):
    """Distance (n,), mm; nearest point (n, 3) of the surface, mm; triangle (n,) it lies on."""

    distance: Floats
    closest_point: Points
    triangle: Indices


class NearPairs(NamedTuple):
    """Pairs (p,) of query and triangle, sorted by query; their distance is at least `bound`, mm."""

    query: Indices
    triangle: Indices
    bound: Floats


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
    # Coordinates in rows of their own: NumPy takes several times longer over rows of three.
    first, second, third = np.ascontiguousarray(np.moveaxis(corners, 0, 2))
    offset, u, v = queries.T - first, second - first, third - first
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    pu, pv = _dot(offset, u), _dot(offset, v)
    squared_area = uu * vv - uv * uv
    safe = np.where(squared_area > 0, squared_area, 1.0)
    s, t = (vv * pu - uv * pv) / safe, (uu * pv - uv * pu) / safe
    is_inside = (squared_area > 0) & (s >= 0) & (t >= 0) & (s + t <= 1)
    on_third = np.clip(_quotient((pv - pu) + (uu - uv), uu - 2 * uv + vv), 0, 1)

    best_s, best_t = np.clip(_quotient(pu, uu), 0, 1), np.zeros(len(queries))
    rest = offset - best_s * u
    best = _dot(rest, rest)
    for along_u, along_v, usable in (
        (np.zeros(len(queries)), np.clip(_quotient(pv, vv), 0, 1), True),
        (1 - on_third, on_third, True),
        (s, t, is_inside),
    ):
        rest = offset - along_u * u - along_v * v
        squared = _dot(rest, rest)
        is_better = usable & (squared < best)
        best_s = np.where(is_better, along_u, best_s)
        best_t = np.where(is_better, along_v, best_t)
        best = np.where(is_better, squared, best)
    return np.ascontiguousarray((first + best_s * u + best_t * v).T)


WIDENED = 1.2
"""A point follows every place of a surface up to this many times as far as the nearest one. So a
point between two walls, as in a crotch, follows both, and its weights jump nowhere."""


def following_weights(points: Points, triangles: Triangles, queries: Points) -> csr_array:
    """Weights (k, n) with which places near a surface follow its points (n, 3).

    Each place moves as the nearest places of the triangles nearby do on average: where these all
    shift alike, it shifts with them.
    """
    from scipy.sparse import coo_array  # late: it costs half a second

    index = SurfaceIndex(points, triangles)
    nearest = index.distances(queries).distance
    reach = np.maximum(WIDENED * nearest, nearest + _TOUCHING)
    rows, columns, values = [], [], []
    for start in range(0, len(queries), _BLOCK):
        block = slice(start, start + _BLOCK)
        query, face, _ = index.near(queries[block], reach[block])
        own = start + query
        places = queries.take(own, axis=0)
        closest = index.closest_points(places, face)
        beyond = (norm(places - closest) - nearest[own]) / (reach - nearest)[own]
        weight = np.maximum(1 - beyond, 0) ** 2
        rows.append(np.repeat(own, 3))
        columns.append(triangles.take(face, axis=0).ravel())
        shares = _barycentric(closest, index.corners.take(face, axis=0))
        values.append((weight[:, None] * shares).ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    weights = _rows_normalized(coo_array(entries, shape=(len(queries), len(points))).tocsr())
    return _between_walls(weights, points, triangles, queries)


def _rows_normalized(weights: csr_array) -> csr_array:
    sums = np.asarray(weights.sum(axis=1)).ravel()
    weights.data /= np.repeat(np.where(sums > 0, sums, 1), np.diff(weights.indptr))
    return weights


def _between_walls(
    weights: csr_array, points: Points, triangles: Triangles, queries: Points
) -> csr_array:
    """Weights with which a place between two walls follows each by its nearness.

    So tissue between the walls is compressed evenly, as in a crotch of which one side moves toward
    the other. Weights of 1 / d keep the order of places between two walls that do not cross.

    In a crotch one side moves toward the other. With weights as 1 / d a place keeps its order
    between the two, whatever these do that do not cross each other.
    """
    from scipy.sparse import coo_array, diags_array
    from scipy.spatial import cKDTree

    used = used_points(triangles)
    tree = cKDTree(points[used])
    foot = weights @ points
    away = queries - foot
    own = norm(away)
    away /= np.maximum(own, _TOUCHING)[:, None]
    across = np.full(len(queries), np.inf)
    for radius in _BALLS:
        left = np.flatnonzero(np.isinf(across) & (own > _TOUCHING))
        found = tree.query(queries[left] + radius * away[left])[1]
        offset = points[used[found]] - queries[left]
        distance = norm(offset)
        faces = dot(offset, away[left]) > _FACING * distance
        across[left[faces]] = distance[faces]
    near = np.flatnonzero(across < _TISSUE)
    if not len(near):
        return weights
    distance, other = tree.query(queries[near] + across[near, None] * away[near], k=_NEAREST)
    shares = 1 / (distance + _TOUCHING)
    rows = np.repeat(near, _NEAREST)
    entries = shares.ravel(), (rows, used[other].ravel())
    facing = _rows_normalized(coo_array(entries, shape=weights.shape).tocsr())
    beside, beyond = np.ones(len(queries)), np.zeros(len(queries))
    beside[near] = np.maximum(1 / own[near] - 1 / _TISSUE, 0)
    beyond[near] = 1 / across[near] - 1 / _TISSUE
    return _rows_normalized((diags_array(beside) @ weights + diags_array(beyond) @ facing).tocsr())


def _barycentric(places: Points, corners: Floats) -> Floats:
    """Shares (p, 3) of the corners (p, 3, 3) in places on their triangles."""
    first, second, third = corners.swapaxes(0, 1)
    u, v, offset = second - first, third - first, places - first
    uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
    squared_area = uu * vv - uv * uv
    s = _quotient(vv * dot(offset, u) - uv * dot(offset, v), squared_area)
    t = _quotient(uu * dot(offset, v) - uv * dot(offset, u), squared_area)
    shares = np.clip(np.stack([1 - s - t, s, t], axis=1), 0, 1)
    return shares / shares.sum(axis=1, keepdims=True)


class SurfaceIndex:
    """Triangles of a surface, prepared for many questions about what lies near.

    Parameters
    ----------
    points, triangles : (k, 3) and (m, 3) arrays
        Points and triangles of the surface, known to be sound.

    Attributes
    ----------
    corners : (m, 3, 3) array
        Triangle, corner, coordinate, mm.
    centroids, disc_radii : (m, 3) and (m,) arrays
        Centers and radii of the discs that hold the triangles, mm.
    discs : Balls
        These.
    """

    def __init__(self, points: Points, triangles: Triangles) -> None:
        # `take` copies rows several times quicker than an index in brackets does; so below.
        self.corners: Floats = points.take(triangles, axis=0)
        columns = np.ascontiguousarray(points.T)
        found = in_blocks(lambda block: _discs(columns, block), triangles)
        self.centroids: Points = np.ascontiguousarray(found[:3].T)
        self.disc_radii: Floats = found[3].copy()
        self.discs = Balls(self.centroids, self.disc_radii)
        self._normals = np.ascontiguousarray(found[4:7].T)
        self._thickness = found[7].copy()

    def distances(self, queries: Points) -> SurfaceDistance:
        """Distance, nearest point and triangle of every query (n, 3)."""
        distance = np.empty(len(queries))
        closest = np.empty((len(queries), 3))
        triangle = np.empty(len(queries), dtype=np.int64)
        for start in range(0, len(queries), _BLOCK):
            block = slice(start, start + _BLOCK)
            distance[block], closest[block], triangle[block] = self._distances(queries[block])
        return SurfaceDistance(distance, closest, triangle)

    def nearest_middles(self, queries: Points) -> Floats:
        """Distance (n,) from every query to the nearest centroid."""
        return self.discs.nearest(queries)

    def near(self, queries: Points, radii: Floats) -> NearPairs:
        """Pairs of query (n, 3) and triangle: all that come within `radii` (n,), and few more."""
        query, triangle = self.discs.near(queries, radii)
        bound = self.lower_bounds(queries.take(query, axis=0), triangle)
        is_near = np.flatnonzero(bound <= radii.take(query) * (1 + _SLACK))
        return NearPairs(query.take(is_near), triangle.take(is_near), bound.take(is_near))

    def lower_bounds(self, queries: Points, triangle: Indices) -> Floats:
        """Distance (p,) from query i to the disc round triangle i: never above the true one."""
        offset = queries - self.centroids.take(triangle, axis=0)
        height = dot(offset, self._normals.take(triangle, axis=0))
        aside = np.sqrt(np.maximum(dot(offset, offset) - height**2, 0.0))
        aside = np.maximum(aside - self.disc_radii.take(triangle), 0.0)
        above = np.maximum(np.abs(height) - self._thickness.take(triangle), 0.0)
        return np.sqrt(above**2 + aside**2) * (1 - _SLACK)

    def closest_points(self, queries: Points, triangle: Indices) -> Points:
        """Nearest point (p, 3) of triangle i to query i."""
        closest = np.empty_like(queries)
        for start in range(0, len(queries), _PAIR_BLOCK):
            block = slice(start, start + _PAIR_BLOCK)
            corners = self.corners.take(triangle[block], axis=0)
            closest[block] = closest_points_on_triangles(queries[block], corners)
        return closest

    def _distances(self, queries: Points) -> SurfaceDistance:
        query, triangle, _ = self.near(queries, self.nearest_middles(queries))
        places = queries.take(query, axis=0)
        closest = self.closest_points(places, triangle)
        distance = norm(places - closest)
        # The first of the nearest of each query: pairs are sorted by query.
        starts = np.searchsorted(query, np.arange(len(queries)))
        least = np.minimum.reduceat(distance, starts)
        hits = np.flatnonzero(distance == least.take(query))
        first = hits.take(np.searchsorted(hits, starts))
        return SurfaceDistance(distance[first], closest[first], triangle[first])


def _discs(columns: Floats, triangles: Triangles) -> Floats:
    """Discs round triangles (m, 3), by columns (3, n) of the points, in rows (8, m).

    Centroid, radius, unit normal and thickness: rounding tilts the normal of a needle, whose disc
    gets the thickness that this costs.
    """
    # Coordinates in rows of their own, (coordinate, corner, triangle).
    arms = columns.take(np.ascontiguousarray(triangles.T), axis=1)
    middles = (arms[:, 0] + arms[:, 1] + arms[:, 2]) / 3.0
    arms -= middles[:, None]
    radii = np.sqrt(_dot(arms, arms).max(axis=0))
    (a, b, c), (x, y, z) = arms[:, 1] - arms[:, 0], arms[:, 2] - arms[:, 0]
    normals = np.stack([b * z - c * y, c * x - a * z, a * y - b * x])
    lengths = np.sqrt(_dot(normals, normals))
    normals /= np.where(lengths > 0, lengths, 1.0)
    thickness = np.abs(_dot(arms, normals[:, None])).max(axis=0)
    return np.stack([*middles, radii, *normals, thickness])


def _dot(one: Floats, other: Floats) -> Floats:
    """Scalar products (n,) of columns (3, n), or of stacks of them."""
    return np.asarray(one[0] * other[0] + one[1] * other[1] + one[2] * other[2])


def _quotient(above: Floats, below: Floats) -> Floats:
    return above / np.where(below > 0, below, 1.0)
