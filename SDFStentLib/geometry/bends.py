"""Directions along a polyline, and how tightly it bends."""

from __future__ import annotations

from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..validation import Floats, Points, as_number, as_point, as_points
from .polyline import (
    length,
    point_at,
    positive_length,
    segment_lengths,
    without_repeats,
)
from .rows import dot

_NONE = 1e-9
"""Length below which a vector across a unit vector has no direction."""


def tangents(points: ArrayLike) -> Floats:
    """Unit tangent at each point: the mean direction of the two segments that meet there.

    A repeated point gets the tangent of the point it repeats; at a turn of exactly 180 degrees
    the direction of arrival counts.

    Raises
    ------
    InputError
        A polyline without length.
    """
    polyline = as_points(points, "polyline", minimum=2)
    positive_length(polyline)
    lengths = segment_lengths(polyline)
    solid = np.flatnonzero(lengths > 0)
    directions = np.diff(polyline, axis=0)[solid] / lengths[solid, None]
    # Per point the solid segment that arrives and the one that leaves; ends have only one.
    arriving = np.clip(np.searchsorted(solid, np.arange(len(polyline))) - 1, 0, None)
    leaving = np.clip(np.searchsorted(solid, np.arange(len(polyline))), None, len(solid) - 1)
    sums = directions[arriving] + directions[leaving]
    sizes = np.linalg.norm(sums, axis=1, keepdims=True)
    turned_back = sizes[:, 0] < 1e-12
    sums[turned_back], sizes[turned_back] = directions[arriving[turned_back]], 1.0
    return sums / sizes


def frames(points: ArrayLike, first_normal: ArrayLike | None = None) -> Floats:
    """Right-handed frames of minimal twist.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    first_normal : array_like, shape (3,), optional
        Wanted normal at the first point; its part along the tangent is left out. Without it,
        or when it is parallel to the tangent, the coordinate axis farthest from the tangent.

    Returns
    -------
    array, shape (n, 3, 3)
        Rows are tangent, normal, binormal. From point to point the normal is turned by the
        smallest rotation that takes one tangent to the next.
    """
    return frames_along(tangents(points), first_normal)


def frames_along(along: Floats, first_normal: ArrayLike | None = None) -> Floats:
    """`frames` for unit tangents (n, 3)."""
    normals = np.empty_like(along)
    normals[0] = _normal_to(along[0], first_normal)
    # Plain numbers: arrays of three cost ten times as much.
    normal = normals[0].tolist()
    for i, (before, after) in enumerate(pairwise(along.tolist()), start=1):
        share = _dot(normal, after) / max(1.0 + _dot(before, after), 1e-12)
        turned = [n - share * b for n, b in zip(normal, before, strict=True)]
        away = _dot(turned, after)
        across = [n - away * a for n, a in zip(turned, after, strict=True)]
        size = sqrt(_dot(across, across))
        normal = _normal_to(along[i]).tolist() if size < _NONE else [n / size for n in across]
        normals[i] = normal
    return np.stack([along, normals, np.cross(along, normals)], axis=1)


def _dot(one: list[float], other: list[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _normal_to(tangent: Floats, wanted: ArrayLike | None = None) -> Floats:
    normal = np.zeros(3) if wanted is None else as_point(wanted, "first_normal")
    normal = normal - (normal @ tangent) * tangent
    if np.linalg.norm(normal) < _NONE:
        normal = np.eye(3)[np.abs(tangent).argmin()]
        normal = normal - (normal @ tangent) * tangent
    return normal / np.linalg.norm(normal)


class Bend(NamedTuple):
    """A bend of a polyline."""

    radius: float
    """mm; infinity when straight."""
    point: Points
    """(3,) where it is."""


def minimum_bend_radius(points: ArrayLike, window: float | None = None) -> float:
    """Radius of the `tightest_bend`, mm; infinity when straight."""
    return tightest_bend(points, window).radius


def tightest_bend(points: ArrayLike, window: float | None = None) -> Bend:
    """The tightest bend of a polyline, and where it is.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    window : float, optional
        Arc length (mm) from the middle to the outer ones of the three points that are compared,
        so that jitter of a dense centerline does not count as a bend; at most half the length.
        A corner of angle a then has the radius `window / (2 sin(a / 2))`. Default: neighbors.

    Returns
    -------
    Bend
        Smallest radius of the circles through three points (exact on a circular arc), and the
        middle one of these; the first of equals.
    """
    polyline = without_repeats(points)
    if len(polyline) < 3:
        return Bend(float("inf"), polyline[0])
    before, middle, after = polyline[:-2], polyline[1:-1], polyline[2:]
    if window is not None:
        total = length(polyline)
        reach = min(as_number(window, "window", unit="mm", above=0), total / 2.0)
        # Steps of an eighth of the window (a corner is met to a sixteenth), memory bounded.
        count = 2 + int(min(8.0 * (total - 2.0 * reach) / reach, 50_000))
        at = np.linspace(reach, total - reach, count)
        before, middle, after = (point_at(polyline, at + shift) for shift in (-reach, 0.0, reach))
    first, second = middle - before, after - middle
    sides = [np.linalg.norm(side, axis=1) for side in (first, second, first + second)]
    product = sides[0] * sides[1] * sides[2]
    twice = 2.0 * np.linalg.norm(np.cross(first, second), axis=1)
    # Straight on (or turned back by 180 degrees) the circle degenerates to a line (or a point).
    flat = twice <= 1e-12 * sides[0] * sides[1]
    turned_back = dot(first, second) < 0
    radii = np.where(turned_back, 0.0, np.inf)
    radii[~flat] = product[~flat] / twice[~flat]
    tightest = int(radii.argmin())
    return Bend(float(radii[tightest]), middle[tightest])
