"""Normals that follow a surface when some of its points move."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData

from ..geometry import dot, face_normals, vertex_normals
from ..validation import Points, Triangles

_NAMES = ("normals", "normals_", "pointnormals", "cellnormals", "cell_normals", "point_normals")
_UNIT_LENGTH_TOLERANCE = 0.01  # of the usual length: normals may be stored with few digits


def refresh_normals(
    polydata: vtkPolyData, old_points: Points, new_points: Points, triangles: Triangles
) -> None:
    """Recompute, in place, the normals arrays of points and cells where the surface changed.

    Normals arrays are the active normals and three-component arrays of unit length that are
    called normals. Data type and side are those of the stored normals: a stored normal that
    looked against the winding of its triangles still does. Rows that no moved triangle touches
    keep their bits; rows without a normal (no area around) keep what they had.

    Parameters
    ----------
    polydata : vtkPolyData
        Its arrays are modified. Cell i is triangle i.
    old_points, new_points : (n, 3) arrays
        Before and after, in any one unit.
    triangles : (m, 3) array
    """
    point_normals = _normals_arrays(polydata.GetPointData())
    cell_normals = _normals_arrays(polydata.GetCellData())
    moved = (old_points != new_points).any(axis=1)
    if not (point_normals or cell_normals) or not moved.any():
        return
    changed = np.flatnonzero(moved[triangles].any(axis=1))
    if cell_normals and len(changed):
        before = face_normals(old_points, triangles[changed])
        after = face_normals(new_points, triangles[changed])
        for rows in cell_normals:
            _turn(rows, changed, before, after)
    if point_normals and len(changed):
        touched = np.unique(triangles[changed])
        is_touched = np.zeros(len(old_points), dtype=bool)
        is_touched[touched] = True
        around = triangles[is_touched[triangles].any(axis=1)]
        before = vertex_normals(old_points, around)[touched]
        after = vertex_normals(new_points, around)[touched]
        for rows in point_normals:
            _turn(rows, touched, before, after)


def _normals_arrays(data: vtkDataSetAttributes) -> list[NDArray[Any]]:
    """Views on the arrays that hold normals."""
    active = data.GetNormals()
    found = []
    for index in range(data.GetNumberOfArrays()):
        array = data.GetArray(index)  # None for text
        if array is None or array.GetNumberOfComponents() != 3 or not array.GetNumberOfTuples():
            continue
        rows = vtk_to_numpy(array)
        if rows.dtype.kind != "f":
            continue
        is_named = (array.GetName() or "").lower() in _NAMES and _has_unit_length(rows)
        if is_named or (active is not None and array.GetName() == active.GetName()):
            found.append(rows)
    return found


def _has_unit_length(rows: NDArray[Any]) -> bool:
    usual = np.median(np.linalg.norm(rows.astype(np.float64), axis=1))
    return bool(abs(usual - 1) < _UNIT_LENGTH_TOLERANCE)


def _turn(rows: NDArray[Any], indices: NDArray[np.int64], before: Points, after: Points) -> None:
    stored = rows[indices].astype(np.float64)
    side = np.where(dot(stored, before) < 0, -1.0, 1.0)
    has_normal = after.any(axis=1)
    rows[indices[has_normal]] = (side[:, None] * after)[has_normal]
