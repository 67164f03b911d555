"""The part of a wall that a treatment has moved: beyond its reach the lumen is as it was."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Surface, dot, faces_at, norm, product, search_tree
from ..validation import Flags, Floats, Points, Triangles

_APART = 1 / np.sqrt(3.0)
"""No place of a triangle is farther from all of its corners than so many of its longest side."""

_BLOCK = 1 << 21
"""Pairs of plane and corner that are looked at together, some bytes each."""


class MovedWall(NamedTuple):
    """Triangles of which a corner has moved: where they were, and where they are."""

    places: Points
    """(k, 3) their corners before and after, mm."""
    apart: float
    """No place of them is farther from all corners, mm."""

    def within(self, points: Points, reach: float) -> MovedWall:
        """What of it lies in the box that goes `reach` mm beyond some points (n, 3)."""
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        columns = zip(self.places.T, low, high, strict=True)
        kept = np.logical_and.reduce([(x >= first) & (x <= last) for x, first, last in columns])
        return MovedWall(self.places.compress(kept, axis=0), self.apart)

    def comes_near(self, centers: Points, radii: Floats) -> Flags:
        """Which balls (n,) it may reach; one whose radius is not known in any case."""
        is_near = np.isnan(radii)
        if len(self.places):
            tree = search_tree(self.places)
            reach = radii + self.apart
            columns = zip(centers.T, self.places.T, strict=True)
            beside = [(x + reach >= y.min()) & (x - reach <= y.max()) for x, y in columns]
            known = np.flatnonzero(np.logical_and.reduce(beside))
            is_near[known] = tree.query(centers[known])[0] <= reach[known]
        return is_near

    def crosses(self, points: Points, normals: Points) -> Flags:
        """Which planes (n,) through some points with normals (n, 3) it may cut."""
        found = np.zeros(len(points), dtype=bool)
        block = max(1, _BLOCK // max(1, len(self.places)))
        for first in range(0, len(points) if len(self.places) else 0, block):
            rows = slice(first, first + block)
            heights = product(normals[rows], self.places.T)
            origin = dot(normals[rows], points[rows])
            found[rows] = (heights.min(axis=1) <= origin) & (heights.max(axis=1) >= origin)
        return found


def moved_wall(before: Surface, after: Surface) -> MovedWall:
    """What has moved between two states of a surface, which have the same triangles."""
    # By column: reductions over rows of three are slow.
    columns = zip(before.points.T, after.points.T, strict=True)
    is_moved = np.logical_or.reduce([one != other for one, other in columns])
    has_moved = faces_at(is_moved, before.corners.T)
    triangles = before.triangles.compress(has_moved, axis=0)
    is_corner = np.zeros(len(is_moved), dtype=bool)
    is_corner[triangles] = True
    points = before.points, after.points
    apart = _APART * max(_longest_side(state, triangles) for state in points)
    return MovedWall(np.concatenate([state.compress(is_corner, axis=0) for state in points]), apart)


def _longest_side(points: Points, triangles: Triangles) -> float:
    corners = [points.take(column, axis=0) for column in triangles.T]
    return max(float(norm(corners[k] - corners[k - 1]).max(initial=0.0)) for k in range(3))
