"""The parts of a model that polydata holds: SimVascular's ids of faces, and names of them."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..geometry import NamedFaces

ID_ARRAY = "ModelFaceID"
"""Cell array of integers, as SimVascular writes it."""

NAME_ARRAY = "ModelFaceNames"
"""Field array of texts, one for each named face: its id, a space and its name."""

_ID = re.compile("[0-9]{1,9}")


def faces_of_polydata(polydata: vtkPolyData) -> NamedFaces | None:
    """The faces of polydata of triangles; None where it does not tell them."""
    array = polydata.GetCellData().GetArray(ID_ARRAY)
    if array is None or array.GetNumberOfComponents() != 1:
        return None
    ids = np.asarray(vtk_to_numpy(array))
    if not np.issubdtype(ids.dtype, np.integer) or len(ids) != polydata.GetNumberOfPolys():
        return None
    return NamedFaces(ids, _names(polydata))


def set_face_names(polydata: vtkPolyData, names: Mapping[int, str]) -> None:
    """Add names to the faces of polydata, in place."""
    array = vtkStringArray()
    array.SetName(NAME_ARRAY)
    for number, name in names.items():
        array.InsertNextValue(f"{number} {name}")
    polydata.GetFieldData().AddArray(array)


def _names(polydata: vtkPolyData) -> dict[int, str]:
    array = polydata.GetFieldData().GetAbstractArray(NAME_ARRAY)
    if not isinstance(array, vtkStringArray):
        return {}
    entries = (array.GetValue(row).split() for row in range(array.GetNumberOfValues()))
    known = [words for words in entries if len(words) > 1 and _ID.fullmatch(words[0])]
    return {int(number): " ".join(name) for number, *name in known}
