"""Points against stacks of line segments: the arithmetic under polylines and centerline trees."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats
from .rows import dot, product

PAIRS_PER_BLOCK = 500_000
"""Query-segment pairs that are held in memory at a time (about 50 MB)."""

SHORT, FEW = 16, 10_000
"""Segments, and pairs, up to which all are looked at."""

ROUNDING = 1e-12
"""Share of the largest square that takes part."""


class SegmentLocations(NamedTuple):
    """For each of k queries the nearest segment, the fraction along it, foot point, distance."""

    segments: NDArray[np.int64]
    fractions: Floats
    points: Floats
    distances: Floats


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
    """The same, looking only at segments that can be the nearest.

    The square of the distance is below that of the nearer end by that of half the segment at most.
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
