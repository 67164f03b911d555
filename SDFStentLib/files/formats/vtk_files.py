"""VTP and legacy VTK files through VTK, without its noise and without what makes it crash."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vtkmodules.util.misc import calldata_type
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_ID_TYPE,
    VTK_STRING,
    vtkCharArray,
    vtkCommand,
    vtkIdTypeArray,
    vtkLogger,
    vtkLongLongArray,
    vtkOutputWindow,
    vtkStringOutputWindow,
)
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkFieldData, vtkPolyData
from vtkmodules.vtkIOLegacy import vtkPolyDataReader, vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

from ...units import Frame
from ...validation import InputError
from ..content import FileContent, frame_in_text, kind_in_words
from ..polydata import frame_of_polydata
from .legacy_blocks import check_blocks
from .xml_arrays import check_arrays
from .xml_blocks import check_announced_sizes

# VTK's window for messages is one for the whole process, so that only one thread may swap it.
_MESSAGES_LOCK = threading.RLock()


def read_vtk_polydata(content: FileContent) -> tuple[vtkPolyData, Frame | None]:
    """Polydata of a VTP or legacy VTK file, and the frame that its tag names.

    Parameters
    ----------
    content : FileContent
        The file. VTK reads its bytes, not its path, which it wants in UTF-8.

    Raises
    ------
    InputError
        Not such a file, other data than polydata, cut short or damaged.
    """
    is_xml = content.suffix == ".vtp"
    (_check_xml if is_xml else _check_legacy)(content)
    reader = _xml_reader(content.data) if is_xml else _legacy_reader(content.data)
    with vtk_messages() as messages:
        reader.Update()
    if messages or reader.GetErrorCode():
        said = " ".join(messages[0].split()) if messages else f"VTK error {reader.GetErrorCode()}"
        raise InputError(f"{content.path}: cannot be read, the file is damaged ({said}).")
    polydata = vtkPolyData()
    polydata.ShallowCopy(reader.GetOutput())
    frame = frame_of_polydata(polydata)
    if not is_xml:
        frame = frame_in_text(_title(content.data)) or frame
    return polydata, frame


def encode_vtp(polydata: vtkPolyData) -> bytes:
    """VTP, binary, appended and compressed."""
    writer = vtkXMLPolyDataWriter()
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    return b'<?xml version="1.0"?>\n' + _written(writer, polydata, "GetOutputString")


def encode_legacy(polydata: vtkPolyData, title: str) -> bytes:
    """Legacy VTK, binary; the title names the frame.

    Ids beyond 32 bits are written as 64-bit integers, in the same role.
    """
    writer = vtkPolyDataWriter()
    writer.SetFileTypeToBinary()
    writer.SetHeader(title)
    return _written(writer, _with_long_ids(polydata), "GetOutputStdString")


@contextmanager
def vtk_messages() -> Iterator[list[str]]:
    """Collect the errors of VTK in a list instead of on the screen, warnings are swallowed.

    The window and the log level are those of before when the block ends. One block at a time:
    other threads wait.
    """
    messages: list[str] = []

    @calldata_type(VTK_STRING)
    def remember(_sender: Any, _event: str, text: str) -> None:
        messages.append(re.sub(r"ERROR: In [^\n]*\n|\(0x[0-9a-f]+\)", "", text or "").strip())

    window = vtkStringOutputWindow()
    window.AddObserver(vtkCommand.ErrorEvent, remember)
    with _MESSAGES_LOCK:
        before = vtkOutputWindow.GetInstance()
        verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        vtkOutputWindow.SetInstance(window)
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        try:
            yield messages
        finally:
            vtkLogger.SetStderrVerbosity(verbosity)
            vtkOutputWindow.SetInstance(before)


def _written(writer: Any, polydata: vtkPolyData, result: str) -> bytes:
    """What a writer makes, in memory: so that a full disk is noticed by who writes the file."""
    writer.SetInputData(polydata)
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


def _xml_reader(data: bytes) -> vtkXMLPolyDataReader:
    reader = vtkXMLPolyDataReader()
    reader.ReadFromInputStringOn()
    reader.SetInputString(data)  # type: ignore[call-overload]  # bytes stay as they are
    return reader


def _legacy_reader(data: bytes) -> vtkPolyDataReader:
    characters = vtkCharArray()
    characters.SetVoidArray(data, len(data), 1)  # not copied, the array keeps the bytes
    reader = vtkPolyDataReader()
    reader.ReadFromInputStringOn()
    reader.SetInputArray(characters)
    for kind in ("Scalars", "Vectors", "Normals", "Tensors", "ColorScalars", "TCoords", "Fields"):
        getattr(reader, f"ReadAll{kind}On")()  # otherwise the first of each kind only
    return reader


def _check_xml(content: FileContent) -> None:
    data = content.data
    if b"<VTKFile" not in data[:4096]:
        raise InputError(
            f"{content.path}: expected a VTP file (VTK XML), got {kind_in_words(data)}."
        )
    kind = re.search(rb'<VTKFile[^>]*\stype="(\w*)"', data[:8192])
    if kind and kind.group(1) != b"PolyData":
        found = kind.group(1).decode("latin-1")
        raise InputError(f"{content.path}: expected PolyData, got {found}; extract its surface.")
    if not data.rstrip(b" \t\r\n\0").endswith(b"</VTKFile>"):
        raise InputError(f"{content.path}: its end is missing; it is cut short, write it again.")
    check_announced_sizes(data, str(content.path))
    check_arrays(data, str(content.path))


def _check_legacy(content: FileContent) -> None:
    data = content.data
    if not data.startswith(b"# vtk DataFile"):
        raise InputError(f"{content.path}: expected a legacy VTK file, got {kind_in_words(data)}.")
    kind = re.search(rb"^\s*DATASET\s+(\w+)", data, re.MULTILINE | re.IGNORECASE)
    if not kind or kind.group(1).upper() != b"POLYDATA":
        found = kind.group(1).decode("latin-1") if kind else "no data set"
        raise InputError(f"{content.path}: expected POLYDATA, got {found}; extract its surface.")
    check_blocks(data, str(content.path))


def _title(data: bytes) -> str:
    lines = data.split(b"\n", 2)
    return lines[1].decode("latin-1") if len(lines) > 1 else ""
