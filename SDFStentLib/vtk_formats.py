"""VTP and legacy VTK files through VTK, without its noise and without what makes it crash."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vtkmodules.util.misc import calldata_type
from vtkmodules.vtkCommonCore import (
    VTK_STRING,
    vtkCommand,
    vtkLogger,
    vtkOutputWindow,
    vtkStringOutputWindow,
)
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkIOLegacy import vtkPolyDataReader, vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

from .file_input import FileContent, Frame, frame_in_text, kind_in_words
from .legacy_blocks import check_blocks
from .polydata import frame_of_polydata
from .validation import InputError
from .xml_blocks import check_announced_sizes

# VTK's window for messages is one for the whole process, so that only one thread may swap it.
_MESSAGES_LOCK = threading.RLock()


def read_vtk_polydata(content: FileContent) -> tuple[vtkPolyData, Frame | None]:
    """Polydata of a VTP or legacy VTK file, and the frame that its tag names.

    Parameters
    ----------
    content : FileContent
        The file; VTK reads it again by its path.

    Raises
    ------
    InputError
        Not such a file, other data than polydata, cut short or damaged.
    """
    is_xml = content.suffix == ".vtp"
    (_check_xml if is_xml else _check_legacy)(content)
    reader = vtkXMLPolyDataReader() if is_xml else _legacy_reader()
    with vtk_messages() as messages:
        reader.SetFileName(str(content.path))
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
    """Legacy VTK, binary; the title names the frame."""
    writer = vtkPolyDataWriter()
    writer.SetFileTypeToBinary()
    writer.SetHeader(title)
    return _written(writer, polydata, "GetOutputStdString")


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


def _legacy_reader() -> vtkPolyDataReader:
    reader = vtkPolyDataReader()
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
