"""Length of each ray of an X-ray within a closed surface: exactly, for all pixels at once.

A closed surface is left as often as it is entered. The sum of the depths at which a ray meets it,
with the sign of the side from which it comes, is the length within. Triangles are laid on the
pixels row by row; two that share an edge find the same place for it to the bit, so that no ray
slips through between them and none meets both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Surface, ranges
from ..validation import Floats, Indices, InputError, Points, Triangles

SOURCE = 780.0
"""Distance from the source to the isocenter, mm: that of the example in DICOM PS3.17, whose
detector is at 1200 mm."""


class Beam(NamedTuple):
    """The rays to the pixels of a detector."""

    axes: Floats
    """(3, 3) right, up, and toward the detector."""
    isocenter: Floats
    """(3,) in the middle of the picture, mm."""
    size: tuple[int, int]
    """Rows and columns."""
    pixel: float
    """Side of a pixel at the isocenter, mm; at the detector it is wider by its magnification."""
    source: float | None = None
    """Distance of the source from the isocenter, mm; None for parallel rays."""
    reach: float | None = None
    """Only lumen within this distance of the isocenter counts, mm; None for all."""

    @property
    def side(self) -> float:
        """Height of the picture at the isocenter, mm."""
        return self.size[0] * self.pixel

    def flat(self, points: Points) -> Floats:
        """Places (n, 2) of points (n, 3) in the picture: columns and rows, from the left upper
        corner."""
        return self._placed(points)[:, :2]

    def _placed(self, points: Points) -> Floats:
        """Columns, rows, and depths (n, 3): toward the detector, for a point source one over the
        distance from its plane, which is linear in the picture."""
        right, up, toward = ((points - self.isocenter) @ self.axes.T).T
        deep = toward
        if self.source is not None:
            if (toward <= -self.source).any():
                raise InputError(
                    f"source: expected one outside of the patient, got {self.source:g} mm from "
                    "the isocenter, which is amidst the vessels; move it away."
                )
            deep = 1 / (self.source + toward)
            right, up = right * self.source * deep, up * self.source * deep
        rows, columns = self.size
        return np.column_stack([columns / 2 + right / self.pixel, rows / 2 - up / self.pixel, deep])

    def _depths(self, deep: Floats, number: Indices) -> Floats:
        """Depths along the rays to some pixels, mm, cut to those within reach."""
        row, column = np.divmod(number, self.size[1])
        right = (column + 0.5 - self.size[1] / 2) * self.pixel
        up = (self.size[0] / 2 - row - 0.5) * self.pixel
        squared = right**2 + up**2
        middle: Floats | float = 0.0
        if self.source is not None:
            # Along the ray from the source; it comes nearest to the isocenter at `middle`.
            longer = np.sqrt(squared + self.source**2)
            deep, middle = longer / (self.source * deep), self.source**2 / longer
            squared = self.source**2 - middle**2
        if self.reach is None:
            return deep
        half = np.sqrt(np.maximum(self.reach**2 - squared, 0.0))
        return np.asarray(np.clip(deep, middle - half, middle + half))


class _Spans(NamedTuple):
    """Pieces of rows of pixels that triangles cover."""

    row: Indices
    first: Indices
    counts: Indices
    left: Floats
    """(k, 2) column and depth at one end, and"""
    right: Floats
    """at the other."""
    sign: Floats


def path_lengths(surface: Surface, beam: Beam) -> Floats:
    """Lengths (rows, columns) within a surface of the rays through the middles of all pixels, mm.

    Holes count as closed by a fan. NaN where the parts of a surface cannot be closed or oriented.

    Raises
    ------
    InputError
        A point source amidst the surface.
    """
    points, triangles, sign = _closed(surface)
    spans = _spans(beam._placed(points), triangles, sign, beam.size)
    column = ranges(spans.first, spans.counts)
    each = np.repeat(np.arange(len(spans.row)), spans.counts)
    (left, low), (right, high) = spans.left[each].T, spans.right[each].T
    share = np.clip((column + 0.5 - left) / np.where(right == left, 1.0, right - left), 0.0, 1.0)
    number = spans.row[each] * beam.size[1] + column
    depth = beam._depths(low + share * (high - low), number)
    signs, count = spans.sign[each], beam.size[0] * beam.size[1]
    lengths = np.bincount(number, signs * depth, count)
    is_left_open = np.bincount(number, signs, count) != 0
    return np.where(is_left_open, np.nan, lengths).reshape(beam.size)


def _closed(surface: Surface) -> tuple[Points, Triangles, Floats]:
    """Points and triangles of a surface with closed holes, and which side of each is outside."""
    known = surface.closing
    points = np.vstack([surface.points, known.middles(surface.points)])
    triangles = np.vstack([known.triangles, known.fans(len(surface.points))])
    part = np.r_[known.part, known.hole_part[known.hole]]
    corners = points[triangles] - points[triangles[0, 0]]
    volumes = np.einsum("mi,mi->m", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return points, triangles, np.sign(np.bincount(part, volumes))[part]


def _spans(placed: Floats, triangles: Triangles, sign: Floats, size: tuple[int, int]) -> _Spans:
    """The pieces of rows that triangles cover.

    A row belongs to an edge from its upper end, included, to its lower one, excluded; places on
    edges are worked out from the upper end on, whichever triangle asks.
    """
    order = np.argsort(placed[triangles, 1], axis=1, kind="stable")
    sign = sign * np.where((order[:, 1] - order[:, 0]) % 3 == 1, 1.0, -1.0)
    triangles = np.take_along_axis(triangles, order, axis=1)
    rows = np.ceil(placed[triangles, 1] - 0.5)
    first, last = np.clip(rows[:, [0, 2]], 0, size[0]).astype(np.int64).T
    each = np.repeat(np.arange(len(triangles)), last - first)
    row = ranges(first, last - first)
    top, middle, bottom = triangles[each].T
    is_upper = row < rows[each, 1]
    long = _on_edge(placed[top], placed[bottom], row)
    short = _on_edge(
        placed[np.where(is_upper, top, middle)], placed[np.where(is_upper, middle, bottom)], row
    )
    ends = np.ceil(np.stack([long[:, 0], short[:, 0]]) - 0.5)
    begin, stop = np.clip([ends.min(axis=0), ends.max(axis=0)], 0, size[1]).astype(np.int64)
    kept = np.flatnonzero(stop > begin)
    turn = np.where(short[kept, 0] > long[kept, 0], -1.0, 1.0)
    return _Spans(
        row[kept],
        begin[kept],
        (stop - begin)[kept],
        long[kept],
        short[kept],
        sign[each[kept]] * turn,
    )


def _on_edge(upper: Floats, lower: Floats, row: Indices) -> Floats:
    """Column and depth (k, 2) at which edges cross the middles of rows."""
    share = (row + 0.5 - upper[:, 1]) / (lower[:, 1] - upper[:, 1])
    ends = upper[:, [0, 2]], lower[:, [0, 2]]
    return np.asarray(ends[0] + share[:, None] * (ends[1] - ends[0]))
