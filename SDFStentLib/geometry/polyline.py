"""What `Line` knows, of bare points: for rooms that do not carry lines yet."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..validation import Flags, Floats, Points, Triangles
from .line import ClosestPoints, Line
from .section import Inside


def length(points: Points) -> float:
    """Of a polyline, mm."""
    return Line(points).length if len(points) else 0.0


def arc_lengths(points: ArrayLike) -> Floats:
    """At each point, mm."""
    return Line(points).arc_lengths


def tangents(points: ArrayLike) -> Floats:
    """Unit directions."""
    return Line(points).directions


def resampled(points: ArrayLike, spacing: float) -> Points:
    """At equal arc lengths, mm."""
    return Line(points).resampled(spacing).points


def cut(points: ArrayLike, start: float, end: float) -> Points:
    """The part between two arc lengths, mm."""
    return Line(points).cut(start, end).points


def point_at(points: ArrayLike, arc_length: ArrayLike) -> Floats:
    """Places at arc lengths, mm."""
    return Line(points).at(arc_length)


def closest_points(points: ArrayLike, places: Points) -> ClosestPoints:
    """Of places (k, 3)."""
    return Line(points).nearest(places)


def without_repeats(points: ArrayLike) -> Points:
    """The polyline without repeats."""
    return Line(points).without_repeats().points


def is_inside(queries: Points, points: Points, triangles: Triangles) -> Flags:
    """As `Surface.contains`."""
    return Inside(points, triangles).contains(queries)
