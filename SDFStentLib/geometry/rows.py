"""Arithmetic on the rows of arrays (n, 3), and runs of different lengths in one array."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..validation import Flags, Floats, Indices, Points

_Value = TypeVar("_Value", np.float64, np.bool_)

_PRODUCT = 1 << 17
"""Multiplications at a time; from twice as many on, some libraries start more threads."""


_BLOCK = 1 << 14
"""Rows at a time: a dozen temporaries of these fit into the cache of a core. Of 2^12 to 2^18 the
quickest on 1.2 million triangles."""


def in_blocks(
    work: Callable[[NDArray[Any]], NDArray[_Value]], rows: NDArray[Any]
) -> NDArray[_Value]:
    """Some work on rows whose results (..., n) do not depend on one another, block by block.

    Temporaries that stay in the cache cost a half to a third of those that do not.
    """
    if len(rows) <= _BLOCK:
        return work(rows)
    parts = [work(rows[first : first + _BLOCK]) for first in range(0, len(rows), _BLOCK)]
    return np.concatenate(parts, axis=-1)


def dot(one: Floats, other: Floats) -> Floats:
    """Scalar products (n,) of the rows."""
    return np.einsum("ij,ij->i", one, other)


def norm(vectors: Floats) -> Floats:
    """Lengths (n,) of the rows."""
    return np.sqrt(dot(vectors, vectors))


def product(left: Floats, right: Floats) -> Floats:
    """The product of matrices (n, k) and (k, m), or of a matrix and a vector (k,).

    Worked out in blocks so small that no linear algebra library wakes its threads: these gain
    nothing where k is 3, and spin for longer than the product takes.
    """
    if right.ndim == 1:
        return np.einsum("ij,j->i", left, right)
    result = np.empty((len(left), right.shape[1]))
    size = max(1, _PRODUCT // max(1, left.shape[1]))
    if len(left) <= right.shape[1]:
        columns = max(1, size // max(1, len(left)))
        for first in range(0, right.shape[1], columns):
            block = slice(first, first + columns)
            result[:, block] = left @ right[:, block]
    else:
        rows = max(1, size // max(1, right.shape[1]))
        for first in range(0, len(left), rows):
            block = slice(first, first + rows)
            np.matmul(left[block], right, out=result[block])
    return result


def bits(rows: Flags) -> NDArray[np.uint8]:
    """Rows of flags (n, m) packed into bytes (k, m): eight rows to a byte, the first in the
    highest bit.

    The same as `np.packbits` along the first axis, in a tenth of its time. At least one row.
    """
    values, places = rows.view(np.uint8), (128 >> np.arange(8)).astype(np.uint8)
    parts = [values[first : first + 8] for first in range(0, len(rows), 8)]
    return np.stack([np.einsum("n,nm->m", places[: len(part)], part) for part in parts])


def box_of(points: Points) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates (3,) of some points (n, 3).

    Column by column, which takes a tenth of the time over many rows of three.
    """
    columns = list(points.T)
    return np.array([x.min() for x in columns]), np.array([x.max() for x in columns])


def in_box(points: Points, low: Floats, high: Floats) -> Flags:
    """Mask (n,) of the points (n, 3) in a box, its sides counted, likewise."""
    columns = zip(points.T, low, high, strict=True)
    return np.logical_and.reduce([(x >= first) & (x <= last) for x, first, last in columns])


def across(directions: Floats) -> Floats:
    """Two unit vectors (n, 2, 3) perpendicular to every unit direction (n, 3) and to each other."""
    axis = np.eye(3)[np.abs(directions).argmin(axis=1)]
    first = np.cross(directions, axis)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(directions, first)], axis=1)


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


def used_points(triangles: Indices) -> Indices:
    """Numbers (k,) of the points that some triangles (m, 3) use, in ascending order."""
    # NumPy 2.3 to 2.4 take a hundred times longer for `unique` of many numbers that differ.
    is_used = np.zeros(int(triangles.max(initial=-1)) + 1, dtype=bool)
    is_used[triangles] = True
    return np.flatnonzero(is_used)


def different_counts(labels: Indices, numbers: Indices, count: int) -> Indices:
    """How many different ones among numbers (k,) each of `count` labels has, (count,)."""
    base = int(numbers.max(initial=0)) + 1
    keys = labels.astype(np.int64) * base + numbers
    keys.sort()  # `unique` by rows takes twenty times longer, and lets no other thread run
    is_first = np.ones(len(keys), dtype=bool)
    np.not_equal(keys[1:], keys[:-1], out=is_first[1:])
    return np.bincount(keys[is_first] // base, minlength=count)
