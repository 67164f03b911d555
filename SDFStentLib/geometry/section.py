"""Cutting a surface with a plane."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import (
    Indices,
    InputError,
    Points,
    Triangles,
    as_point,
)
from .rows import product

_REPEAT = 1e-9
"""Distance, mm, up to which two corners of a section count as one."""


class SectionLoop(NamedTuple):
    """A connected piece of a plane section.

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
    """Crossings of a surface with a plane; a point in the plane counts as above it."""

    triangles: Indices
    """(k,) triangles that the plane crosses."""
    sides: Indices
    """(c, 2) ends below and above the plane of every side that it crosses."""
    corners: Points
    """(c, 3) places where the plane crosses these sides, mm."""
    nodes: Indices
    """(k, 2) crossed side of each triangle that goes down, and the one that goes up."""


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
    """Triangles that a plane crosses, and where it does; `normal` is a unit vector."""
    heights = product(points - origin, normal)
    is_above = heights >= 0

    # Column by column: reductions over rows of three are slow.
    first, second, third = is_above.take(triangles).T
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


def _chains(segments: NDArray[np.int64], count: int) -> Iterator[tuple[list[int], bool]]:
    """Node lists of connected segments, each with whether it is a loop: open chains first."""
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
