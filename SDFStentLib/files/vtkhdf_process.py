"""Program that reads VTKHDF in a process of its own: VTK's reader, which trusts its file."""

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
from .formats.vtkhdf import ANSWER, FINDINGS

_WRITERS = {
    "vtkPolyData": vtkXMLPolyDataWriter,
    "vtkUnstructuredGrid": vtkXMLUnstructuredGridWriter,
}

_ROOM, _EXPANSION = 2 * 2**30, 64
"""Memory that the process may use, bytes, and further bytes for each byte of the file: compression
makes a mesh ten times smaller at best."""


def main(path: str, folder: str) -> None:
    """Read a file; write its first step as uncompressed XML, and what was found."""
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
    findings = {
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
    Path(folder, FINDINGS).write_text(json.dumps(findings), encoding="utf-8")


def _limit_memory(size: int) -> None:
    with suppress(ImportError, OSError, ValueError):  # not on every system
        import resource

        most = _ROOM + _EXPANSION * size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


if __name__ == "__main__":
    main(*sys.argv[1:])
