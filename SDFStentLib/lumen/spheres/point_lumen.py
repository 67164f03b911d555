"""The lumen among points that stand for a wall: rough, and fast enough for every preview."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...geometry import Line, across, dot, norm
from ...validation import Flags, Floats, InputError, Points, as_points
from .max_min_step import LinearRows, largest_steps

NEAREST = 64
"""Points of the wall, nearest to a center, that a step looks at."""

ROUNDS = 10
"""Steps of a climb; in the last ones radii grow by less than a hundredth of themselves."""

BOX, SMALLER = 0.35, 0.75
"""Half width of the box of the first step over the present radius, and its share in the next."""

CAP = 0.9
"""Cosine to the axis above which the normal of a wall is that of a cap across it."""


def rough_radii(points: ArrayLike, centers: ArrayLike, normals: ArrayLike) -> Floats:
    """Radius (n,) of about the largest sphere near each point of an axis that holds no point.

    As `inscribed_spheres`, whose triangles are left out: centers are free in the plane across the
    axis and climb from it. So radii are too large, on a wall of radius r by about h^2 / (8 r) where
    its points are h apart.

    Parameters
    ----------
    points : array_like, shape (k, 3)
        Points of the wall, mm.
    centers : array_like, shape (n, 3)
        Points of the axis, mm, n at least 2.
    normals : array_like, shape (k, 3)
        Unit normals of the wall: what looks along the axis is a cap and counts as open.

    Raises
    ------
    InputError
        No points, or an axis of one point.
    """
    wall, starts = as_points(points, "points of the wall", minimum=1), as_points(centers, "centers")
    if len(starts) < 2:
        raise InputError(f"centers: expected at least 2 points, got {len(starts)}.")
    along = Line(starts).directions
    is_cap = np.abs(along @ as_points(normals, "normals").T) > CAP
    axes, reached = across(along), starts.copy()
    largest, share = np.zeros(len(starts)), BOX
    for _ in range(ROUNDS):
        offset = reached[:, None] - _nearest(wall, reached, is_cap)
        distance = norm(offset.reshape(-1, 3))
        radii = distance.reshape(offset.shape[:2]).min(axis=1)
        largest = np.maximum(largest, radii)
        slope = np.einsum("nij,nkj->nki", axes, offset).reshape(-1, 2) / distance[:, None]
        rows = np.arange(0, len(distance), offset.shape[1])
        step, _ = largest_steps(LinearRows(distance, slope, rows, radii), share * radii)
        reached += np.einsum("ni,nij->nj", step, axes)
        share *= SMALLER
    return largest


def _nearest(wall: Points, centers: Points, is_cap: Flags) -> Floats:
    """The points (n, k, 3) of the wall nearest to each center; those in caps (n, m) are far."""
    count = min(NEAREST, len(wall))
    squares = dot(centers, centers)[:, None] - 2 * centers @ wall.T + dot(wall, wall)
    squares[is_cap] = np.inf
    return np.asarray(wall[np.argpartition(squares, count - 1, axis=1)[:, :count]])
