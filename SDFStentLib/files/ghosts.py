"""Cells that VTK marks as copies of another piece, or as hidden, and that are no
part of a surface."""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData

from ..validation import Flags, Indices, Triangles

KINDS = "vtkGhostType"
"""Name of the array of bits at cells and points."""

LEVELS = "vtkGhostLevels"
"""Name of the array of VTK 6 and before, in which a number above 0 marks a ghost."""

_CELL = vtkDataSetAttributes.DUPLICATECELL | vtkDataSetAttributes.HIDDENCELL
_CELL |= vtkDataSetAttributes.REFINEDCELL
_POINT = vtkDataSetAttributes.HIDDENPOINT  # a duplicate point is a copy, its cells count


def ghosts_of_polydata(polydata: vtkPolyData, triangles: Triangles) -> Flags | None:
    """Whether each cell (m,) of polydata of triangles is a ghost; None where none is.

    Ghosts are cells that VTK neither draws nor counts: duplicate, hidden, refined by others, or
    with a hidden point.
    """
    cells, points = polydata.GetCellData(), polydata.GetPointData()
    is_ghost = np.zeros(len(triangles), dtype=bool)
    for found, mask in ((_values(cells, KINDS), _CELL), (_values(cells, LEVELS), ~0)):
        if found is not None and len(found) == len(triangles):
            is_ghost |= (found & mask) != 0
    hidden = _values(points, KINDS)
    if hidden is not None and len(hidden) == polydata.GetNumberOfPoints():
        is_ghost |= ((hidden & _POINT) != 0)[triangles].any(axis=1)
    return is_ghost if is_ghost.any() else None


def _values(data: vtkDataSetAttributes, name: str) -> Indices | None:
    array = data.GetArray(name)
    if array is None or array.GetNumberOfComponents() != 1:
        return None
    return np.asarray(vtk_to_numpy(array)).astype(np.int64)
