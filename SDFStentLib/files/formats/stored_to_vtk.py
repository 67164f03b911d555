"""What the strict readers found, as polydata of VTK."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules import vtkCommonCore
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkFieldData, vtkPolyData

from ..polydata import cell_array
from .stored_polydata import ArrayGroup, StoredArray, StoredPolydata

_ROLES = {
    vtkDataSetAttributes.GetAttributeTypeAsString(number): number
    for number in range(vtkDataSetAttributes.NUM_ATTRIBUTES)
}
_COMPONENTS = {
    "Vectors": (3,), "Normals": (3,), "TCoords": (1, 2, 3), "Tensors": (6, 9),
    "GlobalIds": (1,), "PedigreeIds": (1,), "EdgeFlag": (1,), "Tangents": (3,),
}  # fmt: skip
"""How many numbers an array may have for a role; VTK complains about others on the screen."""


def polydata_from_stored(stored: StoredPolydata) -> vtkPolyData:
    """New polydata with all arrays, their types, names, component names and roles."""
    polydata = vtkPolyData()
    points = vtkPoints()
    points.SetData(_vtk_array(stored.points))
    polydata.SetPoints(points)
    for kind, (offsets, corners) in stored.cells.items():
        getattr(polydata, f"Set{kind}")(cell_array(offsets, corners))
    _add_group(polydata.GetPointData(), stored.point_data)
    _add_group(polydata.GetCellData(), stored.cell_data)
    _add_group(polydata.GetFieldData(), stored.field_data)
    return polydata


def _add_group(data: vtkFieldData, group: ArrayGroup) -> None:
    for stored in group.arrays:
        array = _vtk_array(stored)
        if stored.name in group.tables:
            array.SetLookupTable(_lookup_table(group.tables[stored.name]))
        data.AddArray(array)
    for role, name in group.roles.items():
        array = data.GetAbstractArray(name)
        if role not in _ROLES or array is None:
            continue
        if array.GetNumberOfComponents() in _COMPONENTS.get(role, (array.GetNumberOfComponents(),)):
            data.SetActiveAttribute(name, _ROLES[role])


def _vtk_array(stored: StoredArray) -> Any:
    array = getattr(vtkCommonCore, stored.kind.vtk_class)()
    if stored.name is not None:
        array.SetName(stored.name.encode("utf-8", "surrogateescape"))
    array.SetNumberOfComponents(stored.components)
    for number, name in stored.component_names.items():
        array.SetComponentName(number, name.encode("utf-8", "surrogateescape"))
    if isinstance(stored.values, list):
        array.SetNumberOfValues(len(stored.values))
        for number, value in enumerate(stored.values):
            array.SetValue(number, value)
    else:
        _fill(array, stored)
    return array


def _fill(array: Any, stored: StoredArray) -> None:
    values: NDArray[Any] = np.asarray(stored.values)
    array.SetNumberOfTuples(len(values))
    if stored.kind.is_bit:
        for number, bit in enumerate(values.ravel().tolist()):
            array.SetValue(number, bit)
    elif values.size:
        vtk_to_numpy(array).reshape(values.shape)[...] = values


def _lookup_table(colors: NDArray[np.uint8]) -> vtkLookupTable:
    table = vtkLookupTable()
    table.SetNumberOfTableValues(len(colors))
    for number, color in enumerate((colors / 255.0).tolist()):
        table.SetTableValue(number, *color)
    return table
