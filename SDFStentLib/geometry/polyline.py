"""Open polylines as (n, 3) arrays: arc length, resampling, cutting, projection.

Every function leaves its input as it is. Repeated points (zero-length segments) are normal input.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import Floats, InputError, Points, as_number, as_point, as_points
from .segments import closest_on_segments

MOST_SEGMENTS = 20_000
"""Of a line that is made anew: one per 0.01 mm of 200 mm. Each is worth some ms where measured."""


class ClosestPoint(NamedTuple):
    """The point of a polyline that is nearest to a query point."""

    point: Floats
    distance: float
    arc_length: float


class ClosestPoints(NamedTuple):
    """`ClosestPoint` for a stack of k queries, and the segment on which each lies."""

    points: Points
    distances: Floats
    arc_lengths: Floats
    segments: NDArray[np.int64]
    fractions: Floats


def segment_lengths(points: Points) -> Floats:
    """Length of each of the n - 1 segments, mm."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def length(points: Points) -> float:
    """Length of the whole polyline, mm; 0 for a single point."""
    return float(segment_lengths(points).sum())


def arc_lengths(points: Points) -> Floats:
    """Arc length at each of the n points, mm; 0 at the first."""
    return np.concatenate([[0.0], np.cumsum(segment_lengths(points))])


def without_repeats(points: ArrayLike, tolerance: float = 1e-9) -> Points:
    """The polyline without points nearer than `tolerance` to the one before.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    tolerance : float
        Distance up to which a point repeats the last kept one, mm.

    Returns
    -------
    array, shape (m, 3)
        First and last point are kept exactly; one point when all of them coincide.
    """
    polyline = as_points(points, "polyline", minimum=1)
    return polyline[kept_points(polyline, tolerance)]


def kept_points(polyline: Points, tolerance: float = 1e-9) -> NDArray[np.int64]:
    """Indices of the points that `without_repeats` keeps, for arrays that go along with them."""
    if (segment_lengths(polyline) > tolerance).all():
        return np.arange(len(polyline))
    kept = [0]
    for i in range(1, len(polyline)):
        if np.linalg.norm(polyline[i] - polyline[kept[-1]]) > tolerance:
            kept.append(i)
    if len(kept) > 1 and np.linalg.norm(polyline[-1] - polyline[kept[-1]]) <= tolerance:
        kept[-1] = len(polyline) - 1
    return np.array(kept, dtype=np.int64)


def resampled(points: ArrayLike, spacing: float) -> Points:
    """Points at equal arc length; both ends are kept exactly.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    spacing : float
        Wanted arc length between points, mm. The polyline of length L gets
        `max(1, round(L / spacing))` segments.

    Raises
    ------
    InputError
        Spacing not positive or too small to count, fewer than two points, or a polyline without
        length.
    """
    polyline = as_points(points, "polyline", minimum=2)
    return resampled_to(polyline, segment_count(length(polyline), spacing) + 1)


def segment_count(length: float, spacing: float) -> int:
    """How many segments of about that length fill a line, at least one; mm.

    Raises
    ------
    InputError
        Spacing not positive, or more than `MOST_SEGMENTS`.
    """
    spacing = as_number(spacing, "spacing", unit="mm", above=0)
    if length / MOST_SEGMENTS > spacing:
        raise InputError(
            f"spacing: expected at least {length / MOST_SEGMENTS:.2g} (mm) on a line of "
            f"{length:.4g} mm, got {spacing:g}; more than {MOST_SEGMENTS} places take too long."
        )
    return max(1, round(length / spacing))


def resampled_to(points: ArrayLike, count: int) -> Points:
    """`count` (at least two) points at equal arc length; both ends are kept exactly.

    Raises
    ------
    InputError
        `count` below two, fewer than two points, or a polyline without length.
    """
    if count < 2:
        raise InputError(f"count: expected at least 2 points, got {count}.")
    polyline = as_points(points, "polyline", minimum=2)
    total = positive_length(polyline)
    result = point_at(polyline, np.linspace(0.0, total, count))
    result[0], result[-1] = polyline[0], polyline[-1]
    return result


def point_at(points: Points, arc_length: ArrayLike) -> Floats:
    """The point, or points, at the given arc length.

    Parameters
    ----------
    points : array, shape (n, 3)
        Polyline, mm.
    arc_length : float or array_like, shape (k,)
        Arc length, mm. Below zero it counts as the start, beyond the length as the end.

    Returns
    -------
    array, shape (3,) or (k, 3)
    """
    if len(points) == 1:
        return np.broadcast_to(points[0], (*np.shape(arc_length), 3)).copy()
    segments, fractions = locate(points, arc_length)
    weights = np.asarray(fractions)[..., None]
    return (1.0 - weights) * points[segments] + weights * points[np.asarray(segments) + 1]


def locate(points: Points, arc_length: ArrayLike) -> tuple[NDArray[np.int64], Floats]:
    """Segment and fraction along it, in [0, 1], for arc lengths on a polyline of n > 1 points."""
    at = arc_lengths(points)
    wanted = np.clip(np.asarray(arc_length, dtype=np.float64), 0.0, at[-1])
    segments = np.clip(np.searchsorted(at, wanted, side="right") - 1, 0, len(points) - 2)
    lengths = at[segments + 1] - at[segments]
    fractions = (wanted - at[segments]) / np.where(lengths > 0, lengths, 1.0)
    return segments, np.clip(fractions, 0.0, 1.0)


def cut(points: ArrayLike, start: float, end: float) -> Points:
    """The part between two arc lengths, with exact new ends.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Polyline, mm.
    start, end : float
        Arc lengths, mm; what lies outside the polyline is left out.

    Raises
    ------
    InputError
        Nothing lies between `start` and `end`.
    """
    polyline = as_points(points, "polyline", minimum=2)
    at = arc_lengths(polyline)
    first, last = max(start, 0.0), min(end, at[-1])
    if not first < last:
        raise InputError(
            f"cut: expected a start before the end on a polyline of {at[-1]:g} mm, "
            f"got {start:g} to {end:g} mm."
        )
    inside = polyline[(at > first) & (at < last)]
    ends = point_at(polyline, [first, last])
    return without_repeats(np.concatenate([ends[:1], inside, ends[1:]]))


def closest_point(points: Points, query: ArrayLike) -> ClosestPoint:
    """The nearest point of the polyline, on its segments; the first one of equals.

    Raises
    ------
    InputError
        The query is not one finite point.
    """
    found = closest_points(points, as_point(query, "query")[None])
    return ClosestPoint(found.points[0], float(found.distances[0]), float(found.arc_lengths[0]))


def closest_points(points: Points, queries: ArrayLike) -> ClosestPoints:
    """`closest_point` for a stack of queries, shape (k, 3); works in blocks of bounded memory."""
    polyline = as_points(points, "polyline", minimum=1)
    if len(polyline) == 1:
        polyline = np.repeat(polyline, 2, axis=0)
    found = closest_on_segments(polyline[:-1], polyline[1:], as_points(queries, "queries"))
    at = arc_lengths(polyline)
    along = at[found.segments] + found.fractions * np.diff(at)[found.segments]
    return ClosestPoints(found.points, found.distances, along, found.segments, found.fractions)


def positive_length(polyline: Points) -> float:
    """`length`, mm; `InputError` for points that are all at one place."""
    total = length(polyline)
    if total <= 0:
        raise InputError(
            f"polyline: expected two different points, got {len(polyline)} points at one place."
        )
    return total
