"""The cross-section of the lumen round an axis point."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import across, plane_section, product
from ..validation import Floats, InputError, Points, Triangles, as_points
from .section_areas import section_areas
from .tolerances import ROUNDING


def equivalent_diameters(
    points: Points, triangles: Triangles, centers: ArrayLike, directions: ArrayLike
) -> Floats:
    """Diameter (n,) of the circle with the area of the lumen's cross-section, 2 sqrt(A / pi), mm.

    The cross-section is the smallest closed loop of the cut that has the axis point inside; other
    vessels that the plane meets do not count. Islands in it, such as calcium, are no lumen.

    Parameters
    ----------
    points, triangles : (k, 3) and (m, 3) arrays
    centers, directions : array_like, shapes (n, 3)
        Axis points and the normals of the planes through them, of any length but zero.

    Returns
    -------
    (n,) array
        NaN where the axis point lies in no closed loop.

    Raises
    ------
    InputError
        Wrong shapes or a zero direction.
    """
    centers, directions = as_points(centers, "centers"), as_points(directions, "directions")
    if len(centers) != len(directions):
        raise InputError(
            f"directions: expected one for each of the {len(centers)} centers, "
            f"got {len(directions)}."
        )
    if len(directions) and not directions.any(axis=1).all():
        raise InputError("directions: expected no zero vector; remove repeated axis points.")
    normals = directions / np.linalg.norm(directions, axis=1)[:, None]
    areas, is_doubtful = section_areas(points, triangles, centers, normals)
    for number in np.flatnonzero(is_doubtful):
        areas[number] = _lumen_area(points, triangles, centers[number], directions[number])
    return 2 * np.sqrt(np.where(np.isfinite(areas), areas, np.nan) / np.pi)


def _lumen_area(points: Points, triangles: Triangles, center: Floats, direction: Floats) -> float:
    # Only triangles that may be cut go on, which is quick even on a large surface. The bits say
    # "below" and "above"; who is as near to the plane as rounding is neither, and goes on.
    normal = direction / np.linalg.norm(direction)
    heights = product(points - center, normal)
    margin = ROUNDING * max(1.0, float(np.abs(center).max()))
    side = (heights < -margin).astype(np.uint8) | (heights > margin).astype(np.uint8) << 1
    cut = triangles[(side[triangles[:, 0]] & side[triangles[:, 1]] & side[triangles[:, 2]]) == 0]
    if len(cut) == 0:
        return float("nan")
    used, compact = np.unique(cut, return_inverse=True)
    loops = plane_section(points[used], compact.reshape(-1, 3), center, direction)
    flat = [(loop.points - center) @ across(normal[None])[0].T for loop in loops if loop.is_closed]
    around = min(filter(_holds_origin, flat), key=_polygon_area, default=None)
    if around is None:
        return float("nan")
    islands = [one for one in flat if one is not around and _holds_origin(around - one[0])]
    # What is hollow counts once, by its outside.
    islands = [
        one
        for one in islands
        if not any(_holds_origin(other - one[0]) for other in islands if other is not one)
    ]
    return _polygon_area(around) - sum(map(_polygon_area, islands))


def _holds_origin(polygon: Floats) -> bool:
    """Whether the origin is inside a closed polygon (k, 2): a ray crosses it an odd time."""
    (x, y), (next_x, next_y) = polygon.T, np.roll(polygon, -1, axis=0).T
    crosses = (y > 0) != (next_y > 0)
    along = x[crosses] - y[crosses] * (next_x - x)[crosses] / (next_y - y)[crosses]
    return bool(np.count_nonzero(along > 0) % 2)


def _polygon_area(polygon: Floats) -> float:
    following = np.roll(polygon, -1, axis=0)
    return abs(float(np.sum(polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0])) / 2)
