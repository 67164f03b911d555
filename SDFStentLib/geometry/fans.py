"""Fans of faces that follow each other round a vertex across edges; a manifold vertex has one.

Side 3 f + k of face f starts at corner 3 f + k; arrays of sides may have 32 bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import Indices


def component_labels(count: int, start: Indices, end: Indices) -> Indices:
    """Number (count,) of the connected part of each node, in the order of the first node."""
    labels = connected(count, start, end)[1]
    _, first, number = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.reshape(-1)]


def connected(count: int, start: NDArray[Any], end: NDArray[Any]) -> tuple[int, Indices]:
    """Number of connected parts of so many nodes joined by edges, and the part of each node."""
    # Imported here: scipy costs half a second, which a first frame should not pay.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    # Floats, because SciPy copies a graph of anything else.
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(count, count)).tocsr()
    number, labels = connected_components(graph, directed=False)
    return int(number), labels


Sides = NDArray[Any]


def fans_by_walking(corners: Indices, first: Sides, second: Sides) -> int:
    """Number of fans in a surface that is edge manifold and consistently wound.

    Crossing the side that starts at a corner leads to the next corner of the same fan. Fans are
    the cycles and the ends of that walk, which is doubled until it is longer than any fan.
    """
    count = len(corners)
    own = np.arange(count, dtype=first.dtype)
    onward = own.copy()
    onward[first], onward[second] = following(second), following(first)
    is_end = onward == own
    lowest = np.minimum(own, onward)
    longest = int(np.bincount(corners).max())
    reach = 1
    # Ends: the reach doubles from 1.
    while reach < longest:
        np.minimum(lowest, lowest[onward], out=lowest)
        onward = onward[onward]
        reach *= 2
    is_closed_fan = ~is_end[onward]
    return int(np.count_nonzero(is_end) + np.count_nonzero(is_closed_fan & (lowest == own)))


def fans_by_graph(corners: Indices, side: Sides, other: Sides) -> int:
    """Number of fans in any surface: parts of the graph of corners."""
    # Side 3 f + k starts at corner 3 f + k and ends at the following corner of the same face;
    # two corners belong to one fan when they sit at the same end of a shared edge.
    same_way = corners[side] == corners[other]
    return connected(
        len(corners),
        np.r_[side, following(side)],
        np.r_[
            np.where(same_way, other, following(other)),
            np.where(same_way, following(other), other),
        ],
    )[0]


def following(side: Sides) -> Sides:
    """Side after each one (k,) in its face; it starts at the corner where that one ends."""
    # NumPy divides by a number several times quicker than it takes the remainder.
    first = side // 3 * 3
    return np.where(side - first == 2, first, side + 1)
