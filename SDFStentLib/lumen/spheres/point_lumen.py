"""The lumen among points that stand for a wall: rough, and fast enough for every preview."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...geometry import Line, across, dot
from ...validation import Flags, Floats, Indices, InputError, Points, as_points
from ..tolerances import ACROSS
from .climb import ROUGHLY
from .followed import among_points


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
    is_cap = np.abs(along @ as_points(normals, "normals").T) > ACROSS
    count = min(ROUGHLY, len(wall))
    station = np.repeat(np.arange(len(starts)), count)

    def around(centers: Points) -> tuple[Indices, Points]:
        return station, _nearest(wall, centers, is_cap, count)

    return among_points(around, starts, across(along)).radii


def _nearest(wall: Points, centers: Points, is_cap: Flags, count: int) -> Points:
    """So many points of the wall that are nearest to each center; those in caps (n, m) are far."""
    squares = dot(centers, centers)[:, None] - 2 * centers @ wall.T + dot(wall, wall)
    squares[is_cap] = np.inf
    nearest = np.argpartition(squares, count - 1, axis=1)[:, :count]
    return wall.take(nearest.ravel(), axis=0)
