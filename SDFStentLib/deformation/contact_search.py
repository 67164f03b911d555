"""Search for the nearest of the points that are in contact with the stent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..geometry import dot, search_tree
from ..validation import Points

FEW = 32
"""Number of points up to which comparing with all of them is faster than a search tree."""

PAIRS = 1 << 16
"""Pairs compared at once."""


class ContactSearch:
    """Finds the nearest of some points by comparison or by tree, whichever is faster.

    Parameters
    ----------
    points : (m, 3) array
        Points in contact, mm; at least one.
    is_exact : bool
        Whether to use the tree always: comparison by expanded squares loses half of the digits of
        short distances.
    """

    def __init__(self, points: Points, *, is_exact: bool = False) -> None:
        self._points = points
        self._tree = search_tree(points) if len(points) > FEW or is_exact else None

    def nearest(
        self, points: Points, bound: float
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Distance to the nearest point, mm, and its number; beyond the bound neither is exact.

        Runs in the caller's thread: two workers gained nothing up to 1.2 million triangles. Beyond
        the bound the distance is either the true or an infinite one.
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
    """Squared distances (k, m) to all others, part by part; rounding may make them negative."""
    center = others.mean(axis=0)
    local = others - center
    factors, squares = -2 * local.T, dot(local, local)
    rows = max(1, PAIRS // len(others))
    for start in range(0, len(points), rows):
        part = slice(start, start + rows)
        local = points[part] - center
        pairs = local @ factors
        pairs += squares
        pairs += dot(local, local)[:, None]
        yield part, pairs
