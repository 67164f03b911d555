"""Program that extracts a centerline in a process of its own: the only file that knows VMTK.

VMTK writes to the screen and ends its process on some surfaces; arrays go in and out by files.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList

from .polydata import RADIUS_ARRAYS, lines_from_polydata, polydata_from_arrays

RADIUS = RADIUS_ARRAYS[0]


def main(question: str, answer: str) -> None:
    """Read a surface with the ends of its vessel; write the lines between them."""
    from vmtk import vtkvmtk

    with np.load(question) as data:
        surface = polydata_from_arrays(data["points"], data["triangles"])
        inlet, outlets = int(data["inlet"]), data["outlets"]
    search = vtkvmtk.vtkvmtkPolyDataCenterlines()
    search.SetInputData(surface)
    search.SetSourceSeedIds(_ids([inlet]))
    search.SetTargetSeedIds(_ids(outlets))
    # The radius is the weight: the line keeps to the middle (Antiga et al., IEEE TMI 2003).
    search.SetCostFunction("1/R")
    search.SetRadiusArrayName(RADIUS)
    # VMTK wants a name for each array, whether it is used or not.
    search.SetEikonalSolutionArrayName("EikonalSolution")
    search.SetEdgeArrayName("EdgeArray")
    search.SetEdgePCoordArrayName("EdgePCoordArray")
    search.SetCostFunctionArrayName("CostFunction")
    search.AppendEndPointsToCenterlinesOn()
    search.Update()
    found = search.GetOutput()
    points, lines = lines_from_polydata(found)
    # VMTK searches back from the target, but the cells begin at the source.
    np.savez(
        answer,
        points=points,
        inscribed_radius=vtk_to_numpy(found.GetPointData().GetArray(RADIUS)),
        corners=np.concatenate(lines),
        offsets=np.cumsum([0, *(len(line) for line in lines)]),
    )


def _ids(numbers: Iterable[int]) -> vtkIdList:
    ids = vtkIdList()
    for number in numbers:
        ids.InsertNextId(int(number))
    return ids


if __name__ == "__main__":
    main(*sys.argv[1:])
