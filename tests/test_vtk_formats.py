import textwrap

import numpy as np
import pytest
from child_processes import python
from mesh_files import octahedron
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from SDFStentLib.files import add_arrays, encode_vtp, polydata_from_arrays
from SDFStentLib.files.content import read_content
from SDFStentLib.files.formats.vtk_files import encode_legacy, read_vtk_polydata
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


def test_what_vtk_cannot_write_is_said():
    with pytest.raises(InputError, match="VTK cannot write it"):
        encode_vtp(None)


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
