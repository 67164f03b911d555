"""The parts of a model that polydata holds: SimVascular's face ids, and names of them."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..cautions import Caution
from ..geometry import NamedFaces, Surface
from ..validation import InputError
from .content import read_content
from .formats.mdl_faces import LARGEST, mdl_face_names

ID_ARRAY = "ModelFaceID"
"""Name of the cell array of integers that SimVascular writes."""

NAME_ARRAY = "ModelFaceNames"
"""Name of the field array with a text for each named face: its id, a space and its name."""

_ID = re.compile("[0-9]{1,9}")


MODEL_SUFFIX = ".mdl"
"""Suffix of the SimVascular model that belongs to a surface of the same name."""


def names_beside(path: Path) -> tuple[dict[int, str], tuple[Caution, ...]]:
    """Names of faces from the model beside a surface, or a caution why there are none.

    A model that cannot be read is no reason to refuse the surface.
    """
    model = path.with_suffix(MODEL_SUFFIX)
    if model == path or not model.is_file():
        return {}, ()
    try:
        if os.path.getsize(model) > LARGEST:
            raise InputError(f"{model}: expected at most {LARGEST} bytes; take the file away.")
        return mdl_face_names(read_content(model).data, str(model)), ()
    except (InputError, OSError) as error:
        return {}, (Caution("face-names-not-read", {"reason": str(error)}),)


def faces_of_polydata(
    polydata: vtkPolyData, surface: Surface, names: Mapping[int, str] | None = None
) -> NamedFaces | None:
    """The faces of a surface made of polydata of triangles; None where that does not name any.

    Names that the polydata holds itself take precedence over `names`.
    """
    array = polydata.GetCellData().GetArray(ID_ARRAY)
    if array is None or array.GetNumberOfComponents() != 1:
        return None
    ids = np.asarray(vtk_to_numpy(array))
    if not np.issubdtype(ids.dtype, np.integer) or len(ids) != polydata.GetNumberOfPolys():
        return None
    return NamedFaces(surface.of_given(ids), {**(names or {}), **_names(polydata)})


def set_face_names(polydata: vtkPolyData, names: Mapping[int, str]) -> None:
    """Set the names of the faces of polydata, in place."""
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
