"""Points against stacks of line segments: the arithmetic under polylines and centerline trees."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats

PAIRS_PER_BLOCK = 500_000
"""Query-segment pairs that are held in memory at a time (about 50 MB)."""


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
    for first in range(0, len(queries), block):
        squared, _ = distances_to_segments(queries[first : first + block, None], starts, ends)
        segments[first : first + block] = squared.argmin(axis=1)
    squared, fractions = distances_to_segments(queries, starts[segments], ends[segments])
    weights = fractions[:, None]
    feet = (1.0 - weights) * starts[segments] + weights * ends[segments]
    return SegmentLocations(segments, fractions, feet, np.sqrt(squared))


def distances_to_segments(queries: Floats, starts: Floats, ends: Floats) -> tuple[Floats, Floats]:
    """Squared distance and fraction along the segment; queries broadcast against segments."""
    axes = ends - starts
    squared_lengths = np.einsum("...i,...i->...", axes, axes)
    offsets = queries - starts
    fractions = np.einsum("...i,...i->...", offsets, axes)
    fractions = np.clip(fractions / np.where(squared_lengths > 0, squared_lengths, 1.0), 0.0, 1.0)
    offsets = offsets - fractions[..., None] * axes
    return np.einsum("...i,...i->...", offsets, offsets), fractions
