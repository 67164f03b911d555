"""Faces of a model that Slicer leaves out when it reads its file: solids of an STL, numbers of a PLY, names beside a VTP."""

from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from SDFStentLib.files import ID_ARRAY, NAME_ARRAY, add_arrays, read_surface, set_face_names
from SDFStentLib.validation import InputError

from . import Conversion

WITHOUT_FACES = (".stl", ".ply")
"""Formats whose faces Slicer's readers drop."""

NAMES = ".mdl"
"""The names of the faces of the SimVascular model beside a surface."""


def addFaces(node, polyData):
    """Add face ids in place to a copy of a model's cells, where the model is as in its file."""
    path = _file(node)
    if path is None or not _mayTellMore(path, polyData):
        return
    try:
        surface = read_surface(path, Conversion.fileUnits(node))
    except InputError:
        return  # Slicer reads more than the library; what it has read is judged elsewhere
    if surface.faces is not None and _isOf(node, surface):
        ids = vtk_to_numpy(surface.polydata().GetCellData().GetArray(ID_ARRAY))
        add_arrays(polyData, None, {ID_ARRAY: ids})
        set_face_names(polyData, surface.faces.names)


def _file(node):
    storage = node.GetStorageNode() if node.IsA("vtkMRMLModelNode") else None
    if storage is None or not storage.GetFileName() or node.GetModifiedSinceRead():
        return None
    return Path(storage.GetFullNameFromFileName())


def _mayTellMore(path, polyData):
    if not polyData.GetCellData().HasArray(ID_ARRAY):
        return path.suffix.lower() in WITHOUT_FACES and path.is_file()
    return not polyData.GetFieldData().HasArray(NAME_ARRAY) and path.with_suffix(NAMES).is_file()


def _isOf(node, surface):
    """Whether the triangles of a model are those of a surface, in their order; the frames may differ."""
    given, count = node.GetPolyData(), len(surface.triangles)
    if given.GetNumberOfCells() != count or given.GetNumberOfPolys() != count:
        return False
    corners = vtk_to_numpy(given.GetPolys().GetConnectivityArray())
    if len(corners) != 3 * count:
        return False
    ours = np.abs(surface.points[surface.triangles.ravel()])
    theirs = np.abs(vtk_to_numpy(given.GetPoints().GetData())[corners])
    return np.allclose(ours, theirs, rtol=1e-5, atol=1e-5)  # single precision
