import numpy as np
import pytest
from mesh_files import octahedron
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from SDFStentLib.files import polydata_from_arrays
from SDFStentLib.files.normal_arrays import refresh_normals
from SDFStentLib.geometry import face_normals, vertex_normals


def squeezed(points):
    """Points above z = 10 come down; the others stay, with their bits."""
    moved = points.copy()
    moved[moved[:, 2] > 10, 2] *= 0.7
    return moved


@pytest.mark.parametrize("side", [1, -1])
def test_normals_are_those_of_the_moved_surface_on_the_side_they_were(side):
    points, triangles = octahedron()
    new = squeezed(points)
    polydata = polydata_from_arrays(
        points,
        triangles,
        {"Normals_": side * vertex_normals(points, triangles).astype(np.float32)},
        {"Normals": side * face_normals(points, triangles)},
    )
    refresh_normals(polydata, points, new, triangles)
    of_points = vtk_to_numpy(polydata.GetPointData().GetArray("Normals_"))
    of_cells = vtk_to_numpy(polydata.GetCellData().GetArray("Normals"))
    assert of_points.dtype == np.float32
    # Single precision of unit vectors; cell normals are doubles, so rounding of 1.
    assert np.abs(of_points - side * vertex_normals(new, triangles)).max() < 1e-7
    assert np.abs(of_cells - side * face_normals(new, triangles)).max() < 1e-15


def test_rows_far_from_what_moved_keep_their_bits():
    points, triangles = octahedron()
    new = squeezed(points)
    stored = (points / 30 + 0.001).astype(np.float32)  # not what the formula would give
    polydata = polydata_from_arrays(points, triangles, {"Normals": stored})
    refresh_normals(polydata, points, new, triangles)
    moved = (new != points).any(axis=1)
    touched = np.unique(triangles[moved[triangles].any(axis=1)])
    far = np.setdiff1d(np.arange(len(points)), touched)
    rows = vtk_to_numpy(polydata.GetPointData().GetArray("Normals"))
    assert len(far) > 10
    assert np.array_equal(rows[far], stored[far])
    assert (rows[touched] != stored[touched]).any()


def test_active_normals_count_whatever_their_name_and_other_vectors_stay():
    points, triangles = octahedron()
    unit = vertex_normals(points, triangles)
    polydata = polydata_from_arrays(points, triangles, {"velocity": unit, "Normals": 5 * unit})
    active = numpy_to_vtk(unit, deep=True)
    active.SetName("n")
    polydata.GetPointData().SetNormals(active)
    new = squeezed(points)
    refresh_normals(polydata, points, new, triangles)
    data = polydata.GetPointData()
    assert np.array_equal(vtk_to_numpy(data.GetArray("velocity")), unit)
    assert np.array_equal(vtk_to_numpy(data.GetArray("Normals")), 5 * unit)  # not of unit length
    assert np.abs(vtk_to_numpy(data.GetArray("n")) - vertex_normals(new, triangles)).max() < 1e-14
