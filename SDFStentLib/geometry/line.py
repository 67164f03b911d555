"""An open polyline as one value, checked and measured once, and the arithmetic of its segments."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import Floats, Indices, InputError, Points, as_number, as_points, read_only
from .rows import dot, product

PAIRS_PER_BLOCK = 500_000
"""Query-segment pairs that are held in memory at a time (about 50 MB)."""

SHORT, FEW = 16, 10_000
"""Numbers of segments and of pairs below which every pair is looked at."""

ROUNDING = 1e-12
"""Rounding of a squared distance, over the largest square that takes part in it."""


class SegmentLocations(NamedTuple):
    """The nearest segment of each of k queries, the fraction along it, foot point, distance."""

    segments: NDArray[np.int64]
    fractions: Floats
    points: Floats
    distances: Floats


def places_in_plane(starts: Points, ends: Points, origin: Floats, normal: Floats) -> Points:
    """Points where pieces (k, 3) of lines cross a plane, whose normal (3,) has any length."""
    first, last = (starts - origin) @ normal, (ends - origin) @ normal
    through = np.flatnonzero((first < 0) != (last < 0))
    share = first[through] / (first[through] - last[through])
    return np.asarray(starts[through] + share[:, None] * (ends - starts)[through])


def closest_on_segments(starts: Floats, ends: Floats, queries: Floats) -> SegmentLocations:
    """The nearest of m segments for each of k queries.

    Parameters
    ----------
    starts, ends : arrays, shape (m, 3)
        Segment ends, mm. A zero-length segment counts as the point `starts`.
    queries : array, shape (k, 3)
        Query points, mm.
    """
    block = max(1, PAIRS_PER_BLOCK // len(starts))
    segments = np.empty(len(queries), dtype=np.int64)
    is_short = len(starts) < SHORT or len(queries) * len(starts) < FEW
    nearest = _nearest if is_short else _nearest_of_some
    for first in range(0, len(queries), block):
        segments[first : first + block] = nearest(starts, ends, queries[first : first + block])
    squared, fractions = distances_to_segments(queries, starts[segments], ends[segments])
    weights = fractions[:, None]
    feet = (1.0 - weights) * starts[segments] + weights * ends[segments]
    return SegmentLocations(segments, fractions, feet, np.sqrt(squared))


def _nearest(starts: Floats, ends: Floats, queries: Floats) -> NDArray[np.int64]:
    """Number (k,) of the nearest segment, the first of equals."""
    squared, _ = distances_to_segments(queries[:, None], starts, ends)
    return squared.argmin(axis=1)


def _nearest_of_some(starts: Floats, ends: Floats, queries: Floats) -> NDArray[np.int64]:
    """The nearest as of `_nearest`, looking only at segments that can be it.

    A segment's squared distance is less than that of its nearer end by the square of half its
    length at most.
    """
    middle = starts.mean(axis=0)
    places = queries - middle
    own = dot(places, places)[:, None]
    to_starts, to_ends = (
        own + dot(one, one) - 2 * product(places, one.T) for one in (starts - middle, ends - middle)
    )
    to_end = np.minimum(to_starts, to_ends, out=to_starts)
    axes = ends - starts
    slack = dot(axes, axes) / 4 + ROUNDING * max(to_end.max(), to_ends.max())
    query, segment = np.nonzero(to_end - slack <= to_end.min(axis=1, keepdims=True))
    squared, _ = distances_to_segments(queries[query], starts[segment], ends[segment])
    first = np.searchsorted(query, np.arange(len(queries)))
    is_least = squared == np.minimum.reduceat(squared, first)[query]
    # What is written last stays: the first of equals.
    found = np.empty(len(queries), dtype=np.int64)
    found[query[is_least][::-1]] = segment[is_least][::-1]
    return found


def distances_to_segments(queries: Floats, starts: Floats, ends: Floats) -> tuple[Floats, Floats]:
    """Squared distance and fraction along the segment; queries broadcast against segments."""
    axes = ends - starts
    squared_lengths = np.einsum("...i,...i->...", axes, axes)
    offsets = queries - starts
    fractions = np.einsum("...i,...i->...", offsets, axes)
    fractions = np.clip(fractions / np.where(squared_lengths > 0, squared_lengths, 1.0), 0.0, 1.0)
    offsets = offsets - fractions[..., None] * axes
    return np.einsum("...i,...i->...", offsets, offsets), fractions


MOST_SEGMENTS = 20_000
"""Most segments of a resampled line: one per 0.01 mm of 200 mm. Measuring costs some ms at each."""

REPEATED = 1e-9
"""Distance up to which a point repeats the one before it, mm."""


class ClosestPoints(NamedTuple):
    """The points of a line that are nearest to k places, the first ones of equals."""

    points: Points
    distances: Floats
    arc_lengths: Floats
    segments: Indices
    fractions: Floats


@dataclass(frozen=True, eq=False, init=False)
class Line:
    """An open polyline. Immutable, checked when it is made and never again.

    Repeated points (pieces without length) are normal.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        mm; copied.
    name : str
        Name of the line in messages.

    Raises
    ------
    InputError
        No point, or coordinates that are no finite numbers.
    """

    points: Points

    def __init__(self, points: ArrayLike, name: str = "polyline") -> None:
        object.__setattr__(self, "points", read_only(as_points(points, name, minimum=1)))

    @classmethod
    def _of(cls, points: Points) -> Line:
        """A line through points that follow from those of a sound line: they are not checked
        again."""
        line = object.__new__(cls)
        points.setflags(write=False)
        object.__setattr__(line, "points", points)
        return line

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def pieces(self) -> Floats:
        """Lengths (n - 1,) of the pieces, mm."""
        return np.linalg.norm(np.diff(self.points, axis=0), axis=1)

    @cached_property
    def length(self) -> float:
        """Length of the whole line, mm; 0 for a single point."""
        return float(self.pieces.sum())

    @cached_property
    def arc_lengths(self) -> Floats:
        """Arc lengths (n,) of the points, mm; 0 at the first."""
        return read_only(np.concatenate([[0.0], np.cumsum(self.pieces)]))

    @cached_property
    def directions(self) -> Floats:
        """Unit tangent (n, 3) at each point: the mean direction of the two pieces that meet there.

        A repeated point gets the tangent of the point it repeats; at a turn of exactly 180 degrees
        the direction of arrival counts.

        Raises
        ------
        InputError
            A line without length.
        """
        self.check_length()
        count, lengths = len(self.points), self.pieces
        solid = np.flatnonzero(lengths > 0)
        directions = np.diff(self.points, axis=0)[solid] / lengths[solid, None]
        # Per point the solid piece that arrives and the one that leaves; ends have only one.
        arriving = np.clip(np.searchsorted(solid, np.arange(count)) - 1, 0, None)
        leaving = np.clip(np.searchsorted(solid, np.arange(count)), None, len(solid) - 1)
        sums = directions[arriving] + directions[leaving]
        sizes = np.linalg.norm(sums, axis=1, keepdims=True)
        turned_back = sizes[:, 0] < 1e-12
        sums[turned_back], sizes[turned_back] = directions[arriving[turned_back]], 1.0
        return read_only(sums / sizes)

    def at(self, arc_length: ArrayLike) -> Floats:
        """The place (3,), or places (k, 3), at arc lengths, mm.

        An arc length below zero counts as the start, one beyond the length as the end.
        """
        if len(self.points) == 1:
            return np.broadcast_to(self.points[0], (*np.shape(arc_length), 3)).copy()
        segments, fractions = self.located(arc_length)
        weights = np.asarray(fractions)[..., None]
        ends = self.points[segments], self.points[np.asarray(segments) + 1]
        return (1.0 - weights) * ends[0] + weights * ends[1]

    def located(self, arc_length: ArrayLike) -> tuple[Indices, Floats]:
        """Piece and fraction along it, in [0, 1], at arc lengths on a line of n > 1 points."""
        at = self.arc_lengths
        wanted = np.clip(np.asarray(arc_length, dtype=np.float64), 0.0, at[-1])
        segments = np.clip(np.searchsorted(at, wanted, side="right") - 1, 0, len(at) - 2)
        lengths = at[segments + 1] - at[segments]
        fractions = (wanted - at[segments]) / np.where(lengths > 0, lengths, 1.0)
        return segments, np.clip(fractions, 0.0, 1.0)

    def nearest(self, places: Points) -> ClosestPoints:
        """The nearest points of the line to places (k, 3); works in blocks of bounded memory."""
        line = self.points if len(self.points) > 1 else np.repeat(self.points, 2, axis=0)
        found = closest_on_segments(line[:-1], line[1:], places)
        at = self.arc_lengths if len(self.points) > 1 else np.zeros(2)
        along = at[found.segments] + found.fractions * np.diff(at)[found.segments]
        return ClosestPoints(found.points, found.distances, along, found.segments, found.fractions)

    def cut(self, start: float, end: float) -> Line:
        """The part between two arc lengths, mm, with exact new ends and without repeated points.

        Raises
        ------
        InputError
            Nothing of the line lies between `start` and `end`.
        """
        at = self.arc_lengths
        first, last = max(start, 0.0), min(end, at[-1])
        if not first < last:
            raise InputError(
                f"cut: expected a start before the end on a polyline of {at[-1]:g} mm, "
                f"got {start:g} to {end:g} mm."
            )
        inside = self.points[(at > first) & (at < last)]
        ends = self.at([first, last])
        return Line._of(np.concatenate([ends[:1], inside, ends[1:]])).without_repeats()

    def resampled(self, spacing: float) -> Line:
        """Points at equal arc length of about `spacing` mm; both ends are kept exactly.

        Raises
        ------
        InputError
            As `segment_count`, or a line without length.
        """
        return self.resampled_to(segment_count(self.length, spacing) + 1)

    def resampled_to(self, count: int) -> Line:
        """`count` points, two at least, at equal arc length; both ends are kept exactly.

        Raises
        ------
        InputError
            `count` below two, or a line without length.
        """
        if count < 2:
            raise InputError(f"count: expected at least 2 points, got {count}.")
        self.check_length()
        result = self.at(np.linspace(0.0, self.length, count))
        result[0], result[-1] = self.points[0], self.points[-1]
        return Line._of(result)

    def reversed(self) -> Line:
        """The same line from its end to its start."""
        return Line._of(self.points[::-1])

    def without_repeats(self) -> Line:
        """The line without points that repeat the one before; first and last are kept exactly."""
        kept = self.distinct
        return self if len(kept) == len(self) else Line._of(self.points[kept])

    @property
    def distinct(self) -> Indices:
        """Indices of the points that `without_repeats` keeps; a single one when all points
        coincide."""
        points = self.points
        if (self.pieces > REPEATED).all():
            return np.arange(len(points))
        kept = [0]
        for i in range(1, len(points)):
            if np.linalg.norm(points[i] - points[kept[-1]]) > REPEATED:
                kept.append(i)
        if len(kept) > 1 and np.linalg.norm(points[-1] - points[kept[-1]]) <= REPEATED:
            kept[-1] = len(points) - 1
        return np.array(kept, dtype=np.int64)

    def check_length(self) -> None:
        """`InputError` for points that are all at one place."""
        if self.length <= 0:
            raise InputError(
                f"polyline: expected two different points, got {len(self)} points at one place."
            )


def as_line(value: Line | ArrayLike, name: str = "polyline") -> Line:
    """The given line, or a new one through points (n, 3), mm; `InputError` as for `Line`."""
    return value if isinstance(value, Line) else Line(value, name)


def segment_count(length: float, spacing: float) -> int:
    """Number of segments of about a given length, mm, that fill a line; at least one.

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
