"""VTP and legacy VTK files: read strictly into polydata, written by VTK without its noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_ID_TYPE,
    vtkIdTypeArray,
    vtkLongLongArray,
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

from ...units import Frame
from ...validation import Indices, InputError, Points
from ..content import FileContent, frame_in_text
from ..polydata import add_arrays, cell_array, frame_of_polydata, polydata_from_arrays
from .stored_to_vtk import polydata_from_stored
from .vtk_legacy import decode_legacy, title_of
from .vtk_quiet import vtk_messages
from .vtp import decode_vtp

_LEVEL = 1
"""Of compression: half of the time that VTK's own 5 takes, for 3 % more bytes."""


def read_vtk_polydata(content: FileContent) -> tuple[vtkPolyData, Frame | None]:
    """Polydata of a VTP or legacy VTK file, and the frame that its tag names.

    Parameters
    ----------
    content : FileContent
        The file. It is read by strict readers of our own: VTK's abort the process, or ask for
        gigabytes, where a file is damaged.

    Raises
    ------
    InputError
        Not such a file, other data than polydata, cut short or damaged.
    """
    name = str(content.path)
    if content.suffix == ".vtp":
        polydata = polydata_from_stored(decode_vtp(content.data, name))
        return polydata, frame_of_polydata(polydata)
    polydata = polydata_from_stored(decode_legacy(content.data, name))
    return polydata, frame_in_text(title_of(content.data)) or frame_of_polydata(polydata)


def encode_vtp(polydata: vtkPolyData) -> bytes:
    """VTP, binary, appended and compressed."""
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
    """Tetrahedra (t, 4) as VTU, as `encode_vtp`."""
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
    """Legacy VTK, binary; the title names the frame.

    Ids beyond 32 bits are written as 64-bit integers, in the same role.
    """
    # Late: few files are old ones, and these have a library of their own.
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter

    writer = vtkPolyDataWriter()
    writer.SetFileTypeToBinary()
    writer.SetHeader(title)
    return _written(writer, _with_long_ids(polydata), "GetOutputStdString")


def _written(writer: Any, data_set: vtkPointSet, result: str) -> bytes:
    """What a writer makes, in memory: so that a full disk is noticed by who writes the file."""
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
    """A copy whose long ids are integers: of VTK's type for ids, legacy files keep 32 bits."""
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
    """Put the numbers of an array as 64-bit integers in its place, and in its role."""
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
