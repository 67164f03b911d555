"""Where a surface goes on across a seam, whose two banks have points of their own."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..geometry import boundary_edges, connected
from ..validation import Flags, Floats, Indices, Points, Triangles


class Seams:
    """Points that are one and the same: those of the two banks of a seam.

    A seam is where free edges of the surface lie exactly on one another. Points at the same place
    that no seam joins are two: there walls touch.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        The whole surface.
    near : (k,) array
        The triangles that are looked at; their points are numbered in order from here on.
    """

    def __init__(self, points: Points, triangles: Triangles, near: Indices) -> None:
        self._points, self._triangles, self._near = points, triangles, near

    def same_corners(self, first: Indices, second: Indices, one: Floats, other: Floats) -> Flags:
        """Which corners (3, 3, k) of pairs of triangles are the same.

        Parameters
        ----------
        first, second : (3, k) arrays
            The corners' numbers.
        one, other : (3, 3, k) arrays
            Their coordinates: corner, coordinate, pair.
        """
        same = first[:, None] == second[None]
        equal = np.all(one[:, None] == other[None], axis=2)
        if (equal & ~same).any():
            same = self._joined[first][:, None] == self._joined[second][None]
        return np.asarray(same)

    @cached_property
    def _joined(self) -> Indices:
        """For every point of the near triangles a number, the same for those that are one."""
        used = np.unique(self._triangles[self._near])
        return _joined_points(self._points, self._triangles)[used]


def _joined_points(points: Points, triangles: Triangles) -> Indices:
    """A number (n,) for every point; points that seams join have the same."""
    free = boundary_edges(triangles)
    free = free[free[:, 0] != free[:, 1]]
    at_rim, ends = np.unique(free, return_inverse=True)
    # Zero has two signs, which are the same place.
    place = np.unique(points[at_rim] + 0.0, axis=0, return_inverse=True)[1].ravel()
    ends = ends.reshape(-1, 2)
    # Edges on one another: sorted by the places of their ends, they follow each other.
    turned = place[ends[:, 0]] > place[ends[:, 1]]
    ends[turned] = ends[turned][:, ::-1]
    low, high = place[ends].T
    order = np.lexsort((high, low))
    ends, low, high = ends[order], low[order], high[order]
    follows = np.flatnonzero((low[1:] == low[:-1]) & (high[1:] == high[:-1]))
    pairs = np.stack([ends[follows], ends[follows + 1]], axis=2).reshape(-1, 2)
    return connected(len(points), at_rim[pairs[:, 0]], at_rim[pairs[:, 1]])[1]
