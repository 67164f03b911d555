"""VTU, VTK's XML of volume meshes, read strictly: tetrahedra in one piece, or refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...validation import Floats, Indices, InputError, Points
from .stored_polydata import Damage, check_cells
from .vtp_arrays import encoding_of, read_array, whole_number
from .vtp_bytes import Encoding
from .vtp_markup import Element, parsed_markup

TETRAHEDRON = 10
"""VTK's type number of a tetrahedron."""


class VolumeArrays(NamedTuple):
    """A mesh of tetrahedra and the arrays at its points."""

    points: Points
    """(n, 3) points in the unit of the file."""
    tetrahedra: Indices
    """(t, 4) corners."""
    arrays: dict[str, Floats]
    """Arrays (n,) or (n, k) of numbers, by name."""


def decode_vtu(data: bytes, name: str) -> VolumeArrays:
    """Decode VTU; `name` is what to call it in messages.

    Raises
    ------
    InputError
        Not VTU, cut short, damaged, in several pieces, or with cells other than tetrahedra.
    """
    markup = parsed_markup(data, name, "VTU")
    if markup.kind != "UnstructuredGrid":
        raise InputError(f"{name}: expected UnstructuredGrid, got {markup.kind}.")
    try:
        encoding = encoding_of(markup, data)
        pieces = [
            piece
            for body in markup.root.all_of("UnstructuredGrid")
            for piece in body.all_of("Piece")
        ]
        if len(pieces) != 1:
            raise Damage(f"expected one piece, got {len(pieces)}")
        return _piece(pieces[0], encoding)
    except Damage as error:
        raise InputError(f"{name}: {error}; write it again.") from error


def _piece(piece: Element, encoding: Encoding) -> VolumeArrays:
    count = whole_number(piece.attributes, "NumberOfPoints", 0)
    cells = whole_number(piece.attributes, "NumberOfCells", 0)
    points = next(iter(_arrays(piece, "Points", count, encoding).values()), None)
    if points is None or points.shape != (count, 3):
        raise Damage("expected points of three numbers, got none")
    parts = _arrays(piece, "Cells", None, encoding)
    corners = parts.get("connectivity", np.zeros(0)).ravel().astype(np.int64)
    kinds = parts.get("types", np.zeros(0)).ravel()
    if len(kinds) != cells or len(corners) != 4 * cells or (kinds != TETRAHEDRON).any():
        raise Damage("expected tetrahedra, got other cells")
    check_cells(4 * np.arange(cells + 1), corners, count)
    known = _arrays(piece, "PointData", count, encoding)
    return VolumeArrays(points.astype(np.float64), corners.reshape(-1, 4), known)


def _arrays(piece: Element, tag: str, count: int | None, encoding: Encoding) -> dict[str, Floats]:
    """The numeric arrays in a section, by name."""
    found = {}
    for section in piece.all_of(tag):
        for element in section.all_of("DataArray"):
            array = read_array(element, count, encoding)
            if array.kind.is_text or array.kind.is_bit:
                continue
            values = np.asarray(array.values)
            found[str(array.name)] = values[:, 0] if values.shape[1:] == (1,) else values
    return found
