"""VTP, and surfaces in VTU, VTK's XML, read strictly: whole and consistent, or refused."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...cautions import Caution
from ...validation import InputError, in_short
from ..content import FileContent
from .grid_cells import polydata_cells, reordered
from .stored_polydata import (
    ARRAYS_WITH_ONE_MORE,
    CELL_KINDS,
    ArrayGroup,
    Damage,
    StoredArray,
    StoredPolydata,
    check_cells,
    first_of_steps,
)
from .vtp_arrays import encoding_of, read_array, whole_number
from .vtp_bytes import Encoding
from .vtp_markup import Element, parsed_markup
from .vtp_pieces import Cells, StoredPiece, joined

POLYDATA, GRID = "PolyData", "UnstructuredGrid"
SUFFIXES = {POLYDATA: "VTP", GRID: "VTU"}
"""Names of the file formats by the data in them."""


def decode_vtp(data: bytes, name: str) -> StoredPolydata:
    """Decode VTP: text, inline or appended, every compressor of VTK, one piece or several.

    The first of several time steps is read, with a caution.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        Name of the file in messages.

    Raises
    ------
    InputError
        Not VTP, data other than polydata, cut short or damaged.
    """
    return _decoded([(data, name)], POLYDATA)


def decode_grid(data: bytes, name: str) -> StoredPolydata:
    """Decode VTU, an unstructured grid that is a surface; `InputError` for a volume."""
    return _decoded([(data, name)], GRID)


def decode_pieces(files: Iterable[FileContent], kind: str) -> StoredPolydata:
    """Decode several files of polydata or of grids (`kind`) as one; else as `decode_vtp`."""
    return _decoded([(file.data, str(file.path)) for file in files], kind)


def _decoded(files: list[tuple[bytes, str]], kind: str) -> StoredPolydata:
    pieces: list[StoredPiece] = []
    fields: list[ArrayGroup] = []
    cautions: list[Caution] = []
    name = files[0][1]
    try:
        for data, name in files:
            markup = parsed_markup(data, name, SUFFIXES[kind])
            if markup.kind != kind:
                raise InputError(
                    f"{name}: expected {kind}, got {markup.kind}; extract its surface."
                )
            read = _VtpReader(encoding_of(markup, data), name, kind).contents(markup.root)
            pieces += read.pieces
            fields.append(read.fields)
            cautions += read.cautions
        result = joined(pieces, fields[0])
        return replace(result, cautions=tuple(cautions))
    except Damage as error:
        raise InputError(f"{name}: {error}; the file is damaged, write it again.") from error


class _Contents(NamedTuple):
    pieces: list[StoredPiece]
    fields: ArrayGroup
    cautions: list[Caution]


@dataclass(frozen=True)
class _VtpReader:
    encoding: Encoding
    name: str
    kind: str

    def contents(self, root: Element) -> _Contents:
        bodies = list(root.all_of(self.kind))
        if len(bodies) != 1:
            raise Damage(f"expected one {self.kind}, got {len(bodies)}")
        times = bodies[0].attributes.get("TimeValues", "").split()
        if len(times) > 1:
            bodies = [_first_step(bodies[0], len(times))]
        pieces = [self._piece(element) for element in bodies[0].all_of("Piece")]
        fields = [self._group(element, None) for element in bodies[0].all_of("FieldData")]
        if len(fields) > 1 or not pieces:
            raise Damage(f"expected a piece and one FieldData, got {len(pieces)} and {len(fields)}")
        cautions = [first_of_steps(len(times), times[0], self.name)] if len(times) > 1 else []
        return _Contents(pieces, fields[0] if fields else ArrayGroup(), cautions)

    def _piece(self, piece: Element) -> StoredPiece:
        counts = piece.attributes
        point_count = whole_number(counts, "NumberOfPoints", 0)
        points = self._points(_only(piece, "Points"), point_count)
        point_data = self._group(_only(piece, "PointData"), point_count)
        if self.kind == GRID:
            return StoredPiece(points, *self._grid(piece, point_count, point_data))
        cells = {
            kind: self._cells(
                _only(piece, kind), whole_number(counts, f"NumberOf{kind}", 0), point_count
            )
            for kind in CELL_KINDS
        }
        cell_count = sum(len(offsets) - 1 for offsets, _ in cells.values())
        return StoredPiece(
            points,
            cells,
            point_data,
            self._group(_only(piece, "CellData"), cell_count),
        )

    def _grid(
        self, piece: Element, point_count: int, point_data: ArrayGroup
    ) -> tuple[dict[str, Cells], ArrayGroup, ArrayGroup]:
        """Cells, point data and cell data of a grid, in the order of polydata."""
        count = whole_number(piece.attributes, "NumberOfCells", 0)
        section = _only(piece, "Cells")
        offsets, corners = self._cells(section, count, point_count)
        types = [
            part
            for part in (section.children if section and count else ())
            if part.attributes.get("Name") == "types"
        ]
        if count and len(types) != 1:
            raise Damage(f"expected types of {count} cells, got none")
        kinds = self._integers(types[0], count) if types else np.zeros(0, np.int64)
        cells, order = polydata_cells(kinds, offsets, corners, self.name)
        cell_data = self._group(_only(piece, "CellData"), count)
        return cells, point_data, reordered(cell_data, order)

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

    def _cells(self, section: Element | None, count: int, point_count: int) -> Cells:
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
            try:
                return read_array(element, count, self.encoding)
            except Damage as damage:
                may_be_longer = element.attributes.get("Name") in ARRAYS_WITH_ONE_MORE
                if count is None or not may_be_longer:
                    raise
                # VMTK's network extraction has one radius more than points; VTK leaves it out.
                with suppress(Damage):
                    return read_array(element, count + 1, self.encoding).without_last()
                raise damage
        except Damage as error:
            label = element.attributes.get("Name", "without a name")
            raise Damage(f"its array {in_short(label)[1:-1]}: {error}") from error


def _only(piece: Element, tag: str) -> Element | None:
    found = list(piece.all_of(tag))
    if len(found) > 1:
        raise Damage(f"expected one element {tag}, got {len(found)}")
    return found[0] if found else None


def _first_step(body: Element, steps: int) -> Element:
    """The body with only what belongs to the first time step.

    VTK writes appended arrays, each with its step, into the same pieces. In a file without appended
    data it repeats the pieces for every step, and calls all of them step 0.
    """
    pieces = list(body.all_of("Piece"))
    arrays = [array for piece in pieces for section in piece.children for array in section.children]
    if all(_is_first(array) for array in arrays):
        kept = pieces[: len(pieces) // steps] if len(pieces) % steps == 0 else pieces
    else:
        kept = [_of_first_step(piece) for piece in pieces]
    others = [element for element in body.children if element.tag != "Piece"]
    return replace(body, children=[*others, *kept])


def _of_first_step(piece: Element) -> Element:
    sections = [
        replace(section, children=[array for array in section.children if _is_first(array)])
        for section in piece.children
    ]
    return replace(piece, children=sections)


def _is_first(array: Element) -> bool:
    steps = array.attributes.get("TimeStep", "").split()
    return not steps or "0" in steps
