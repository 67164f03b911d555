"""Pieces of VTK's XML files put together, as VTK does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .stored_polydata import CELL_KINDS, ArrayGroup, Damage, Kind, StoredArray, StoredPolydata

Cells = tuple[NDArray[np.int64], NDArray[np.int64]]

_NO_POINTS = StoredArray("Points", Kind("vtkFloatArray", "f4"), np.zeros((0, 3), np.float32), 3)


class StoredPiece(NamedTuple):
    """A part of polydata, with points and cells of its own."""

    points: StoredArray | None
    cells: dict[str, Cells]
    point_data: ArrayGroup
    cell_data: ArrayGroup

    @property
    def point_count(self) -> int:
        """Number of points of the piece."""
        return 0 if self.points is None else len(self.points.values)

    @property
    def cell_counts(self) -> list[int]:
        """Number of cells of each of `CELL_KINDS`."""
        return [len(self.cells[kind][0]) - 1 for kind in CELL_KINDS]


def joined(pieces: Sequence[StoredPiece], fields: ArrayGroup) -> StoredPolydata:
    """A polydata of all pieces; of each kind of cells, those of the first piece come first."""
    first = [sum(piece.point_count for piece in pieces[:number]) for number in range(len(pieces))]
    with_points = [piece for piece in pieces if piece.point_count] or [pieces[0]]
    with_cells = [piece for piece in pieces if sum(piece.cell_counts)] or [pieces[0]]
    points = [piece.points for piece in with_points if piece.points is not None] or [_NO_POINTS]
    cells = {
        kind: _joined_cells([piece.cells[kind] for piece in pieces], first) for kind in CELL_KINDS
    }
    point_data = _joined_groups([piece.point_data for piece in with_points], None)
    cell_data = _joined_groups(
        [piece.cell_data for piece in with_cells],
        _order_of_cells([p.cell_counts for p in with_cells]),
    )
    return StoredPolydata(_joined_arrays(points), cells, point_data, cell_data, fields)


def _joined_cells(parts: Sequence[Cells], first: Sequence[int]) -> Cells:
    starts = np.cumsum([0, *(len(corners) for _, corners in parts)])
    offsets = [offsets[1:] + start for (offsets, _), start in zip(parts, starts[:-1], strict=True)]
    corners = [corners + start for (_, corners), start in zip(parts, first, strict=True)]
    return np.concatenate([np.zeros(1, np.int64), *offsets]), np.concatenate(corners)


def _order_of_cells(counts: list[list[int]]) -> NDArray[np.int64] | None:
    """Order of the cells of all pieces, put one behind the other: kind by kind."""
    if len(counts) == 1:
        return None
    kind = np.concatenate([np.repeat(np.arange(len(CELL_KINDS)), count) for count in counts])
    return np.argsort(kind, kind="stable")


def _joined_groups(groups: Sequence[ArrayGroup], order: NDArray[np.int64] | None) -> ArrayGroup:
    if len(groups) == 1:
        return groups[0]
    names = [[array.name for array in group.arrays] for group in groups]
    if any(other != names[0] for other in names):
        raise Damage("expected the same arrays in all of its pieces, got others")
    columns = zip(*(group.arrays for group in groups), strict=True)
    return replace(groups[0], arrays=[_joined_arrays(list(column), order) for column in columns])


def _joined_arrays(
    parts: Sequence[StoredArray], order: NDArray[np.int64] | None = None
) -> StoredArray:
    if len(parts) == 1:
        return parts[0]
    one = parts[0]
    if any((part.kind, part.components) != (one.kind, one.components) for part in parts):
        raise Damage(f"its array {one.name}: expected the same type in all pieces, got others")
    if one.kind.is_text:
        rows = [value for part in parts for value in part.values]
        numbers = range(len(rows)) if order is None else _flat(order, one.components)
        return replace(one, values=[rows[number] for number in numbers])
    values = np.concatenate([np.asarray(part.values) for part in parts])
    return replace(one, values=values if order is None else values[order])


def _flat(order: NDArray[np.int64], components: int) -> list[int]:
    rows = components * order[:, None] + np.arange(components)
    return rows.ravel().tolist()
