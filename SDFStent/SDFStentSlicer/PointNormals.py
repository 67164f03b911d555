"""Normals of a surface whose points move, computed where that is all that is needed."""

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

LOCAL_FROM = 100_000
"""Triangles from which looking for those that changed is faster than computing all."""


class PointNormals:
    """Keeps the point normals of a triangulated polydata up to date."""

    def __init__(self, polyData):
        self._polyData = polyData
        connectivity = vtk_to_numpy(polyData.GetPolys().GetConnectivityArray())
        self._corners = np.ascontiguousarray(connectivity.reshape(-1, 3).T)
        self._isTouched = np.zeros(polyData.GetNumberOfPoints(), dtype=bool)
        self._skeleton = vtk.vtkPolyData()
        self._filter = vtk.vtkTriangleMeshPointNormals()
        self._filter.SetInputData(self._skeleton)

    def update(self, changed=None):
        """Compute them all; or, of a large surface, those of the points that some index arrays name.

        Neighbors of these points keep theirs: a change fades towards its edge, and so does what is left out.
        """
        if changed is None or self._corners.shape[1] < LOCAL_FROM:
            self._compute(self._polyData.GetPolys(), slice(None))
            return
        for indices in changed:
            self._isTouched[indices] = True
        first, second, third = (self._isTouched[corner] for corner in self._corners)
        faces = np.flatnonzero(first | second | third)
        if len(faces):
            self._compute(_cells(self._corners[:, faces].T), np.flatnonzero(self._isTouched))
        for indices in changed:
            self._isTouched[indices] = False

    def _compute(self, polys, where):
        self._skeleton.SetPoints(self._polyData.GetPoints())
        self._skeleton.SetPolys(polys)
        self._skeleton.Modified()
        self._filter.Update()
        target = self._polyData.GetPointData().GetNormals()
        found = self._filter.GetOutput().GetPointData().GetNormals()
        vtk_to_numpy(target)[where] = vtk_to_numpy(found)[where]
        target.Modified()


def withNormals(polyData):
    """Give a surface one float normal per point, whatever it brought along."""
    polyData.GetPointData().RemoveArray("Normals")
    normals = numpy_to_vtk(np.zeros((polyData.GetNumberOfPoints(), 3), dtype=np.float32), deep=True)
    normals.SetName("Normals")
    polyData.GetPointData().SetNormals(normals)


def _cells(triangles):
    """A cell array of triangles (m, 3)."""
    cells = vtk.vtkCellArray()
    cells.SetData(3, numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles).ravel(), deep=True))
    return cells
