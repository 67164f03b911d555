import numpy as np
import pytest
from mesh_files import octahedron
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

from SDFStentLib.files.polydata import (
    add_arrays,
    cells_from_array,
    frame_of_polydata,
    inscribed_radius_from_polydata,
    lines_from_polydata,
    polydata_from_arrays,
    polydata_from_lines,
    polydata_from_polygons,
    set_frame_of_polydata,
    surface_from_polydata,
)
from SDFStentLib.validation import InputError


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_arrays_go_to_polydata_and_back(kind):
    points, triangles = octahedron()
    polydata = polydata_from_arrays(points.astype(kind), triangles)
    back = surface_from_polydata(polydata)
    assert np.array_equal(back.points, points.astype(kind))
    assert np.array_equal(back.triangles, triangles)
    assert vtk_to_numpy(polydata.GetPoints().GetData()).dtype == kind


def test_nothing_is_shared_with_the_polydata():
    points, triangles = octahedron()
    polydata = polydata_from_arrays(points, triangles)
    read = surface_from_polydata(polydata)
    points[0] += 1
    vtk_to_numpy(polydata.GetPoints().GetData())[:] += 2
    assert np.array_equal(read.points[0], points[0] - 1)


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


def test_lines_come_in_cell_order_not_point_order():
    polydata = polydata_from_lines(np.eye(3), [[2, 1, 0], [1, 0]])
    points, lines = lines_from_polydata(polydata)
    assert [line.tolist() for line in lines] == [[2, 1, 0], [1, 0]]
    assert np.array_equal(points, np.eye(3))
    assert lines_from_polydata(vtkPolyData())[1] == ()


def test_the_radius_is_found_under_both_names_and_unknown_where_not_positive():
    polydata = polydata_from_lines(np.eye(3), [[0, 1, 2]])
    assert inscribed_radius_from_polydata(polydata) is None
    add_arrays(polydata, {"Radius": np.array([1, -1, np.nan])}, None)
    expected = [1, np.nan, np.nan]
    assert np.array_equal(inscribed_radius_from_polydata(polydata), expected, equal_nan=True)
    add_arrays(polydata, {"MaximumInscribedSphereRadius": np.array([4.0, 5, 6])}, None)
    assert np.array_equal(inscribed_radius_from_polydata(polydata), [4, 5, 6])


def test_the_frame_tag_can_be_set_read_and_removed():
    polydata = polydata_from_lines(np.eye(3), [[0, 1]])
    for frame in ("RAS", "LPS", None):
        set_frame_of_polydata(polydata, frame)
        assert frame_of_polydata(polydata) == frame


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


def test_cells_of_every_storage_are_read():
    cells = vtkCellArray()
    for corners in ([0, 1, 2], [2, 1, 3]):
        cells.InsertNextCell(3, corners)
    for convert in ("ConvertTo32BitStorage", "ConvertTo64BitStorage", "ConvertToSmallestStorage"):
        getattr(cells, convert)()
        read = cells_from_array(cells, 4, "cells")
        assert read.corners.tolist() == [0, 1, 2, 2, 1, 3]
        assert read.offsets.tolist() == [0, 3, 6]
