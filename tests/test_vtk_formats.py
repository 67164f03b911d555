"""What of VTK is read and written: long ids, damaged files, other cells and their arrays."""

import textwrap

import numpy as np
import pytest
from child_processes import python
from mesh_files import octahedron
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE
from vtkmodules.vtkCommonDataModel import vtkCellArray
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    surface_from_polydata,
    triangulated_polydata,
)
from SDFStentLib.files.content import read_content
from SDFStentLib.files.formats.vtk_files import encode_legacy, read_vtk_polydata
from SDFStentLib.files.polydata import polydata_from_polygons
from SDFStentLib.files.surface_output import refresh_normals
from SDFStentLib.geometry import face_areas, face_normals, vertex_normals
from SDFStentLib.validation import InputError


def surface_with_text():
    points, triangles = octahedron(rounds=1)
    polydata = polydata_from_arrays(points, triangles, {"label": np.arange(len(points))})
    add_arrays(polydata, {"name": np.array([f"p{i}" for i in range(len(points))])}, None)
    return polydata


def as_file(polydata, writer, path, mode):
    writer.SetInputData(polydata)
    getattr(writer, mode)()
    writer.SetFileName(str(path))
    writer.Write()
    return path


def all_kinds(folder):
    polydata = surface_with_text()
    for mode in ("SetDataModeToAscii", "SetDataModeToBinary", "SetDataModeToAppended"):
        yield as_file(polydata, vtkXMLPolyDataWriter(), folder / f"{mode}.vtp", mode)
    for mode in ("SetFileTypeToASCII", "SetFileTypeToBinary"):
        yield as_file(polydata, vtkPolyDataWriter(), folder / f"{mode}.vtk", mode)
    old = vtkPolyDataWriter()
    old.SetFileVersion(42)  # cells in the form of VTK before 9
    yield as_file(polydata, old, folder / "old.vtk", "SetFileTypeToBinary")
    (folder / "ours.vtp").write_bytes(encode_vtp(polydata))
    (folder / "ours.vtk").write_bytes(encode_legacy(polydata, "title"))
    yield folder / "ours.vtp"
    yield folder / "ours.vtk"


def test_cut_files_and_noise_never_crash_never_print_and_never_pass_for_another_mesh(tmp_path):
    """In a process of its own, because VTK's reader may crash it."""
    paths = list(all_kinds(tmp_path))
    script = textwrap.dedent("""
        import sys, random
        from pathlib import Path
        import numpy as np
        from SDFStentLib.files.surface_files import read_surface
        from SDFStentLib.validation import InputError
        folder = Path(sys.argv[1])
        for path in map(Path, sys.argv[2:]):
            data, whole = path.read_bytes(), read_surface(path)
            lengths = sorted(random.Random(5).sample(range(1, len(data)), 60))
            for length in [1, 2, 10, 40, 60, 80, 100, *lengths, len(data) - 1]:
                cut = folder / f"cut{path.suffix}"
                cut.write_bytes(data[:length])
                try:
                    found = read_surface(cut)
                except InputError as error:
                    assert str(cut) in str(error), error
                    continue
                # Cut behind the mesh itself: then the mesh is right.
                assert np.array_equal(found.triangles, whole.triangles), (path, length)
                assert np.array_equal(found.points, whole.points), (path, length)
            for seed in range(5):
                cut.write_bytes(data[:30] + random.Random(seed).randbytes(3000))
                try:
                    read_surface(cut)
                except InputError:
                    continue
                raise AssertionError(f"noise passed for {path.suffix}")
        print("done")
    """)
    run = python(script, tmp_path, *paths)
    assert run.stderr == ""
    assert run.stdout == "done\n"
    assert run.returncode == 0


LEGACY, XML = b"# vtk DataFile Version 3.0\n", b'<VTKFile type="PolyData">'
POLYDATA = LEGACY + b"x\nASCII\nDATASET POLYDATA\n"
FIELD = b"POINTS 1 float\n0 0 0\nPOINT_DATA 1\nFIELD FieldData 1\nname 1 9 string\na\n"
CHOKING = {
    "a.vtp": {
        b"not XML": r"expected a VTP file \(VTK XML\), got a file that begins with",
        LEGACY: r"got a legacy VTK file \(name it .vtk\)",
        b"PK\3\4": "got a ZIP archive",
        b'<VTKFile type="UnstructuredGrid"></VTKFile>': "got UnstructuredGrid",
        XML + b"<PolyData>": "its end is missing",
        XML + b'<Piece NumberOfPoints="99999999999"/></VTKFile>': "expected one PolyData",
        XML + b"<PolyData></VTKFile>": "expected well-formed XML",
    },
    "a.vtk": {
        b"<VTKFile>": r"expected a legacy VTK file, got a VTK XML file \(name it .vtp",
        LEGACY: "expected ASCII or BINARY in its third line",
        LEGACY + b"\nASCII\n": "got no data set",
        LEGACY + b"x\nASCII\nDATASET STRUCTURED_GRID\n": "got STRUCTURED_GRID",
        POLYDATA: "expected POINTS",
        POLYDATA + b"POINTS 9999999999 float\n": "expected 29999999997 numbers",
        POLYDATA + FIELD: "expected 9 texts, got the end",
    },
}


@pytest.mark.parametrize("name", CHOKING)
def test_what_vtk_would_choke_on_is_said_first(tmp_path, name):
    path = tmp_path / name
    for data, words in CHOKING[name].items():
        path.write_bytes(data)
        with pytest.raises(InputError, match=words):
            read_vtk_polydata(read_content(path))


@pytest.mark.parametrize("role", ["", "GlobalIds", "PedigreeIds"])
@pytest.mark.parametrize("name", ["case", None])
@pytest.mark.parametrize("largest", [7, 10**12, -(10**12)])
def test_long_ids_come_back_from_a_legacy_file_in_their_role(tmp_path, role, name, largest):
    polydata = polydata_from_arrays(*octahedron())
    cells = polydata.GetCellData()
    values = np.linspace(0, largest, polydata.GetNumberOfCells()).astype(np.int64)
    ids = numpy_to_vtk(values, deep=True, array_type=VTK_ID_TYPE)
    ids.SetName(name)
    getattr(cells, f"Set{role}" if role else "AddArray")(ids)
    path = tmp_path / "a.vtk"
    path.write_bytes(encode_legacy(polydata, "title"))
    found = read_vtk_polydata(read_content(path))[0].GetCellData()
    assert found.GetNumberOfArrays() == 1
    assert vtk_to_numpy(found.GetArray(0)).tolist() == values.tolist()
    assert not role or getattr(found, f"Get{role}")() is not None
    assert cells.GetArray(0) is ids  # what is written is not changed


# Polydata of VTK: arrays, triangles of any cells, and normals that follow the points.


SQUARES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [9, 9, 9.0]])


def test_polygons_are_cut_and_carry_their_arrays_and_ids():
    polydata = polydata_from_polygons(
        SQUARES, np.array([0, 4, 8, 11]), np.array([0, 1, 2, 3, 1, 4, 5, 2, 0, 1, 2])
    )
    add_arrays(polydata, None, {"face": np.array([7, 8, 9]), "name": np.array(["a", "b", "c"])})
    ids = numpy_to_vtk(np.array([70, 80, 90]), deep=True)
    ids.SetName("GlobalElementID")
    polydata.GetCellData().SetGlobalIds(ids)
    cut, warnings = triangulated_polydata(polydata, "vein.ply")
    surface = surface_from_polydata(cut).whole  # the third one lies on the first
    points, triangles = surface.points, surface.triangles
    assert len(points) == 7  # the unused one stays
    assert len(triangles) == 5
    assert face_areas(points, triangles).sum() == pytest.approx(2.5, abs=1e-12)
    data = cut.GetCellData()
    assert vtk_to_numpy(data.GetArray("face")).tolist() == [7, 7, 8, 8, 9]
    assert vtk_to_numpy(data.GetGlobalIds()).tolist() == [70, 70, 80, 80, 90]
    strings = data.GetAbstractArray("name")
    assert [strings.GetValue(i) for i in range(5)] == list("aabbc")
    assert tuple(map(str, warnings)) == (
        "vein.ply: 2 polygons or strips were cut into triangles, 5 triangles now.",
    )


def test_lines_and_vertices_go_and_strips_are_cut():
    polydata = polydata_from_arrays(SQUARES, [[0, 1, 2]])
    verts, lines, strips = vtkCellArray(), vtkCellArray(), vtkCellArray()
    verts.InsertNextCell(1, [6])
    lines.InsertNextCell(2, [0, 6])
    strips.InsertNextCell(4, [0, 1, 3, 2])
    polydata.SetVerts(verts)
    polydata.SetLines(lines)
    polydata.SetStrips(strips)
    add_arrays(polydata, None, {"cell": np.array([10, 11, 12, 13])})
    cut, warnings = triangulated_polydata(polydata)
    surface = surface_from_polydata(cut)
    points, triangles = surface.points, surface.triangles
    assert face_normals(points, triangles).tolist() == [[0, 0, 1]] * 3  # a strip alternates
    assert vtk_to_numpy(cut.GetCellData().GetArray("cell")).tolist() == [12, 13, 13]
    assert len(warnings) == 2
    assert "2 vertices and lines among the cells were dropped" in str(warnings[1])


def test_concave_polygons_are_cut_inside():
    arrow = np.array([[0, 0, 0], [2, 0, 0], [0.5, 0.5, 0], [0, 2, 0.0]])
    star = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0.0]])
    polydata = polydata_from_polygons(
        np.concatenate([arrow, arrow, star]),
        np.array([0, 4, 8, 13]),
        np.array([0, 1, 2, 3, 5, 6, 7, 4, 8, 9, 10, 11, 12]),
    )
    surface = surface_from_polydata(triangulated_polydata(polydata)[0]).whole
    points, triangles = surface.points, surface.triangles
    assert len(triangles) == 7
    # Areas: of the arrow 1 (twice), of the square less its notch 16 - 6.
    assert face_areas(points, triangles).sum() == pytest.approx(12, abs=1e-12)
    assert (face_normals(points, triangles)[:, 2] == 1).all()


def test_a_polygon_that_crosses_itself_still_gives_its_triangles():
    bow = np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, 2, 0.0]])
    polydata = polydata_from_polygons(bow, np.array([0, 5]), np.arange(5))
    assert triangulated_polydata(polydata)[0].GetNumberOfPolys() == 3


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
