import numpy as np
import pytest
from mesh_files import octahedron
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from SDFStentLib.files import (
    add_arrays,
    inscribed_radius_from_polydata,
    polydata_from_arrays,
    polydata_from_lines,
    surface_from_polydata,
)
from SDFStentLib.files.polydata import polydata_from_polygons
from SDFStentLib.validation import InputError


def test_arrays_keep_name_type_and_values():
    points, triangles = octahedron(rounds=0)
    names = np.array([f"Ärztin {i}" for i in range(8)])
    polydata = polydata_from_arrays(
        points, triangles, {"Displacement": np.ones((6, 3), np.float32)}, {"id": np.arange(8)}
    )
    add_arrays(polydata, None, {"name": names, "flag": np.arange(8) > 3})
    assert polydata.GetPointData().GetArray("Displacement").GetNumberOfComponents() == 3
    assert vtk_to_numpy(polydata.GetCellData().GetArray("id")).dtype == np.int64
    assert vtk_to_numpy(polydata.GetCellData().GetArray("flag")).sum() == 4
    strings = polydata.GetCellData().GetAbstractArray("name")
    assert [strings.GetValue(i) for i in range(8)] == names.tolist()


def test_arrays_that_do_not_fit_are_refused():
    points, triangles = octahedron(rounds=0)
    with pytest.raises(InputError, match="point array d: expected 6 rows"):
        polydata_from_arrays(points, triangles, {"d": np.zeros(5)})
    with pytest.raises(InputError, match="cell array d: expected 8 rows"):
        polydata_from_arrays(points, triangles, None, {"d": 3.0})
    with pytest.raises(InputError, match="expected numbers or text"):
        polydata_from_arrays(points, triangles, {"d": np.zeros(6, complex)})


def test_the_radius_is_found_under_both_names_and_unknown_where_not_positive():
    polydata = polydata_from_lines(np.eye(3), [[0, 1, 2]])
    assert inscribed_radius_from_polydata(polydata) is None
    add_arrays(polydata, {"Radius": np.array([1, -1, np.nan])}, None)
    expected = [1, np.nan, np.nan]
    assert np.array_equal(inscribed_radius_from_polydata(polydata), expected, equal_nan=True)
    add_arrays(polydata, {"MaximumInscribedSphereRadius": np.array([4.0, 5, 6])}, None)
    assert np.array_equal(inscribed_radius_from_polydata(polydata), [4, 5, 6])


def test_other_cells_and_damaged_cells_are_refused():
    square = polydata_from_polygons(np.zeros((4, 3)), np.array([0, 4]), np.arange(4))
    with pytest.raises(InputError, match="vein: expected nothing but triangles"):
        surface_from_polydata(square, "vein")
    with pytest.raises(InputError, match="expected at least one triangle"):
        surface_from_polydata(vtkPolyData())
    wild = polydata_from_polygons(np.zeros((3, 3)), np.array([0, 3]), np.array([0, 1, 7]))
    with pytest.raises(InputError, match="expected point indices from 0 to 2"):
        surface_from_polydata(wild)
    torn = polydata_from_polygons(np.zeros((3, 3)), np.array([0, 3, 2, 3]), np.arange(3))
    with pytest.raises(InputError, match="cells do not fit together"):
        surface_from_polydata(torn)
