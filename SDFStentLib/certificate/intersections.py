"""Triangles of a surface that cross, touch or cover one another where they are not joined.

Two triangles intersect when they have a point in common that does not lie on a corner or a side
which both have. So crossing, a corner or side that touches another face, coplanar overlap, a
neighbor folded flat onto its neighbor and a doubled triangle all count, and so does a vertex
that lies exactly on a vertex of another wall. The two banks of a seam are neighbors, not
intersections: corners are the same, whatever their numbers, where the surface goes on across a
seam (`Seams`). Triangles without area are left out (`certificate.py` counts them by
themselves). The decision is exact for the coordinates as they are stored.

The way there: boxes that overlap (`triangle_pairs.py`); pairs inside a fan that is spread out flat
are cleared together; the rest is decided pair by pair (`triangle_contact.py`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import boundary_edges, compacted, connected, in_blocks, may_meet_box, used_points
from ..validation import Flags, Floats, Indices, InputError, Points, Triangles
from .triangle_contact import certain_contact, exact_contact, first_shared
from .triangle_pairs import face_boxes, overlapping_pairs


class Seams:
    """The points of the two banks of a seam, which are one and the same.

    A seam is where free edges of the surface lie exactly on one another. Points at the same place
    that no seam joins are different points: there walls touch.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        The whole surface.
    near : (k,) array
        The triangles that are examined; from here on their points are numbered in order.
    """

    def __init__(self, points: Points, triangles: Triangles, near: Indices) -> None:
        self._points, self._triangles, self._near = points, triangles, near

    def same_corners(self, first: Indices, second: Indices, one: Floats, other: Floats) -> Flags:
        """Mask (3, 3, k) of the corners that are the same in pairs of triangles.

        Parameters
        ----------
        first, second : (3, k) arrays
            Numbers of the corners.
        one, other : (3, 3, k) arrays
            Coordinates of the corners: corner, coordinate, pair.
        """
        same = first[:, None] == second[None]
        equal = np.all(one[:, None] == other[None], axis=2)
        if (equal & ~same).any():
            same = self._joined[first][:, None] == self._joined[second][None]
        return np.asarray(same)

    @cached_property
    def _joined(self) -> Indices:
        """A number for every point of the near triangles, the same for points that are one."""
        used = used_points(self._triangles[self._near])
        return _joined_points(self._points, self._triangles)[used]


def _joined_points(points: Points, triangles: Triangles) -> Indices:
    """A number (n,) for every point, the same for points that seams join."""
    free = boundary_edges(triangles)
    free = free[free[:, 0] != free[:, 1]]
    at_rim, ends = np.unique(free, return_inverse=True)
    # Zero has two signs, which are the same place.
    place = np.unique(points[at_rim] + 0.0, axis=0, return_inverse=True)[1].ravel()
    ends = ends.reshape(-1, 2)
    # Sorted by the places of their ends, edges that lie on one another follow each other.
    turned = place[ends[:, 0]] > place[ends[:, 1]]
    ends[turned] = ends[turned][:, ::-1]
    low, high = place[ends].T
    order = np.lexsort((high, low))
    ends, low, high = ends[order], low[order], high[order]
    follows = np.flatnonzero((low[1:] == low[:-1]) & (high[1:] == high[:-1]))
    pairs = np.stack([ends[follows], ends[follows + 1]], axis=2).reshape(-1, 2)
    return connected(len(points), at_rim[pairs[:, 0]], at_rim[pairs[:, 1]])[1]


_BLOCK = 1 << 15
"""Number of pairs decided at once: their corners fit into the cache of one core."""

_FLAT = 16 * 2.0**-53
"""Bound on the rounding of a plane triangle's area, over the square of its longest difference."""


def self_intersecting_triangles(
    points: Points, triangles: Triangles, among: ArrayLike | None = None
) -> Indices:
    """Triangles that intersect another triangle of the surface, in ascending order.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Known to be sound, in the numbers that are stored, on which the decision is made.
    among : array_like, optional
        Indices, or a mask (m,), of the triangles that moved: only pairs with at least one of them
        are examined. By default all.

    Raises
    ------
    InputError
        `among` does not name triangles.
    """
    return np.unique(intersecting_pairs(points, triangles, among))


def intersecting_pairs(
    points: Points, triangles: Triangles, among: ArrayLike | None = None
) -> Indices:
    """Pairs (k, 2) of triangles that intersect; parameters as in `self_intersecting_triangles`.

    The lower index stands first; pairs are in ascending order.
    """
    is_moved = _as_mask(among, len(triangles))
    found = [np.empty((0, 2), dtype=np.int64)]
    if is_moved.any():
        near = _near(points, triangles, is_moved)
        seams = Seams(points, triangles, near)
        points, triangles = compacted(points, triangles.take(near, axis=0))
        boxes = face_boxes(points, triangles, is_moved[near])
        near = near[boxes.faces]
        corners = np.ascontiguousarray(triangles[boxes.faces].T)
        columns = np.ascontiguousarray(points.T)
        is_clear = _is_in_flat_fans(columns, corners)
        for one, other in overlapping_pairs(boxes):
            for shared, first, second, rows in _by_shared_corners(corners, is_clear, one, other):
                meets = _decided(columns, shared, first, second, seams)
                pair = np.stack([one[rows[meets]], other[rows[meets]]], axis=1)
                found.append(np.sort(near[pair], axis=1))
    pairs = np.concatenate(found)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _as_mask(among: ArrayLike | None, count: int) -> Flags:
    if among is None:
        return np.ones(count, dtype=bool)
    chosen = np.asarray(among)
    if chosen.dtype == bool and chosen.shape == (count,):
        return chosen
    mask = np.zeros(count, dtype=bool)
    if chosen.size == 0:
        return mask
    if chosen.ndim != 1 or chosen.dtype.kind not in "iu":
        raise InputError(
            f"among: expected indices or a mask of {count} triangles, got {chosen.dtype} "
            f"{chosen.shape}."
        )
    if chosen.min() < 0 or chosen.max() >= count:
        raise InputError(
            f"among: expected triangle indices from 0 to {count - 1}, got {chosen.min()} to "
            f"{chosen.max()}."
        )
    mask[chosen] = True
    return mask


def _near(points: Points, triangles: Triangles, is_moved: Flags) -> Indices:
    """Faces whose boxes reach into the box around all moved faces."""
    if is_moved.all():
        return np.arange(len(triangles))
    moved = np.zeros(len(points), dtype=bool)
    moved[triangles.compress(is_moved, axis=0)] = True
    ends = points.compress(moved, axis=0)
    return np.flatnonzero(may_meet_box(points, triangles, ends.min(axis=0), ends.max(axis=0)))


def _is_in_flat_fans(columns: NDArray[np.float64], corners: Indices) -> Flags:
    """Whether each face (b,) cannot intersect any face with which it shares a corner.

    Seen along one coordinate axis, all faces round a vertex turn the same way, form one closed
    ring and go round once: then they lie side by side. A face is clear when this holds at all
    its corners, with all faces there among those given.
    """
    found = in_blocks(lambda block: _axis_areas(columns, block.T), corners.T)
    normals, certainty = found[:3], found[3]
    count = columns.shape[1]
    at = corners.ravel()

    sums = np.stack([np.bincount(at, np.tile(n, 3), minlength=count) for n in normals])
    axis = np.argmax(np.abs(sums), axis=0)
    sign = np.where(np.take_along_axis(sums, axis[None], axis=0)[0] > 0, 1.0, -1.0)

    faces = np.arange(corners.shape[1])
    after, before = corners[[1, 2, 0]].ravel(), corners[[2, 0, 1]].ravel()
    here = axis.take(at)
    turned = normals.ravel().take(here * len(faces) + np.tile(faces, 3)) * sign.take(at)
    turned = turned <= np.tile(certainty, 3)
    flat, row = columns.ravel(), (here + 2) % 3 * count
    height = flat.take(row + at)
    rises = (flat.take(row + after) < height) & (flat.take(row + before) >= height)
    # First and second power sums of the numbers met going round, entering minus leaving, vanish
    # on closed rings, and not with one or two open fans. Three open fans at one vertex, which no
    # manifold has, could pass for a ring only by an accident of their numbering.
    gap = (after - before).astype(np.float64)
    is_flat = np.bincount(at, turned, minlength=count) == 0
    is_flat &= np.bincount(at, rises, minlength=count) == 1
    is_flat &= np.bincount(at, gap, minlength=count) == 0
    is_flat &= np.bincount(at, gap * (after + before), minlength=count) == 0
    first, second, third = (is_flat.take(corner) for corner in corners)
    return np.asarray(first & second & third)


def _axis_areas(columns: NDArray[np.float64], corners: Indices) -> NDArray[np.float64]:
    """Twice the areas (b,) seen along each axis, and a bound on their rounding, in rows (4, b)."""
    first, second, third = (columns.take(corner, axis=1) for corner in corners)
    one, other = second - first, third - first
    areas = [
        one[(k + 1) % 3] * other[(k + 2) % 3] - one[(k + 2) % 3] * other[(k + 1) % 3]
        for k in range(3)
    ]
    size = np.maximum(np.abs(one).max(axis=0), np.abs(other).max(axis=0))
    return np.stack([*areas, _FLAT * size**2])


def _by_shared_corners(
    corners: Indices, is_clear: Flags, one: Indices, other: Indices
) -> Iterator[tuple[int, Indices, Indices, Indices]]:
    """The undecided pairs by their number of shared corners.

    Yields (number, corners of the one (3, k), corners of the other (3, k), rows), shared corners
    first.
    """
    for start in range(0, len(one), _BLOCK):
        left, right = one[start : start + _BLOCK], other[start : start + _BLOCK]
        first, second = corners.take(left, axis=1), corners.take(right, axis=1)
        shared = np.zeros(len(left), dtype=np.uint8)
        for corner in first:
            for opposite in second:
                shared += corner == opposite
        is_open = (shared == 0) | ~(is_clear.take(left) | is_clear.take(right))
        for number in range(4):
            chosen = np.flatnonzero(is_open & (shared == number))
            if not len(chosen):
                continue
            some, others = first.take(chosen, axis=1), second.take(chosen, axis=1)
            if number in (1, 2):
                equal = some[:, None] == others[None]
                some = _turned(some, first_shared(equal.any(axis=1)))
                others = _turned(others, first_shared(equal.any(axis=0)))
            yield number, some, others, start + chosen


def _turned(corners: Indices, start: Indices) -> Indices:
    return np.take_along_axis(corners, (start + np.arange(3)[:, None]) % 3, axis=0)


def _decided(
    columns: NDArray[np.float64], shared: int, first: Indices, second: Indices, seams: Seams
) -> Flags:
    one = columns.take(first, axis=1).swapaxes(0, 1)
    other = columns.take(second, axis=1).swapaxes(0, 1)
    meets, is_open = np.zeros(one.shape[2], dtype=bool), np.ones(one.shape[2], dtype=bool)
    if shared < 3:
        meets, is_open = certain_contact(one, other, shared)
    if is_open.any():
        one, other = one[..., is_open], other[..., is_open]
        same = seams.same_corners(first[:, is_open], second[:, is_open], one, other)
        meets[is_open] = exact_contact(one, other, same)
    return meets
