"""What runs in a process of its own to read VTKHDF: VTK's reader, which trusts its file."""

from __future__ import annotations

import json
import os
import sys
from contextlib import suppress
from pathlib import Path

from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from .formats.vtk_quiet import vtk_messages
from .formats.vtkhdf import ANSWER, TOLD

_WRITERS = {
    "vtkPolyData": vtkXMLPolyDataWriter,
    "vtkUnstructuredGrid": vtkXMLUnstructuredGridWriter,
}

_ROOM, _EXPANSION = 2 * 2**30, 64
"""Bytes of memory that the process may have, and more for each byte of the file: compressed, a mesh
is a tenth of itself at best."""


def main(path: str, folder: str) -> None:
    """Read a file, write its first step as XML without compression, and what was found."""
    _limit_memory(os.path.getsize(path))
    with vtk_messages() as messages:
        reader = vtkHDFReader()
        reader.SetFileName(path)
        reader.UpdateInformation()
        times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
        reader.SetStep(0)
        reader.Update()
        found = reader.GetOutputDataObject(0)
    kind = "nothing" if found is None else found.GetClassName()
    told = {
        "kind": kind,
        "steps": len(times or ()),
        "time": f"{times[0]:g}" if times else "",
        "errors": " ".join(" ".join(messages).split()),
    }
    if not messages and kind in _WRITERS:
        writer = _WRITERS[kind]()
        writer.SetFileName(os.path.join(folder, ANSWER))
        writer.SetInputData(found)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToNone()
        writer.SetHeaderTypeToUInt64()
        if not writer.Write():
            sys.exit(1)
    Path(folder, TOLD).write_text(json.dumps(told), encoding="utf-8")


def _limit_memory(size: int) -> None:
    with suppress(ImportError, OSError, ValueError):  # not on every system
        import resource

        most = _ROOM + _EXPANSION * size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


if __name__ == "__main__":
    main(*sys.argv[1:])
