"""Triangles over a flat polygon, about as large as its sides."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Triangles
from .line import distances_to_segments

CLEAR = 0.6
"""Distance of inner points from the border, in mean side lengths, at least."""

FLAT = 1e-9
"""Area, in squares of a side length, below which a triangle is left out."""


class FlatFill(NamedTuple):
    """Triangles over a polygon."""

    inner: Floats
    """(j, 2) points inside."""
    triangles: Triangles
    """(m, 3) counterclockwise; corners are those of the polygon, then the points inside."""


def flat_fill(polygon: Floats) -> FlatFill | None:
    """Fill a polygon with triangles of which no side crosses its border.

    Parameters
    ----------
    polygon : (k, 2) array
        Corners, counterclockwise, mm; the first is not repeated.

    Returns
    -------
    FlatFill or None
        None for a polygon that cannot be filled: one that turns clockwise, for example.
    """
    inner = _inner_points(polygon)
    for points in (inner, inner[:0]):
        triangles = _delaunay(polygon, points)
        if triangles is not None:
            return FlatFill(points, triangles)
    ears = _ears(polygon)
    return None if ears is None else FlatFill(inner[:0], ears)


def _inner_points(polygon: Floats) -> Floats:
    """Points of a grid of equilateral triangles that lie well inside."""
    following = np.roll(polygon, -1, axis=0)
    side = float(np.linalg.norm(following - polygon, axis=1).mean())
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    rows = np.arange(low[1], high[1], side * np.sqrt(3) / 2)
    columns = np.arange(low[0], high[0] + side, side)
    grid = np.stack(np.meshgrid(columns, rows), axis=-1)
    grid[1::2, :, 0] -= side / 2
    points = grid.reshape(-1, 2)
    points = points[_contains(polygon, points)]
    squared, _ = distances_to_segments(points[:, None], polygon, following)
    return points[squared.min(axis=1, initial=np.inf) > (CLEAR * side) ** 2]


def _contains(polygon: Floats, points: Floats) -> Flags:
    """Whether points (k, 2) lie inside: a ray from each crosses the border an odd time."""
    (x, y), (end_x, end_y) = polygon.T, np.roll(polygon, -1, axis=0).T
    at_x, at_y = points[:, :1], points[:, 1:]
    spans = (y > at_y) != (end_y > at_y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x + (at_y - y) * (end_x - x) / (end_y - y)
    return (spans & (at_x < crossing)).sum(axis=1) % 2 == 1


def _delaunay(polygon: Floats, inner: Floats) -> Triangles | None:
    """Delaunay triangles inside; None where a side of the polygon is not among their sides."""
    from scipy.spatial import Delaunay

    points = np.vstack([polygon, inner])
    triangles = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    areas = _areas(points, triangles)
    triangles[areas < 0] = triangles[areas < 0][:, ::-1]
    side = float(np.abs(np.roll(polygon, -1, axis=0) - polygon).max())
    is_kept = (np.abs(areas) > FLAT * side**2) & _contains(polygon, points[triangles].mean(axis=1))
    triangles = triangles[is_kept]
    return triangles if _is_bounded_by(triangles, len(polygon)) else None


def _is_bounded_by(triangles: Triangles, count: int) -> bool:
    """Whether the border of the triangles is the polygon of the first points, side for side."""
    ends = np.roll(triangles, -1, axis=1)
    sides = set(zip(triangles.ravel().tolist(), ends.ravel().tolist(), strict=True))
    border = {(a, b) for a, b in sides if (b, a) not in sides}
    return border == {(index, (index + 1) % count) for index in range(count)}


def _ears(polygon: Floats) -> Triangles | None:
    """Triangles from cutting off corner after corner, the best shaped first; None where none is
    left."""
    left = list(range(len(polygon)))
    found = []
    # Ends: a corner is cut off each time, or there is none and it returns.
    while len(left) > 3:
        rows = np.column_stack([np.roll(left, 1), left, np.roll(left, -1)])
        shape = _areas(polygon, rows) / np.linalg.norm(
            polygon[rows[:, 0]] - polygon[rows[:, 2]], axis=1
        )
        ear = next(
            (
                int(i)
                for i in np.argsort(-shape)
                if shape[i] > 0 and _is_ear(polygon, rows[i], left)
            ),
            None,
        )
        if ear is None:
            return None
        found.append(rows[ear])
        del left[ear]
    found.append(np.array(left))
    return np.array(found)


def _is_ear(polygon: Floats, row: Triangles, left: list[int]) -> bool:
    others = polygon[[index for index in left if index not in row]]
    inside = np.ones(len(others), dtype=bool)
    for start, end in zip(polygon[row], polygon[np.roll(row, -1)], strict=True):
        (along_x, along_y), (x, y) = end - start, (others - start).T
        inside &= along_x * y - along_y * x >= 0
    return not inside.any()


def _areas(points: Floats, triangles: Triangles) -> Floats:
    """Signed areas, positive where the triangles turn counterclockwise."""
    first, second, third = points[triangles.T]
    (ax, ay), (bx, by) = (second - first).T, (third - first).T
    return np.asarray(ax * by - ay * bx) / 2
