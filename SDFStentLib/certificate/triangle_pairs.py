"""Pairs of triangles whose boxes overlap: the broad phase of the self-intersection test.

Coordinates become 16-bit steps by one monotone map, so a comparison of steps can report an
overlap too many but never one too few. The two shorter axes are cut into square columns; in each
column the faces are sorted along the longest axis, where the overlapping ones are then neighbors.
A pair is yielded only in its lowest common column, which spares sorting out repeats.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import blocks_of, box_of, ranges, used_points
from ..validation import Indices, Points, Triangles

_BLOCK = 1 << 18
"""Pairs or column entries in work at once; the largest temporaries are some 20 MB."""

_WIDTH = 4.0
"""Width of a column in mean boxes: of 1.5 to 9 the quickest on ten surfaces of vessels."""

_LAST = 65535
"""Highest step. Steps 0 and `_LAST` stand for all that lies outside the region that counts."""

_STEP = np.int64(_LAST)
"""The bits of a place and a step that are those of the step."""


class Boxes(NamedTuple):
    """Boxes of the faces that can meet a moved one, in steps; axes go from longest to shortest.

    Attributes
    ----------
    faces : (b,) array
        Face of each box.
    low, high : (3, b) arrays of uint16
    is_moved : (b,) array
    """

    faces: Indices
    low: NDArray[np.uint16]
    high: NDArray[np.uint16]
    is_moved: NDArray[np.bool_]


def face_boxes(points: Points, triangles: Triangles, is_moved: NDArray[np.bool_]) -> Boxes:
    """Boxes of the moved faces and of those that reach into the box around all moved faces."""
    corners = np.ascontiguousarray(triangles.T)
    low, high = box_of(points.take(used_points(triangles.compress(is_moved, axis=0)), axis=0))
    axes = np.argsort(low - high, kind="stable")
    scale = (_LAST - 2) / max(float((high - low).max()), 1e-290)

    lows, highs = [], []
    is_near = np.ones(len(triangles), dtype=bool)
    for axis in axes:
        steps = _steps(points[:, axis], low[axis], high[axis], scale)
        first, second, third = (steps.take(corner) for corner in corners)
        lows.append(np.minimum(np.minimum(first, second), third))
        highs.append(np.maximum(np.maximum(first, second), third))
        is_near &= (highs[-1] > 0) & (lows[-1] < _LAST)
    faces = np.flatnonzero(is_near)
    return Boxes(
        faces,
        np.stack([values.take(faces) for values in lows]),
        np.stack([values.take(faces) for values in highs]),
        is_moved[faces],
    )


def overlapping_pairs(boxes: Boxes) -> Iterator[tuple[Indices, Indices]]:
    """Numbers in `boxes` of overlapping pairs with a moved face, each pair once, block by block."""
    size = _column_size(boxes)
    first_row, last_row = boxes.low[1] // size, boxes.high[1] // size
    first_column, last_column = boxes.low[2] // size, boxes.high[2] // size
    widths = last_column.astype(np.int64) - first_column + 1

    for start, stop in _row_blocks(first_row, last_row, widths):
        here = np.flatnonzero((first_row < stop) & (last_row >= start))
        top = np.maximum(first_row.take(here), start).astype(np.int64)
        heights = np.minimum(last_row.take(here), stop - 1) - top + 1
        counts = heights * widths.take(here)
        box = np.repeat(here, counts)
        row, column = np.divmod(ranges(np.zeros_like(counts), counts), widths.take(box))
        row += np.repeat(top, counts)
        column += first_column.take(box)
        # Bit 0: lowest row of this box; bit 1: lowest column; bit 2: moved. Where both of a pair
        # are together for the first time, one of them is at its lowest, in each direction.
        marks = (row == first_row.take(box)) | ((column == first_column.take(box)) << 1)
        marks |= boxes.is_moved.take(box).astype(np.int64) << 2
        place = (row << 32) | (column << 16)
        yield from _sweep(boxes, box, place, marks.astype(np.uint8))


def _sweep(
    boxes: Boxes, box: Indices, place: Indices, marks: NDArray[np.uint8]
) -> Iterator[tuple[Indices, Indices]]:
    # `take` copies several times quicker than an index in brackets does.
    keys = place | boxes.low[0].take(box)
    order = np.argsort(keys)
    box, marks, keys = box.take(order), marks.take(order), keys.take(order)
    last = (keys & ~_STEP) | boxes.high[0].take(box)
    counts = np.searchsorted(keys, last, side="right") - np.arange(1, len(keys) + 1)
    low, high = boxes.low[1:].take(box, axis=1), boxes.high[1:].take(box, axis=1)
    for entries in blocks_of(counts, _BLOCK):
        one = np.repeat(entries, counts.take(entries))
        other = ranges(entries + 1, counts.take(entries))
        meet = np.flatnonzero((marks.take(one) | marks.take(other)) == 7)
        one, other = one.take(meet), other.take(meet)
        for k in range(2):
            meets = low[k].take(one) <= high[k].take(other)
            meets &= low[k].take(other) <= high[k].take(one)
            meet = np.flatnonzero(meets)
            one, other = one.take(meet), other.take(meet)
        if len(one):
            yield box.take(one), box.take(other)


def _steps(
    values: NDArray[np.float64], low: float, high: float, scale: float
) -> NDArray[np.uint16]:
    steps = np.minimum((np.clip(values, low, high) - low) * scale, _LAST - 2) + 1
    steps[values < low] = 0
    steps[values > high] = _LAST
    return steps.astype(np.uint16)


def _column_size(boxes: Boxes) -> int:
    """Width of a column in steps: `_WIDTH`, doubled while large faces fill too many."""
    extents = boxes.high[1:].astype(np.int64) - boxes.low[1:]
    size = max(16, int(_WIDTH * extents.mean()))
    # Ends: the size doubles from 16 at least.
    while size < _LAST:
        entries = np.prod(boxes.high[1:] // size - boxes.low[1:] // size + np.int64(1), axis=0)
        if entries.sum() <= 6 * len(boxes.faces):
            break
        size *= 2
    return min(size, _LAST)


def _row_blocks(
    first_row: NDArray[np.uint16], last_row: NDArray[np.uint16], widths: Indices
) -> Iterator[tuple[int, int]]:
    """Consecutive rows that hold about `_BLOCK` entries together."""
    rows = int(last_row.max()) + 1
    begin = np.bincount(first_row, weights=widths, minlength=rows + 1)
    end = np.bincount(last_row + np.int64(1), weights=widths, minlength=rows + 1)
    entries = np.cumsum(begin - end)[:rows].astype(np.int64)
    for block in blocks_of(entries, _BLOCK):
        yield int(block[0]), int(block[-1]) + 1
