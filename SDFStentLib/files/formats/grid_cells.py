"""Cells of an unstructured grid as cells of polydata if it is a surface; else what it is instead.

Source: VTK's file formats, its numbers of cell types.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError
from .stored_polydata import CELL_KINDS, ArrayGroup, Damage, StoredArray

PIXEL = 8
"""Type of a quad whose corners are stored row by row, not round it."""

_PLAIN = {1: "Verts", 2: "Verts", 3: "Lines", 4: "Lines", 5: "Polys", 6: "Strips", 7: "Polys",
          PIXEL: "Polys", 9: "Polys"}  # fmt: skip
_SIZES = {1: 1, 3: 2, 5: 3, PIXEL: 4, 9: 4}
"""Numbers of corners of cells that always have as many."""

_VOLUMES = {10: "tetrahedra", 11: "voxels", 12: "hexahedra", 13: "wedges", 14: "pyramids",
            15: "prisms", 16: "prisms", 41: "points in convex hulls", 42: "polyhedra",
            24: "quadratic tetrahedra", 25: "quadratic hexahedra", 26: "quadratic wedges",
            27: "quadratic pyramids", 29: "quadratic hexahedra", 71: "tetrahedra of higher order",
            72: "hexahedra of higher order"}  # fmt: skip
_HIGHER = {21: "lines", 22: "triangles", 23: "quads", 28: "quads", 30: "quads", 34: "triangles",
           36: "polygons", 68: "lines", 69: "triangles", 70: "quads"}  # fmt: skip


class GridCells(NamedTuple):
    """Cells by the names of `CELL_KINDS`, and the cell of the grid that each of them is."""

    cells: dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]
    order: NDArray[np.int64]


def polydata_cells(
    types: NDArray[Any], offsets: NDArray[np.int64], corners: NDArray[np.int64], name: str
) -> GridCells:
    """The points, lines and polygons of a grid.

    Parameters
    ----------
    types : (m,) array of integers
        VTK's numbers of kinds of cells.
    offsets, corners : (m + 1,) and (k,) arrays
        As in `Cells` of `polydata`; checked already.
    name : str
        Name of the file in messages.

    Raises
    ------
    InputError
        Cells with a volume, or curved ones.
    Damage
        Other cells, or a number of corners that does not fit its kind.
    """
    _check_kinds(types, name)
    sizes = np.diff(offsets)
    for number, size in _SIZES.items():
        wrong = sizes[(types == number) & (sizes != size)]
        if len(wrong):
            raise Damage(f"expected {size} corners of a cell of type {number}, got {wrong[0]}")
    corners = corners.copy()
    pixels = offsets[:-1][types == PIXEL]
    corners[pixels + 2], corners[pixels + 3] = corners[pixels + 3], corners[pixels + 2]
    owner = np.repeat(np.arange(len(types)), sizes)
    cells, order = {}, []
    for kind in CELL_KINDS:
        is_own = np.isin(types, [number for number, own in _PLAIN.items() if own == kind])
        own_offsets = np.concatenate([[0], np.cumsum(sizes[is_own])]).astype(np.int64)
        cells[kind] = own_offsets, corners[is_own[owner]]
        order.append(np.flatnonzero(is_own))
    return GridCells(cells, np.concatenate(order))


def reordered(group: ArrayGroup, order: NDArray[np.int64]) -> ArrayGroup:
    """The arrays of cells in another order of these."""
    return replace(group, arrays=[_reordered(array, order) for array in group.arrays])


def _reordered(array: StoredArray, order: NDArray[np.int64]) -> StoredArray:
    if isinstance(array.values, list):
        rows = array.components * order[:, None] + np.arange(array.components)
        return replace(array, values=[array.values[row] for row in rows.ravel().tolist()])
    return replace(array, values=array.values[order])


def _check_kinds(types: NDArray[Any], name: str) -> None:
    kinds, counts = (found.tolist() for found in np.unique(types, return_counts=True))
    # Cells with a volume say most, lines least: VTK's numbers rise with the dimension.
    found = dict(zip(reversed(kinds), reversed(counts), strict=True))
    volumes = [f"{found[kind]} {_VOLUMES[kind]}" for kind in found if kind in _VOLUMES]
    if volumes:
        raise InputError(
            f"{name}: expected a surface of triangles, got a volume mesh of "
            f"{' and '.join(volumes)}; extract its surface (ParaView: Extract Surface; pyvista: "
            "extract_surface) and save that as .vtp."
        )
    curved = [f"{found[kind]} {_HIGHER[kind]}" for kind in found if kind in _HIGHER]
    if curved:
        raise InputError(
            f"{name}: expected straight cells, got {' and '.join(curved)} of higher order; save "
            "the mesh in first order."
        )
    others = [kind for kind in kinds if kind not in _PLAIN]
    if others:
        raise Damage(f"expected cells of a surface, got {found[others[0]]} of type {others[0]}")
