"""Runs of different lengths, laid out one after the other in one array."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..validation import Indices


def blocks_of(counts: Indices, size: int) -> Iterator[Indices]:
    """Consecutive indices whose counts add up to about `size`; those with count 0 left out."""
    used = np.flatnonzero(counts)
    number = np.cumsum(counts[used]) // size
    for block in np.split(used, np.flatnonzero(np.diff(number)) + 1):
        if len(block):
            yield block


def ranges(first: Indices, counts: Indices) -> Indices:
    """`first[i], first[i] + 1, ...` (`counts[i]` of them) for every i, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) + np.repeat(first - ends + counts, counts)
