"""The nearest of the points that are in contact with the stent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..geometry import dot, search_tree
from ..validation import Points

FEW = 32
"""Points up to which comparing with every one is faster than a search tree."""

PAIRS = 1 << 16
"""Pairs compared at once."""


class ContactSearch:
    """Answers which of some points is nearest; by comparison or by tree, as is faster.

    Parameters
    ----------
    points : (m, 3) array
        Points in contact, mm; at least one.
    is_exact : bool
        Never compare by squares, whose rounding costs half of the digits of short distances.
    """

    def __init__(self, points: Points, *, is_exact: bool = False) -> None:
        self._points = points
        self._tree = search_tree(points) if len(points) > FEW or is_exact else None

    def nearest(
        self, points: Points, bound: float
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Distance to the nearest, mm, and its number; whatever lies beyond the bound is far.

        In the caller's thread: two workers gained nothing up to 1.2 million triangles. What is
        beyond the bound comes with its distance or with an infinite one.
        """
        if self._tree is not None:
            distance, number = self._tree.query(points, distance_upper_bound=bound)
            return distance, number
        distance = np.empty(len(points))
        number = np.empty(len(points), dtype=np.int64)
        for part, pairs in squared_distances(points, self._points):
            number[part] = nearest = pairs.argmin(axis=1)
            distance[part] = pairs[np.arange(len(nearest)), nearest]
        return np.sqrt(np.maximum(distance, 0, out=distance), out=distance), number


def squared_distances(
    points: Points, others: Points
) -> Iterator[tuple[slice, NDArray[np.float64]]]:
    """Squares (k, m) of the distances to all others, part by part; by rounding below zero."""
    centre = others.mean(axis=0)
    local = others - centre
    factors, squares = -2 * local.T, dot(local, local)
    rows = max(1, PAIRS // len(others))
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        local = points[part] - centre
        pairs = local @ factors
        pairs += squares
        pairs += dot(local, local)[:, None]
        yield part, pairs
