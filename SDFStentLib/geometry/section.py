"""Cutting a surface with a plane, and telling what lies inside a closed one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import (
    Flags,
    Floats,
    Indices,
    InputError,
    Points,
    Triangles,
    as_point,
)
from .rows import blocks_of, dot, product, ranges

_BLOCK = 1 << 19
"""Pairs of query and triangle that are looked at together; some 50 MB of temporaries."""

_REPEAT = 1e-9
"""Corners of a section nearer to each other than this, mm, are one corner."""


class SectionLoop(NamedTuple):
    """One connected piece of a plane section.

    Attributes
    ----------
    points : (k, 3) array
        Corners in order, mm, without repeats; the first is not repeated at the end of a loop.
    is_closed : bool
        False for the cut through an open rim.
    """

    points: Points
    is_closed: bool


class Crossings(NamedTuple):
    """Where a plane crosses a surface; a point in the plane counts as above it."""

    triangles: Indices
    """(k,) those that are crossed."""
    sides: Indices
    """(c, 2) the ends below and above of every side that is crossed,"""
    corners: Points
    """(c, 3) and where."""
    nodes: Indices
    """(k, 2) for each of the triangles the crossed side that goes down and the one that goes up."""


def plane_section(
    points: Points, triangles: Triangles, origin: ArrayLike, normal: ArrayLike
) -> list[SectionLoop]:
    """Cut of a surface with a plane, as polylines.

    A point exactly in the plane counts as above it, so every cut triangle gives exactly one
    segment and a closed surface only closed loops, also when the plane runs through vertices or
    along edges. On an outward oriented surface loops run counterclockwise about `normal` round
    the lumen, clockwise round holes. Pieces that shrink to a point are left out.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Known to be sound.
    origin : array_like, shape (3,)
        A point of the plane, mm.
    normal : array_like, shape (3,)
        Normal of the plane, any length but zero.

    Raises
    ------
    InputError
        No point, or a zero normal.
    """
    origin, normal = as_point(origin, "origin"), as_point(normal, "normal")
    if not np.any(normal):
        raise InputError("normal: expected a direction, got the zero vector; give a plane normal.")
    crossed = crossings(points, triangles, origin, normal / np.linalg.norm(normal))
    chains = _chains(crossed.nodes, len(crossed.corners))
    loops = (_without_repeats(crossed.corners[chain], is_loop) for chain, is_loop in chains)
    return [loop for loop in loops if len(loop.points) > 1]


def crossings(points: Points, triangles: Triangles, origin: Points, normal: Points) -> Crossings:
    """Which triangles a plane crosses, and where; its normal is a unit vector."""
    heights = product(points - origin, normal)
    is_above = heights >= 0

    # Column by column: reductions over rows of three are slow.
    first, second, third = (is_above.take(corner) for corner in triangles.T)
    cut = np.flatnonzero((first != second) | (second != third))
    start, end = triangles[cut], triangles[cut][:, [1, 2, 0]]
    # Each cut triangle has one side that goes down through the plane and one that goes up.
    down = np.argmax(is_above[start] & ~is_above[end], axis=1)
    up = np.argmax(~is_above[start] & is_above[end], axis=1)
    rows = np.arange(len(cut))
    sides = np.r_[
        np.stack([end[rows, down], start[rows, down]], axis=1),
        np.stack([start[rows, up], end[rows, up]], axis=1),
    ]
    crossed, node = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    below, above_ends = np.divmod(crossed, len(points))
    fraction = heights[below] / (heights[below] - heights[above_ends])
    corners = points[below] + fraction[:, None] * (points[above_ends] - points[below])
    corners[fraction == 1.0] = points[above_ends[fraction == 1.0]]
    return Crossings(cut, np.column_stack([below, above_ends]), corners, node.reshape(2, -1).T)


class Inside:
    """What lies inside of a closed surface, see `Surface.contains`."""

    def __init__(self, points: Points, triangles: Triangles) -> None:
        self._points, self._triangles = points, triangles
        self._lowest, self._highest = _extents(points[:, 0], triangles)

    def contains(self, queries: Points) -> Flags:
        """Whether each query (k, 3) lies inside: its ray upward meets the surface an odd time.

        Whether a face is met is decided by edge in one fixed order, so that a ray through an edge
        or a vertex is counted once and not twice. A query exactly on the surface may come out
        either way.
        """
        result = np.zeros(len(queries), dtype=bool)
        if not len(queries):
            return result
        order = np.argsort(queries[:, 0], kind="stable")
        ordered = queries[order]
        is_met = (self._lowest <= ordered[-1, 0]) & (self._highest >= ordered[0, 0])
        triangles = self._triangles.compress(is_met, axis=0)
        first = np.searchsorted(ordered[:, 0], self._lowest[is_met], side="left")
        counts = np.searchsorted(ordered[:, 0], self._highest[is_met], side="right") - first
        lowest, highest = _extents(self._points[:, 1], triangles)
        crossings = np.zeros(len(queries), dtype=np.int64)
        for faces in blocks_of(counts, _BLOCK):
            face = np.repeat(faces, counts[faces])
            query = ranges(first[faces], counts[faces])
            y = ordered[:, 1].take(query)
            # Most faces lie beside the ray.
            met = np.flatnonzero((lowest.take(face) <= y) & (y <= highest.take(face)))
            face, query = face.take(met), query.take(met)
            hit = _is_crossed_upward(
                ordered.take(query, axis=0), self._points, triangles.take(face, axis=0)
            )
            crossings += np.bincount(query[hit], minlength=len(queries))
        result[order] = crossings % 2 == 1
        return result


def _chains(segments: NDArray[np.int64], count: int) -> Iterator[tuple[list[int], bool]]:
    """Node lists of connected segments: open chains first, then loops."""
    at_node: list[list[int]] = [[] for _ in range(count)]
    for number, (start, end) in enumerate(segments.tolist()):
        at_node[start].append(number)
        at_node[end].append(number)
    used = [False] * len(segments)
    nodes = segments.tolist()
    is_end = np.array([len(at_node[start]) == 1 for start, _ in nodes], dtype=bool)
    is_last = np.array([len(at_node[end]) == 1 for _, end in nodes], dtype=bool)
    for first in np.r_[
        np.flatnonzero(is_end), np.flatnonzero(is_last & ~is_end), np.arange(len(segments))
    ].tolist():
        if used[first]:
            continue
        backward = not is_end[first] and bool(is_last[first])
        chain = [nodes[first][1] if backward else nodes[first][0]]
        following: int | None = first
        # Ends: every segment is used once.
        while following is not None:
            used[following] = True
            start, end = nodes[following]
            chain.append(end if chain[-1] == start else start)
            following = next((s for s in at_node[chain[-1]] if not used[s]), None)
        is_loop = chain[0] == chain[-1]
        yield (chain[:-1] if is_loop else chain), is_loop


def _without_repeats(corners: Points, is_loop: bool) -> SectionLoop:
    previous = np.roll(corners, 1, axis=0)
    is_new = np.any(np.abs(corners - previous) > _REPEAT, axis=1)
    if not is_loop:
        is_new[0] = True
    return SectionLoop(corners[is_new], is_loop)


def _extents(values: Floats, triangles: Triangles) -> tuple[Floats, Floats]:
    """Lowest and highest (m,) of the values of every triangle's corners."""
    # Column by column: reductions over rows of three are slow.
    first, second, third = (values.take(corner) for corner in triangles.T)
    return (
        np.minimum(np.minimum(first, second), third),
        np.maximum(np.maximum(first, second), third),
    )


def _is_crossed_upward(queries: Floats, points: Points, triangles: Triangles) -> Flags:
    """Whether the ray from each query towards +z meets the triangle in the same row."""
    x, y = queries[:, 0], queries[:, 1]
    odd = np.zeros(len(queries), dtype=bool)
    for start, end in ((0, 1), (1, 2), (2, 0)):
        ends = np.sort(triangles[:, [start, end]], axis=1)
        low, high = points[ends[:, 0]], points[ends[:, 1]]
        spans = (low[:, 1] > y) != (high[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (high[:, 0] - low[:, 0]) / (high[:, 1] - low[:, 1])
            odd ^= spans & (x < low[:, 0] + (y - low[:, 1]) * slope)
    first, second, third = points[triangles.T]
    normals = np.cross(second - first, third - first)
    rise = dot(normals, first - queries)
    return odd & (rise * normals[:, 2] > 0)
