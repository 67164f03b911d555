#!/usr/bin/env bash
# vtk 9.7.2: a .vtp with steps of time comes back with all steps laid over each other.
#
# vtkXMLPolyDataWriter writes two steps of one tube. With appended data (its default) its own reader
# gives the tube back. With inline data (binary or ascii) the writer repeats the piece for every
# step and marks each of them TimeStep="0", so that the reader takes both for pieces of the first
# step. In all three modes the reader tells the numbers of the steps in place of their times.
#
# Seen:  wrote 48 points 14 polygons at times 0.25 1.5
#        Appended 48 points 14 polygons, times (0.0, 1.0)
#        Binary 96 points 28 polygons, times (0.0, 1.0)
#        Ascii 96 points 28 polygons, times (0.0, 1.0)
#
# Why it matters: a moving wall of a fluid-structure simulation, saved so, is a surface in which
# every triangle lies on its copies of the other steps. Nothing warns; areas and volumes are
# multiples, and every mesher and self-intersection test fails on it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check vtk==9.7.2
cd "$folder"
"$folder/venv/bin/python" - 2>/dev/null <<'PYTHON'
import sys

from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersSources import vtkCylinderSource
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

TIMES = (0.25, 1.5)
source = vtkCylinderSource()
source.SetResolution(12)
source.Update()
tube = source.GetOutput()
size = tube.GetNumberOfPoints(), tube.GetNumberOfPolys()
print("wrote", size[0], "points", size[1], "polygons at times", *TIMES)
seen = {}
for mode in ("Appended", "Binary", "Ascii"):
    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(f"{mode}.vtp")
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetInputData(tube)
    writer.SetNumberOfTimeSteps(len(TIMES))
    writer.Start()
    for time in TIMES:
        writer.WriteNextTime(time)
    writer.Stop()
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(f"{mode}.vtp")
    reader.Update()
    found = reader.GetOutput()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    seen[mode] = found.GetNumberOfPoints(), found.GetNumberOfPolys(), times
    print(mode, found.GetNumberOfPoints(), "points", found.GetNumberOfPolys(), "polygons, times", times)
doubled = (2 * size[0], 2 * size[1], (0.0, 1.0))
expected = {"Appended": (*size, (0.0, 1.0)), "Binary": doubled, "Ascii": doubled}
sys.exit(0 if seen == expected else 1)
PYTHON
