"""Contact of two triangles: decided in float64 where that is certain, in whole numbers elsewhere.

Arrays of corners have the shape (corner, coordinate, pair). `shared` corners (0, 1 or 2) stand
first in both triangles of a pair.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import Exact, signs, whole_numbers
from ..validation import Flags, Floats

_SAFETY = 128 * 2.0**-53
"""Bound on the rounding of a volume of three differences, over the cube of the largest.

Six products with at most five roundings each, of factors that carry three: 90 would do."""

_PLANE_SIDES = ((0, 1, 2), (0, 2), (0,))
"""Sides along which triangles with 0, 1, 2 shared corners can be parted within a plane."""


def certain_contact(first: Floats, second: Floats, shared: int) -> tuple[Flags, Flags]:
    """Masks of the pairs that certainly meet and of those undecided; others are certainly apart.

    To meet means to have a point in common that is not on a shared corner or side.

    Parameters
    ----------
    first, second : (3, 3, k) arrays
        Corners of the two triangles of every pair, shared ones first.
    shared : int
        Number of shared corners: 0, 1 or 2.

    Returns
    -------
    meets, is_open : (k,) arrays
    """
    count = first.shape[2]
    meets, is_open = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    origin = first[0]
    pair = np.concatenate([first - origin, second - origin])
    size = 2 * np.abs(pair).reshape(18, -1).max(axis=0)
    left = np.arange(count)

    for one, other in ((slice(0, 3), slice(3, 6)), (slice(3, 6), slice(0, 3))):
        apart = _is_beside_plane(pair[one], pair[other], shared, _SAFETY * size**3)
        left, pair, size = left[~apart], pair[..., ~apart], size[~apart]
    for one, other in ((slice(0, 3), slice(3, 6)), (slice(3, 6), slice(0, 3))):
        if not len(left):
            break
        apart = _is_beside_side(pair[one], pair[other], shared, 4 * _SAFETY * size**4)
        left, pair, size = left[~apart], pair[..., ~apart], size[~apart]

    if shared == 2 or not len(left):
        is_open[left] = True
        return meets, is_open
    hits, misses = _piercings(pair[:3], pair[3:], shared, size)
    meets[left] = hits
    is_open[left] = ~hits & ~misses
    return meets, is_open


def exact_contact(first: Floats, second: Floats, same: Flags | None = None) -> Flags:
    """Mask (k,) of the pairs that meet, in exact arithmetic.

    A triangle without area meets nothing. Triangles with three shared corners meet.

    Parameters
    ----------
    first, second : (3, 3, k) arrays
        Corners of the two triangles of every pair, in any order.
    same : (3, 3, k) array, optional
        Mask of equal corners of first and second triangles; these have the same coordinates.
        By default all corners with the same coordinates.
    """
    meets = np.zeros(first.shape[2], dtype=bool)
    if same is None:
        same = np.asarray(np.all(first[:, None] == second[None], axis=2), dtype=bool)
    in_first, in_second = np.asarray(same.any(axis=1)), np.asarray(same.any(axis=0))
    shared = in_first.sum(axis=0)
    whole = whole_numbers(np.concatenate([first, second]))
    first, second = _shared_first(whole[:3], in_first), _shared_first(whole[3:], in_second)
    has_area = _has_area(first) & _has_area(second)

    meets[has_area & (shared == 3)] = True
    for number in range(3):
        rows = np.flatnonzero(has_area & (shared == number))
        if len(rows):
            one, other = first[..., rows], second[..., rows]
            if number == 2:
                meets[rows] = _is_folded_flat(one, other)
            else:
                meets[rows] = _sides_meet(one, other, number) | _sides_meet(other, one, number)
    return meets


def _is_beside_plane(one: Floats, other: Floats, shared: int, margin: Floats) -> Flags:
    """Whether all free corners of the other triangle lie on one side of the plane of the first."""
    normal = _cross(one[1] - one[0], one[2] - one[0])
    heights = [_dot(normal, corner - one[0]) for corner in other[shared:]]
    lowest, highest = _extremes(heights)
    return (lowest > margin) | (highest < -margin)


def _is_beside_side(one: Floats, other: Floats, shared: int, margin: Floats) -> Flags:
    """Whether all free corners of the other triangle lie beyond a side of the first, along its
    normal.

    The first triangle itself lies on the inner side of each, by construction.
    """
    normal = _cross(one[1] - one[0], one[2] - one[0])
    apart = np.zeros(one.shape[2], dtype=bool)
    for side in _PLANE_SIDES[shared]:
        start, end = one[side], one[(side + 1) % 3]
        inward = _cross(normal, end - start)
        _, highest = _extremes([_dot(inward, corner - start) for corner in other[shared:]])
        apart |= highest < -margin
    return apart


def _piercings(one: Floats, other: Floats, shared: int, size: Floats) -> tuple[Flags, Flags]:
    """Whether a side of a pair certainly runs through the other triangle, and whether it cannot."""
    flat = _SAFETY * size**2
    has_area = np.ones(len(size), dtype=bool)
    hits, misses = ~has_area, has_area.copy()
    for triangle in (one, other):
        normal = _cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        has_area &= np.abs(normal).max(axis=0) > flat
    margin = _SAFETY * size**3
    for triangle, sides in ((one, other), (other, one)):
        for k in range(3) if shared == 0 else (1,):
            below, above, around = _side_volumes(sides[k], sides[(k + 1) % 3], triangle)
            lowest, highest = _extremes([below, above])
            inmost, outmost = _extremes(around)
            crosses = (lowest < -margin) & (highest > margin)
            hits |= crosses & ((inmost > margin) | (outmost < -margin))
            misses &= (
                (lowest > margin) | (highest < -margin) | ((inmost < -margin) & (outmost > margin))
            )
    return hits & has_area, misses


def _side_volumes(start: Exact, end: Exact, triangle: Exact) -> tuple[Exact, Exact, list[Exact]]:
    """Sixfold volumes: of the triangle with start and with end, and of start and end with every
    side."""
    normal = _cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    rays = [corner - start for corner in triangle]
    along = end - start
    around = [_dot(along, _cross(rays[k], rays[(k + 1) % 3])) for k in range(3)]
    return _dot(normal, start - triangle[0]), _dot(normal, end - triangle[0]), around


def _sides_meet(one: Exact, other: Exact, shared: int) -> Flags:
    """Whether a side of the first triangle has a point in common with the other, both closed."""
    meets = np.zeros(one.shape[2], dtype=bool)
    for k in range(3) if shared == 0 else (1,):
        start, end = one[k], one[(k + 1) % 3]
        below, above, around = _side_volumes(start, end, other)
        in_plane = (below == 0) & (above == 0)
        lowest, highest = _extremes(around)
        is_between = ((below <= 0) & (above >= 0)) | ((below >= 0) & (above <= 0))
        meets |= (is_between & ~in_plane & ((lowest >= 0) | (highest <= 0))).astype(bool)
        rows = np.flatnonzero(in_plane)
        if len(rows):
            meets[rows] |= _meets_in_plane(start[:, rows], end[:, rows], other[..., rows])
    return meets


def _meets_in_plane(start: Exact, end: Exact, triangle: Exact) -> Flags:
    """Whether a segment in the plane of the triangle has a point in common with it."""
    normal = _cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    # The projected triangle keeps an area along any axis where the normal is not zero.
    axis = np.argmax((normal != 0).astype(bool), axis=0)
    rows = np.arange(len(axis))
    flat = np.stack([np.stack([p[(axis + 1) % 3, rows], p[(axis + 2) % 3, rows]])
                     for p in (*triangle, start, end)])  # fmt: skip
    turn = [[signs(_turn(flat[k], flat[(k + 1) % 3], flat[e])) for k in range(3)] for e in (3, 4)]
    across = [signs(_turn(flat[3], flat[4], flat[k])) for k in range(3)]
    meets = np.zeros(len(rows), dtype=bool)
    for sides in turn:
        lowest, highest = _extremes(sides)
        meets |= (lowest >= 0) | (highest <= 0)
    for k in range(3):
        # A segment on the line of a side meets the side only with an end, which is seen above, or
        # covers it; then it meets a neighboring side too.
        meets |= (turn[0][k] * turn[1][k] <= 0) & (across[k] * across[(k + 1) % 3] < 0)
        meets |= (across[k] == 0) & _is_within(flat[3], flat[4], flat[k])
    return meets


def _is_within(start: Exact, end: Exact, point: Exact) -> Flags:
    """Whether a point on the line of a segment lies on the segment."""
    ahead = (point - start) * (end - start)
    back = (end - point) * (end - start)
    return ((ahead.sum(axis=0) >= 0) & (back.sum(axis=0) >= 0)).astype(bool)


def _is_folded_flat(one: Exact, other: Exact) -> Flags:
    """Whether triangles with one common side lie in one plane, on the same side of it."""
    normal = _cross(one[1] - one[0], one[2] - one[0])
    folded = _cross(one[1] - one[0], other[2] - one[0])
    in_plane = _dot(normal, other[2] - one[0]) == 0
    return (in_plane & (_dot(normal, folded) > 0)).astype(bool)


def _has_area(triangle: Exact) -> Flags:
    normal = _cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    return (normal != 0).astype(bool).any(axis=0)


def _shared_first(triangle: Exact, is_shared: Flags) -> Exact:
    """The corners, cyclically shifted so that the shared ones come first."""
    start = first_shared(is_shared)
    return np.stack([triangle[(start + k) % 3, :, np.arange(len(start))].T for k in range(3)])


def first_shared(is_shared: Flags) -> NDArray[np.int64]:
    """Corner (k,) from which on the shared ones follow each other; `is_shared` is (3, k)."""
    count = is_shared.sum(axis=0)
    return np.where(
        count == 1, np.argmax(is_shared, axis=0), (np.argmin(is_shared, axis=0) + 1) % 3
    )


def _extremes(values: list[Any]) -> tuple[Any, Any]:
    return np.minimum.reduce(values), np.maximum.reduce(values)


def _turn(first: Exact, second: Exact, third: Exact) -> Exact:
    one, other = second - first, third - first
    return one[0] * other[1] - one[1] * other[0]


def _dot(first: Exact, second: Exact) -> Exact:
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


def _cross(first: Exact, second: Exact) -> Exact:
    return np.stack(
        [
            first[1] * second[2] - first[2] * second[1],
            first[2] * second[0] - first[0] * second[2],
            first[0] * second[1] - first[1] * second[0],
        ]
    )
