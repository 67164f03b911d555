"""VTP, VTK's XML polydata, read strictly: whole and consistent, or a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, in_short
from .stored_polydata import (
    CELL_KINDS,
    ArrayGroup,
    Damage,
    Kind,
    StoredArray,
    StoredPolydata,
    check_cells,
)
from .vtp_arrays import encoding_of, read_array, whole_number
from .vtp_bytes import Encoding
from .vtp_markup import Element, parsed_markup

_Cells = tuple[NDArray[np.int64], NDArray[np.int64]]


_NO_POINTS = StoredArray("Points", Kind("vtkFloatArray", "f4"), np.zeros((0, 3), np.float32), 3)


class _Piece(NamedTuple):
    points: StoredArray | None
    cells: dict[str, _Cells]
    point_data: ArrayGroup
    cell_data: ArrayGroup

    @property
    def point_count(self) -> int:
        return 0 if self.points is None else len(self.points.values)

    @property
    def cell_counts(self) -> list[int]:
        return [len(self.cells[kind][0]) - 1 for kind in CELL_KINDS]


def decode_vtp(data: bytes, name: str) -> StoredPolydata:
    """Read VTP: text, inline or appended, every compressor of VTK, one piece or several.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        Not VTP, other data than polydata, cut short, damaged, or with steps of time.
    """
    markup = parsed_markup(data, name, "VTP")
    if markup.kind != "PolyData":
        raise InputError(f"{name}: expected PolyData, got {markup.kind}; extract its surface.")
    try:
        return _Reader(encoding_of(markup, data)).polydata(markup.root)
    except Damage as error:
        raise InputError(f"{name}: {error}; the file is damaged, write it again.") from error


@dataclass(frozen=True)
class _Reader:
    encoding: Encoding

    def polydata(self, root: Element) -> StoredPolydata:
        bodies = list(root.all_of("PolyData"))
        if len(bodies) != 1 or "TimeValues" in bodies[0].attributes:
            raise Damage("expected one PolyData without steps of time, got others")
        pieces = [self._piece(element) for element in bodies[0].all_of("Piece")]
        fields = [self._group(element, None) for element in bodies[0].all_of("FieldData")]
        if len(fields) > 1 or not pieces:
            raise Damage(f"expected a piece and one FieldData, got {len(pieces)} and {len(fields)}")
        return _joined(pieces, fields[0] if fields else ArrayGroup())

    def _piece(self, piece: Element) -> _Piece:
        counts = piece.attributes
        point_count = whole_number(counts, "NumberOfPoints", 0)
        points = self._points(_only(piece, "Points"), point_count)
        cells = {
            kind: self._cells(
                _only(piece, kind), whole_number(counts, f"NumberOf{kind}", 0), point_count
            )
            for kind in CELL_KINDS
        }
        cell_count = sum(len(offsets) - 1 for offsets, _ in cells.values())
        return _Piece(
            points,
            cells,
            self._group(_only(piece, "PointData"), point_count),
            self._group(_only(piece, "CellData"), cell_count),
        )

    def _points(self, section: Element | None, count: int) -> StoredArray | None:
        arrays = list(section.all_of("DataArray")) if section else []
        if count == 0 and not arrays:
            return None
        if len(arrays) != 1:
            raise Damage(f"expected one array of points, got {len(arrays)}")
        points = self._array(arrays[0], count)
        if points.components != 3 or points.kind.is_text or points.kind.is_bit:
            raise Damage("expected points of three numbers, got others")
        return points

    def _cells(self, section: Element | None, count: int, point_count: int) -> _Cells:
        if count == 0:
            return np.zeros(1, np.int64), np.zeros(0, np.int64)
        found = {
            part.attributes.get("Name"): part for part in (section.children if section else ())
        }
        if not {"offsets", "connectivity"} <= set(found):
            raise Damage(f"expected offsets and connectivity of {count} cells, got none")
        ends = self._integers(found["offsets"], count)
        offsets = np.concatenate([[0], ends])
        corners = self._integers(found["connectivity"], None)
        check_cells(offsets, corners, point_count)
        return offsets, corners

    def _integers(self, element: Element, count: int | None) -> NDArray[np.int64]:
        array = self._array(element, count)
        if array.kind.is_text or array.kind.is_bit or array.components != 1:
            raise Damage(f"its array {array.name}: expected integers, got another type")
        values: Any = array.values
        if values.dtype.kind not in "iu" or (values.size and values.max() > np.iinfo(np.int64).max):
            raise Damage(f"its array {array.name}: expected integers, got {values.dtype}")
        return values.ravel().astype(np.int64, copy=False)

    def _group(self, section: Element | None, count: int | None) -> ArrayGroup:
        if section is None:
            return ArrayGroup()
        arrays = [self._array(element, count) for element in section.children]
        names = [array.name for array in arrays if array.name is not None]
        if len(set(names)) < len(names):
            raise Damage(f"expected arrays of different names in {section.tag}, got one twice")
        return ArrayGroup(arrays, {role: words for role, words in section.attributes.items()})

    def _array(self, element: Element, count: int | None) -> StoredArray:
        try:
            return read_array(element, count, self.encoding)
        except Damage as error:
            label = element.attributes.get("Name", "without a name")
            raise Damage(f"its array {in_short(label)[1:-1]}: {error}") from error


def _only(piece: Element, tag: str) -> Element | None:
    found = list(piece.all_of(tag))
    if len(found) > 1:
        raise Damage(f"expected one element {tag}, got {len(found)}")
    return found[0] if found else None


def _joined(pieces: Sequence[_Piece], fields: ArrayGroup) -> StoredPolydata:
    """One polydata of all pieces: of each kind of cells, those of the first piece come first."""
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


def _joined_cells(parts: Sequence[_Cells], first: Sequence[int]) -> _Cells:
    starts = np.cumsum([0, *(len(corners) for _, corners in parts)])
    offsets = [offsets[1:] + start for (offsets, _), start in zip(parts, starts[:-1], strict=True)]
    corners = [corners + start for (_, corners), start in zip(parts, first, strict=True)]
    return np.concatenate([np.zeros(1, np.int64), *offsets]), np.concatenate(corners)


def _order_of_cells(counts: list[list[int]]) -> NDArray[np.int64] | None:
    """Which cell of all pieces, put one behind the other, comes when: kind by kind."""
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
