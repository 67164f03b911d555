"""Legacy VTK polydata and grids that are surfaces, versions 1 to 5, text or binary, read strictly.

Source: VTK's file formats, "Simple legacy formats". A file is a row of blocks; each announces what
follows it, and all of that must be there.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, in_short
from ..recognized import in_words
from .grid_cells import polydata_cells, reordered
from .legacy_cursor import LegacyCursor
from .stored_polydata import (
    ARRAYS_WITH_ONE_MORE,
    CELL_KINDS,
    ArrayGroup,
    Damage,
    Kind,
    StoredArray,
    StoredPolydata,
    cells_of_list,
    check_cells,
)

_Cells = tuple[NDArray[np.int64], NDArray[np.int64]]

_BYTES, _FLOAT = Kind("vtkUnsignedCharArray", "u1"), Kind("vtkFloatArray", "f4")
_KINDS = {
    "bit": Kind("vtkBitArray", "u1"), "string": Kind("vtkStringArray", "u1"),
    "utf8_string": Kind("vtkStringArray", "u1"),
    "char": Kind("vtkCharArray", "i1"), "signed_char": Kind("vtkSignedCharArray", "i1"),
    "unsigned_char": _BYTES,
    "short": Kind("vtkShortArray", "i2"), "unsigned_short": Kind("vtkUnsignedShortArray", "u2"),
    "int": Kind("vtkIntArray", "i4"), "unsigned_int": Kind("vtkUnsignedIntArray", "u4"),
    "long": Kind("vtkTypeInt64Array", "i8"), "unsigned_long": Kind("vtkTypeUInt64Array", "u8"),
    "long_long": Kind("vtkTypeInt64Array", "i8"),
    "unsigned_long_long": Kind("vtkTypeUInt64Array", "u8"),
    "vtktypeint64": Kind("vtkTypeInt64Array", "i8"),
    "vtktypeuint64": Kind("vtkTypeUInt64Array", "u8"),
    "vtkidtype": Kind("vtkIdTypeArray", "i4"),  # of 32 bits in these files
    "float": _FLOAT, "double": Kind("vtkDoubleArray", "f8"),
}  # fmt: skip

_CELL_WORDS = {
    "vertices": "Verts", "lines": "Lines", "polygons": "Polys", "triangle_strips": "Strips",
}  # fmt: skip


_GRID = "Cells"
_CELL_WORDS_OF = {"POLYDATA": _CELL_WORDS, "UNSTRUCTURED_GRID": {"cells": _GRID}}
_NOTHING = np.zeros(1, np.int64), np.zeros(0, np.int64)


class _Role(NamedTuple):
    name: str
    components: int | None  # None: the file says


_ROLES = {
    "vectors": _Role("Vectors", 3), "normals": _Role("Normals", 3),
    "tensors": _Role("Tensors", 9), "tensors6": _Role("Tensors", 6),
    "texture_coordinates": _Role("TCoords", None), "global_ids": _Role("GlobalIds", 1),
    "pedigree_ids": _Role("PedigreeIds", 1), "edge_flags": _Role("EdgeFlag", 1),
    "tangents": _Role("Tangents", 3), "rational_weights": _Role("RationalWeights", 1),
    "higher_order_degrees": _Role("HigherOrderDegrees", 3), "process_ids": _Role("ProcessIds", 1),
}  # fmt: skip
_MOST_COMPONENTS = 10_000


def decode_legacy(data: bytes, name: str) -> StoredPolydata:
    """Decode legacy VTK polydata, or an unstructured grid of such cells, with every array.

    Parameters
    ----------
    data : bytes
        The whole file.
    name : str
        Name of the file in messages.

    Raises
    ------
    InputError
        Not such a file, data other than polydata, cut short, damaged, or with an unknown block.
    """
    lines = data.split(b"\n", 3)
    if not data.startswith(b"# vtk DataFile"):
        raise InputError(f"{name}: expected a legacy VTK file, got {in_words(data)}.")
    coding = lines[2].strip().upper() if len(lines) > 3 else b""
    if coding not in (b"ASCII", b"BINARY"):
        found = in_short(coding.decode("latin-1"))
        raise InputError(
            f"{name}: expected ASCII or BINARY in its third line, got {found}; it is cut short "
            "or damaged, write it again."
        )
    start = len(data) - len(lines[3])
    try:
        return _LegacyReader(LegacyCursor(data, start, is_text=coding == b"ASCII"), name).polydata()
    except Damage as error:
        raise InputError(f"{name}: {error}; the file is damaged, write it again.") from error


class _LegacyReader:
    """Reads one block of a file after the other."""

    def __init__(self, cursor: LegacyCursor, name: str) -> None:
        self._cursor, self._name = cursor, name
        self._points: StoredArray | None = None
        self._cell_words: dict[str, str] = {}
        self._types = np.zeros(0, np.int64)  # of the cells of a grid
        self._cells: dict[str, _Cells] = {}
        self._groups = {"point": ArrayGroup(), "cell": ArrayGroup(), "field": ArrayGroup()}
        self._group, self._rows = self._groups["field"], 0
        self._row_counts: dict[str, list[int]] = {"point": [], "cell": []}
        self._shown = ("", "")  # the last scalars, and the name of their lookup table

    def polydata(self) -> StoredPolydata:
        self._check_data_set()
        # Ends: every word moves on in the data, and there is none after its end.
        while word := self._cursor.word():
            self._block(word.lower())
        if self._points is None:
            raise Damage("expected POINTS, found none")
        self._check_corners(self._cells)
        self._check_rows("point", len(self._points.values))
        self._check_rows("cell", sum(len(offsets) - 1 for offsets, _ in self._cells.values()))
        points, cells, fields = self._groups.values()
        if _GRID in self._cell_words.values():
            offsets, corners = self._cells.get(_GRID, _NOTHING)
            if len(self._types) != len(offsets) - 1:
                raise Damage(f"expected {len(offsets) - 1} types, got {len(self._types)}")
            found = polydata_cells(self._types, offsets, corners, self._name)
            cells = reordered(cells, found.order)
            return StoredPolydata(self._points, found.cells, points, cells, fields)
        kinds = {kind: self._cells.get(kind, _NOTHING) for kind in CELL_KINDS}
        return StoredPolydata(self._points, kinds, points, cells, fields)

    def _check_rows(self, key: str, count: int) -> None:
        for announced in self._row_counts[key]:
            if announced != count:
                raise Damage(f"expected data of {count} {key}s, got {announced}")
        for array in self._groups[key].arrays:
            if len(array.values) != count * (array.components if array.kind.is_text else 1):
                raise Damage(f"expected {count} rows in its {key} array {array.name}, got others")

    def _check_data_set(self) -> None:
        word, kind = self._cursor.word().upper(), ""
        if word == "DATASET":
            kind = self._cursor.word().upper()
        if kind not in _CELL_WORDS_OF:
            raise InputError(
                f"{self._name}: expected POLYDATA, got {in_short(kind)[1:-1] or 'no data set'}; "
                "extract its surface."
            )
        self._cell_words = _CELL_WORDS_OF[kind]

    def _check_corners(self, cells: dict[str, _Cells]) -> None:
        count = len(self._points.values) if self._points else 0
        for offsets, corners in cells.values():
            check_cells(offsets, corners, count)

    def _block(self, word: str) -> None:
        if word == "points":
            self._read_points()
        elif word in self._cell_words:
            self._read_cells(self._cell_words[word])
        elif word == "cell_types" and _GRID in self._cell_words.values():
            self._types = self._cursor.numbers(self._cursor.count(), "i4").astype(np.int64)
        elif word in ("point_data", "cell_data"):
            self._group, self._rows = self._groups[word[:-5]], self._cursor.count()
            self._row_counts[word[:-5]].append(self._rows)
        elif word == "field":
            self._read_fields()
        elif word == "metadata":
            self._cursor.metadata(0)
        elif self._group is self._groups["field"]:
            raise Damage(f"expected POINTS, cells or data, got {in_short(word)}")
        else:
            self._read_attribute(word)

    def _read_points(self) -> None:
        count = self._cursor.count()
        if self._points is not None:
            raise Damage("expected POINTS once, got them twice")
        points = self._array("Points", count, 3, self._kind())
        if points.kind.is_text or points.kind.is_bit:
            raise Damage("expected points of numbers, got others")
        self._points = points

    def _read_cells(self, kind: str) -> None:
        count, size = self._cursor.count(), self._cursor.count()
        if kind in self._cells:
            raise Damage(f"expected one block of {kind}, got two")
        if self._cursor.next_is("OFFSETS"):
            offsets = self._listed("OFFSETS", count)
            corners = self._listed("CONNECTIVITY", size)
            self._cells[kind] = (offsets if len(offsets) else np.zeros(1, np.int64)), corners
        elif count or size:
            listed = self._cursor.numbers(size, "i4").astype(np.int64)
            self._cells[kind] = cells_of_list(listed, count)

    def _listed(self, word: str, count: int) -> NDArray[np.int64]:
        found = self._cursor.word().upper()
        kind = self._kind()
        if found != word or kind.dtype not in ("i4", "i8"):
            raise Damage(f"expected {word} of integers, got {in_short(found)}")
        return self._cursor.numbers(count, kind.dtype).astype(np.int64)

    def _read_fields(self) -> None:
        self._cursor.word()  # the name of all of them, which VTK does not keep either
        for _ in range(self._cursor.count()):
            name = self._cursor.name()
            if name == "NULL_ARRAY":
                continue
            components, rows = self._cursor.count(), self._cursor.count()
            array = self._array(name, rows, components, self._kind())
            is_longer = self._group is self._groups["point"] and rows == self._rows + 1
            self._add(array.without_last() if is_longer and name in ARRAYS_WITH_ONE_MORE else array)

    def _read_attribute(self, word: str) -> None:
        if word == "lookup_table":
            self._read_table()
        elif word == "scalars":
            self._read_scalars()
        elif word == "color_scalars":
            name, components = self._cursor.name(), self._cursor.count()
            colors = self._cursor.colors(self._rows * components).reshape(-1, max(components, 1))
            self._add(StoredArray(name, _BYTES, colors, components), "Scalars")
        elif word in _ROLES:
            role = _ROLES[word]
            name = self._cursor.name()
            components = self._cursor.count() if role.components is None else role.components
            self._add(self._array(name, self._rows, components, self._kind()), role.name)
        else:
            raise Damage(f"expected a block of data, got {in_short(word)}")

    def _read_scalars(self) -> None:
        name, kind, components = self._cursor.name(), self._kind(), 1
        if not self._cursor.next_is("LOOKUP_TABLE"):
            components = self._cursor.count()
        if self._cursor.word().upper() != "LOOKUP_TABLE":
            raise Damage(f"expected LOOKUP_TABLE after the scalars {name}, got none")
        self._shown = name, self._cursor.word()
        self._add(self._array(name, self._rows, components, kind), "Scalars")

    def _read_table(self) -> None:
        name, count = self._cursor.word(), self._cursor.count()
        colors = self._cursor.colors(4 * count).reshape(-1, 4)
        if name == self._shown[1]:
            self._group.tables[self._shown[0]] = colors

    def _add(self, array: StoredArray, role: str = "") -> None:
        if any(array.name == other.name for other in self._group.arrays):
            raise Damage(f"expected arrays of different names, got {in_short(array.name)} twice")
        self._group.arrays.append(array)
        if role and array.name is not None:
            self._group.roles.setdefault(role, array.name)

    def _kind(self) -> Kind:
        word = self._cursor.word().lower()
        if word not in _KINDS:
            raise Damage(f"expected a type of numbers, got {in_short(word)}")
        return _KINDS[word]

    def _array(self, name: str, rows: int, components: int, kind: Kind) -> StoredArray:
        if not 1 <= components <= _MOST_COMPONENTS:
            raise Damage(f"expected 1 to {_MOST_COMPONENTS} components, got {components}")
        count = rows * components
        if kind.is_text:
            strings = self._cursor.strings(count)
            return StoredArray(name, kind, strings, components, self._component_names(components))
        numbers = (
            self._cursor.bits(count) if kind.is_bit else self._cursor.numbers(count, kind.dtype)
        )
        values: NDArray[Any] = numbers.reshape(rows, components)
        return StoredArray(name, kind, values, components, self._component_names(components))

    def _component_names(self, components: int) -> dict[int, str]:
        return self._cursor.metadata(components) if self._cursor.skip("METADATA") else {}


def title_of(data: bytes) -> str:
    """The second line of a legacy file."""
    lines = re.split(rb"\r?\n", data[:2000], maxsplit=2)
    return lines[1].decode("latin-1") if len(lines) > 1 else ""
