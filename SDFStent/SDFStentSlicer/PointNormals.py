"""Normals of a surface whose points move, computed only where they change."""

from typing import NamedTuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleMeshPointNormals

from SDFStentLib.geometry import ranges

LOCAL_FROM = 100_000
"""Number of triangles from which on only the triangles around changed points are computed."""


class Corners(NamedTuple):
    """The triangles of a mesh, and the triangles that meet in each of its points."""

    ofTriangles: np.ndarray
    """(m, 3) indices of points."""
    starts: np.ndarray
    """(n + 1,) beginnings of each point's entries in `triangles`."""
    triangles: np.ndarray
    """(3 m,) indices of triangles, grouped by the points in which they meet."""

    def around(self, points):
        """Indices of the triangles that meet in some points, in order."""
        isNear = np.zeros(len(self.ofTriangles), dtype=bool)
        starts = self.starts[points]
        isNear[self.triangles[ranges(starts, self.starts[points + 1] - starts)]] = True
        return np.flatnonzero(isNear)


def cornersOf(polyData):
    """The `Corners` of a large triangulated polydata; None for a small one. Takes some 40 ms for a
    million triangles."""
    from scipy.sparse import csr_matrix  # late: it costs a tenth of a second

    triangles = vtk_to_numpy(polyData.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    if len(triangles) < LOCAL_FROM:
        return None
    ends = np.arange(0, triangles.size + 1, 3, dtype=np.int32)
    shape = (len(triangles), polyData.GetNumberOfPoints())
    marks = np.ones(triangles.size, dtype=bool)
    byPoint = csr_matrix((marks, triangles.ravel().astype(np.int32), ends), shape=shape).tocsc()
    return Corners(triangles, byPoint.indptr, byPoint.indices)


class PointNormals:
    """Keeps the point normals of a triangulated polydata up to date."""

    def __init__(self, polyData, corners=None):
        """`corners` are its `Corners`; without them all normals are computed every time."""
        self._polyData, self._corners = polyData, corners
        self._skeleton = vtkPolyData()
        self._filter = vtkTriangleMeshPointNormals()
        self._filter.SetInputData(self._skeleton)

    def update(self, changed=None):
        """Compute all normals; or, for a large surface, those of the points named by index arrays.

        Neighbors of these points keep their normals: a change fades toward its edge, and so does the error there.
        """
        if changed is None or self._corners is None:
            self._write(self._computed(self._polyData.GetPoints(), self._polyData.GetPolys()))
            return
        isTouched = np.zeros(self._polyData.GetNumberOfPoints(), dtype=bool)
        for indices in changed:
            isTouched[indices] = True
        touched = np.flatnonzero(isTouched)
        if len(touched):
            self._write(self._computedAround(touched), touched)

    def _computedAround(self, touched):
        """Normals of some points, from the triangles around them alone: the time does not grow with the mesh."""
        triangles = self._corners.ofTriangles[self._corners.around(touched)]
        isNear = np.zeros(self._polyData.GetNumberOfPoints(), dtype=bool)
        isNear[triangles] = True
        near = np.flatnonzero(isNear)
        number = np.empty(len(isNear), dtype=np.int64)
        number[near] = np.arange(len(near))
        points = vtkPoints()
        own = vtk_to_numpy(self._polyData.GetPoints().GetData())
        points.SetData(numpy_to_vtk(own[near], deep=True))
        return self._computed(points, _cells(number[triangles]))[number[touched]]

    def _computed(self, points, polys):
        self._skeleton.SetPoints(points)
        self._skeleton.SetPolys(polys)
        self._skeleton.Modified()
        self._filter.Update()
        return vtk_to_numpy(self._filter.GetOutput().GetPointData().GetNormals())

    def _write(self, normals, where=slice(None)):
        target = self._polyData.GetPointData().GetNormals()
        vtk_to_numpy(target)[where] = normals
        target.Modified()


def withNormals(polyData):
    """Give a surface an array of one float normal per point, in place of any that it has."""
    polyData.GetPointData().RemoveArray("Normals")
    normals = numpy_to_vtk(np.zeros((polyData.GetNumberOfPoints(), 3), dtype=np.float32), deep=True)
    normals.SetName("Normals")
    polyData.GetPointData().SetNormals(normals)


def _cells(triangles):
    """A cell array of triangles (m, 3)."""
    cells = vtkCellArray()
    cells.SetData(3, numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles).ravel(), deep=True))
    return cells
