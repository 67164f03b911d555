"""VTP and legacy VTK files: read strictly into polydata, written by VTK without its noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from vtkmodules import vtkCommonCore
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_ID_TYPE,
    vtkIdTypeArray,
    vtkLongLongArray,
    vtkLookupTable,
    vtkPoints,
)
from vtkmodules.vtkCommonDataModel import (
    VTK_TETRA,
    vtkDataSetAttributes,
    vtkFieldData,
    vtkPointSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from ...cautions import Caution
from ...units import Frame
from ...validation import Indices, InputError, Points
from ..content import FileContent, frame_in_text
from ..polydata import add_arrays, cell_array, frame_of_polydata, polydata_from_arrays
from .stored_polydata import ArrayGroup, StoredArray, StoredPolydata
from .vtk_legacy import decode_legacy, title_of
from .vtk_quiet import vtk_messages
from .vtkhdf import decode_vtkhdf
from .vtp import GRID, POLYDATA, decode_grid, decode_pieces, decode_vtp

_ROLES = {
    vtkDataSetAttributes.GetAttributeTypeAsString(number): number
    for number in range(vtkDataSetAttributes.NUM_ATTRIBUTES)
}
_COMPONENTS = {
    "Vectors": (3,), "Normals": (3,), "TCoords": (1, 2, 3), "Tensors": (6, 9),
    "GlobalIds": (1,), "PedigreeIds": (1,), "EdgeFlag": (1,), "Tangents": (3,),
}  # fmt: skip
"""Numbers of components that an array may have for a role; VTK complains about others on the
screen."""


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


_LEVEL = 1
"""Level of compression: it takes half the time of VTK's default 5, for 3 % more bytes."""


class ReadPolydata(NamedTuple):
    """The contents of a file of VTK."""

    polydata: vtkPolyData
    frame: Frame | None
    """Frame that its tag names."""
    cautions: tuple[Caution, ...]
    """Cautions about contents of the file that are left out."""


def read_vtk_polydata(content: FileContent) -> ReadPolydata:
    """Polydata from a file in one of VTK's formats; an unstructured grid may be a surface, too.

    Parameters
    ----------
    content : FileContent
        The file. It is read by strict readers of our own: VTK's abort the process, or ask for
        gigabytes, where a file is damaged. VTKHDF is left to VTK's, in a process of its own.

    Raises
    ------
    InputError
        Not such a file, data other than a surface or lines, cut short or damaged.
    """
    name = str(content.path)
    if content.suffix == ".vtk":
        stored, title = decode_legacy(content.data, name), title_of(content.data)
    else:
        stored, title = _DECODERS[content.suffix](content), ""
    polydata = polydata_from_stored(stored)
    frame = frame_in_text(title) or frame_of_polydata(polydata)
    return ReadPolydata(polydata, frame, stored.cautions)


_DECODERS: dict[str, Callable[[FileContent], StoredPolydata]] = {
    ".vtp": lambda content: decode_vtp(content.data, str(content.path)),
    ".vtu": lambda content: decode_grid(content.data, str(content.path)),
    ".pvtp": lambda content: decode_pieces(content.pieces, POLYDATA),
    ".pvtu": lambda content: decode_pieces(content.pieces, GRID),
    ".vtkhdf": decode_vtkhdf,
}
"""Decoders of VTK's current formats; the legacy one has a title as well."""


def encode_vtp(polydata: vtkPolyData) -> bytes:
    """Encode polydata as VTP: binary, appended and compressed."""
    writer = vtkXMLPolyDataWriter()
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.SetCompressionLevel(_LEVEL)
    return b'<?xml version="1.0"?>\n' + _written(writer, polydata, "GetOutputString")


def encode_vtu(
    points: Points,
    tetrahedra: Indices,
    point_arrays: Mapping[str, NDArray[Any]],
    cell_arrays: Mapping[str, NDArray[Any]],
) -> bytes:
    """Encode tetrahedra (t, 4) as VTU, in the manner of `encode_vtp`."""
    grid = vtkUnstructuredGrid()
    grid.SetPoints(polydata_from_arrays(points, tetrahedra[:, :3]).GetPoints())
    grid.SetCells(VTK_TETRA, cell_array(4 * np.arange(len(tetrahedra) + 1), tetrahedra.ravel()))
    add_arrays(grid, point_arrays, cell_arrays)
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.SetCompressionLevel(_LEVEL)
    return b'<?xml version="1.0"?>\n' + _written(writer, grid, "GetOutputString")


def encode_legacy(polydata: vtkPolyData, title: str) -> bytes:
    """Encode polydata as binary legacy VTK; the title names the frame.

    Ids beyond 32 bits are written as 64-bit integers, in the same role.
    """
    # Late: few files are old ones, and these have a library of their own.
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter

    writer = vtkPolyDataWriter()
    writer.SetFileTypeToBinary()
    writer.SetHeader(title)
    return _written(writer, _with_long_ids(polydata), "GetOutputStdString")


def _written(writer: Any, data_set: vtkPointSet, result: str) -> bytes:
    """The output of a writer, kept in memory, so that the writer of the file notices
    a full disk."""
    writer.SetInputData(data_set)
    writer.SetWriteToOutputString(True)
    with vtk_messages() as messages:
        succeeded = writer.Write()
    data = getattr(writer, result)()
    if isinstance(data, str):  # VTK's strings come as text when they happen to be valid UTF-8
        data = data.encode()
    if not succeeded or messages or writer.GetErrorCode() or not data:
        raise InputError(f"surface: VTK cannot write it ({' '.join(messages) or 'no reason'}).")
    return bytes(data)


def _with_long_ids(polydata: vtkPolyData) -> vtkPolyData:
    """A copy whose long ids are integers; legacy files keep only 32 bits of VTK's id type."""
    copy = vtkPolyData()
    copy.ShallowCopy(polydata)
    for data in (copy.GetPointData(), copy.GetCellData(), copy.GetFieldData()):
        for index in reversed(range(data.GetNumberOfArrays())):  # one may leave its place
            array = data.GetAbstractArray(index)
            if array.GetDataType() == VTK_ID_TYPE and _is_wide(array):
                _replace_array(data, index, array)
    return copy


def _is_wide(array: vtkIdTypeArray) -> bool:
    values = vtk_to_numpy(array)
    return values.size > 0 and bool(values.min() < -(2**31) or values.max() >= 2**31)


def _replace_array(data: vtkFieldData, index: int, array: vtkIdTypeArray) -> None:
    """Replace an array by its numbers as 64-bit integers, in its place and in its role."""
    numbers = vtkLongLongArray()
    numbers.DeepCopy(array)
    has_role = isinstance(data, vtkDataSetAttributes)
    role = data.IsArrayAnAttribute(index) if has_role else -1
    if not array.GetName():
        numbers.SetName(f"array {index}")
        data.RemoveArray(index)
    place = data.AddArray(numbers)
    if role >= 0:
        data.SetActiveAttribute(place, role)
