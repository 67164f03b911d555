"""Surfaces as other programs write them: grids, pieces, steps of time, VTKHDF, OFF, images."""

import gzip
import re
import struct

import numpy as np
import pymeshlab
import pytest
from child_processes import PROJECT
from mesh_files import octahedron
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersCore import vtkAppendFilter
from vtkmodules.vtkFiltersSources import vtkCylinderSource, vtkSphereSource
from vtkmodules.vtkIOHDF import vtkHDFWriter
from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter
from vtkmodules.vtkIOParallelXML import vtkXMLPPolyDataWriter, vtkXMLPUnstructuredGridWriter
from vtkmodules.vtkIOXML import (
    vtkXMLImageDataWriter,
    vtkXMLPolyDataReader,
    vtkXMLPolyDataWriter,
    vtkXMLUnstructuredGridWriter,
)

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.cautions import Caution
from SDFStentLib.cli import main
from SDFStentLib.cli.option_table import SURFACE
from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
    read_with_pieces,
    write_surface,
)
from SDFStentLib.files.plain.off import decode_off
from SDFStentLib.surface_formats import (
    FORMATS_IN_WORDS,
    READ_SUFFIXES,
    SURFACE_FORMATS,
    WRITTEN_SUFFIXES,
    written_suffix,
)
from SDFStentLib.validation import InputError

POINTS, TRIANGLES = octahedron(rounds=1)
LABELS = np.arange(len(TRIANGLES), dtype=np.int32)


def a_sphere():
    polydata = polydata_from_arrays(POINTS, TRIANGLES)
    add_arrays(polydata, {"height": POINTS[:, 2]}, {"label": LABELS})
    return polydata


def as_grid(polydata):
    append = vtkAppendFilter()
    append.SetInputData(polydata)
    append.Update()
    return append.GetOutput()


def written(writer, path, data):
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    assert writer.Write()
    return path


def kinds_of(surface):
    return [caution.kind for caution in surface.warnings]


def assert_is_the_sphere(surface, points=POINTS):
    assert np.array_equal(surface.points, points)
    assert np.array_equal(surface.triangles, TRIANGLES)
    polydata = surface.polydata()
    assert polydata.GetCellData().GetArray("label").GetTuple1(5) == 5
    assert polydata.GetPointData().GetArray("height").GetTuple1(3) == pytest.approx(points[3, 2])


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("kind", ["ASCII", "Binary"])
def test_a_legacy_grid_of_triangles_is_a_surface(tmp_path, kind, version):
    writer = vtkUnstructuredGridWriter()
    writer.SetFileVersion(version)
    getattr(writer, f"SetFileTypeTo{kind}")()
    path = written(writer, tmp_path / "a.vtk", as_grid(a_sphere()))
    surface = read_surface(path)
    np.testing.assert_allclose(surface.points, POINTS, atol=1e-4)  # VTK's text has six digits
    assert_is_the_sphere(surface, surface.points)


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA", "LZ4"])
def test_a_grid_of_triangles_in_vtks_xml_is_a_surface(tmp_path, mode, compressor):
    writer = vtkXMLUnstructuredGridWriter()
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    assert_is_the_sphere(read_surface(written(writer, tmp_path / "a.vtu", as_grid(a_sphere()))))


def meshio_like(lines=True):
    """Version 3.0 as text: what gmsh, FEniCS and meshio write has points and lines beside."""
    quad, pixel = [0, 1, 2, 3], [4, 5, 7, 6]
    cells = [(1, [0]), (3, [0, 1])] if lines else []
    cells += [(5, [0, 1, 4]), (9, quad), (8, pixel)]
    size = sum(1 + len(corners) for _, corners in cells)
    points = "0 0 0 30 0 0 30 30 0 0 30 0 0 0 30 30 0 30 30 30 30 0 30 30"
    rows = "\n".join(" ".join(map(str, [len(corners), *corners])) for _, corners in cells)
    types = "\n".join(str(kind) for kind, _ in cells)
    ids = "\n".join(str(10 + number) for number in range(len(cells)))
    return (
        "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS 8 double\n{points}\nCELLS {len(cells)} {size}\n{rows}\n"
        f"CELL_TYPES {len(cells)}\n{types}\nCELL_DATA {len(cells)}\n"
        f"SCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n{ids}\n"
    )


def test_lines_of_a_grid_are_dropped_quads_cut_and_its_data_stay_with_their_cells(tmp_path):
    (tmp_path / "a.vtk").write_text(meshio_like(), encoding="ascii")
    surface = read_surface(tmp_path / "a.vtk")
    assert kinds_of(surface) == ["polygons-cut", "cells-dropped"]
    ids = surface.polydata().GetCellData().GetArray("CellEntityIds")
    assert [ids.GetTuple1(row) for row in range(5)] == [12, 13, 13, 14, 14]
    assert surface.surface.face_areas.sum() == pytest.approx(450 + 900 + 900)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("CELL_TYPES 3\n5", "CELL_TYPES 3\n10", "a volume mesh of 1 tetrahedra; extract its"),
        ("CELL_TYPES 3\n5", "CELL_TYPES 3\n22", "got 1 triangles of higher order; save the mesh"),
        ("CELL_TYPES 3\n5", "CELL_TYPES 3\n9", "expected 4 corners of a cell of type 9, got 3"),
        ("CELL_TYPES 3\n5", "CELL_TYPES 3\n99", "expected cells of a surface, got 1 of type 99"),
        ("CELL_TYPES 3\n5\n9\n8\n", "CELL_TYPES 2\n5\n9\n", "expected 3 types, got 2"),
        ("3 0 1 4", "3 0 1 8", "expected point indices from 0 to 7"),
        ("UNSTRUCTURED_GRID", "RECTILINEAR_GRID", "expected POLYDATA, got RECTILINEAR_GRID"),
    ],
)
def test_what_is_no_surface_among_grids_is_said(tmp_path, old, new, words):
    text = meshio_like(lines=False)
    assert old in text
    (tmp_path / "a.vtk").write_text(text.replace(old, new, 1), encoding="ascii")
    with pytest.raises(InputError, match=words):
        read_surface(tmp_path / "a.vtk")


@pytest.mark.parametrize("suffix", [".vtk", ".vtu"])
def test_every_cut_of_a_grid_is_noticed(tmp_path, suffix):
    writer = vtkUnstructuredGridWriter() if suffix == ".vtk" else vtkXMLUnstructuredGridWriter()
    if suffix == ".vtk":
        writer.SetFileTypeToBinary()
    grid = as_grid(polydata_from_arrays(*octahedron(rounds=0)))
    data = written(writer, tmp_path / f"a{suffix}", grid).read_bytes()
    path = tmp_path / f"cut{suffix}"
    for length in range(1, len(data.rstrip())):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match="cut"):
            read_surface(path)


def growing(times, mode):
    """A tube, and what writes it with steps of time."""
    source = vtkCylinderSource()
    source.SetResolution(12)
    source.Update()
    tube = vtkPolyData()
    tube.DeepCopy(source.GetOutput())
    writer = vtkXMLPolyDataWriter()
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetInputData(tube)
    writer.SetNumberOfTimeSteps(len(times))
    return tube, writer


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
def test_of_steps_of_time_the_first_is_read_and_said(tmp_path, mode):
    times = (0.25, 1.5, 2.0)
    tube, writer = growing(times, mode)
    path = tmp_path / "a.vtp"
    writer.SetFileName(str(path))
    writer.Start()
    first = np.array([tube.GetPoint(n) for n in range(tube.GetNumberOfPoints())])
    for number, time in enumerate(times):
        for n, point in enumerate((1 + number) * first):
            tube.GetPoints().SetPoint(n, *point.tolist())
        tube.GetPoints().Modified()
        writer.WriteNextTime(time)
    writer.Stop()
    surface = read_surface(path)
    assert np.array_equal(surface.points, first.astype(np.float32).astype(float))
    (said,) = (str(one) for one in surface.warnings if one.kind == "first-of-steps")
    assert "it holds 3 steps of time; the first, at 0.25, is read" in said
    if mode == "Appended":  # as VTK's own reader has it
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        assert reader.GetOutput().GetPoint(7) == tuple(surface.points[7])
    write_surface(tmp_path / "out.vtp", surface, surface.points)
    assert "first-of-steps" not in kinds_of(read_surface(tmp_path / "out.vtp"))


def in_pieces(folder, writer, source, name):
    writer.SetFileName(str(folder / name))
    writer.SetNumberOfPieces(3)
    writer.SetStartPiece(0)
    writer.SetEndPiece(2)
    writer.SetInputConnection(source.GetOutputPort())
    assert writer.Write()
    return folder / name


def a_source(is_grid):
    sphere = vtkSphereSource()
    sphere.SetRadius(20)
    if not is_grid:
        return sphere
    grid = vtkAppendFilter()
    grid.SetInputConnection(sphere.GetOutputPort())
    return grid


@pytest.mark.parametrize(
    ("name", "writer"),
    [("a.pvtp", vtkXMLPPolyDataWriter), ("a.pvtu", vtkXMLPUnstructuredGridWriter)],
)
def test_pieces_in_files_of_their_own_are_one_surface(tmp_path, name, writer):
    path = in_pieces(tmp_path, writer(), a_source(name.endswith("u")), name)
    surface = read_surface(path)
    sphere = a_source(False)
    sphere.Update()
    assert len(surface.triangles) == sphere.GetOutput().GetNumberOfPolys()
    whole = read_surface(saved(tmp_path / "whole.vtp", sphere.GetOutput()))
    assert surface.surface.face_areas.sum() == pytest.approx(whole.surface.face_areas.sum())
    pieces = sorted(tmp_path.glob(f"a_*{name[1:].replace('p', '', 1)}"))
    assert len(surface.points) == sum(len(read_surface(piece).points) for piece in pieces)

    before = surface.sha256
    pieces[1].write_bytes(pieces[0].read_bytes())
    assert read_with_pieces(path).sha256 != before
    pieces[1].unlink()
    with pytest.raises(InputError, match=rf"{pieces[1].name}: no such file"):
        read_surface(path)


def saved(path, polydata):
    path.write_bytes(encode_vtp(polydata))
    return path


@pytest.mark.parametrize("source", ["../a.vtp", "/etc/passwd", "", "..\\a.vtp", "sub/../../a.vtp"])
def test_pieces_are_taken_from_beside_their_list_only(tmp_path, source):
    saved(tmp_path / "a.vtp", a_sphere())
    (tmp_path / "in").mkdir()
    text = f'<VTKFile type="PPolyData"><PPolyData><Piece Source="{source}"/></PPolyData></VTKFile>'
    (tmp_path / "in" / "a.pvtp").write_text(text, encoding="ascii")
    with pytest.raises(InputError, match="expected pieces beside it or in a folder there"):
        read_surface(tmp_path / "in" / "a.pvtp")


@pytest.mark.parametrize("is_grid", [False, True])
def test_vtkhdf_is_read_as_it_was(tmp_path, is_grid):
    data = as_grid(a_sphere()) if is_grid else a_sphere()
    assert_is_the_sphere(read_surface(written(vtkHDFWriter(), tmp_path / "a.vtkhdf", data)))


class Growing(VTKPythonAlgorithmBase):
    """A sphere whose radius is the time, at three of them."""

    TIMES = (12.5, 20.0, 30.0)

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkPolyData")

    def RequestInformation(self, _request, _given, made):
        steps = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        made.GetInformationObject(0).Set(steps, self.TIMES, len(self.TIMES))
        return 1

    def RequestData(self, _request, _given, made):
        key = vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()
        sphere = vtkSphereSource()
        sphere.SetRadius(made.GetInformationObject(0).Get(key))
        sphere.Update()
        vtkPolyData.GetData(made).ShallowCopy(sphere.GetOutput())
        return 1


def test_of_the_steps_of_a_vtkhdf_file_the_first_is_read_and_said(tmp_path):
    source, writer = Growing(), vtkHDFWriter()
    writer.SetInputConnection(source.GetOutputPort())
    writer.SetFileName(str(tmp_path / "a.vtkhdf"))
    writer.SetWriteAllTimeSteps(True)
    assert writer.Write()
    surface = read_surface(tmp_path / "a.vtkhdf")
    np.testing.assert_allclose(np.linalg.norm(surface.points, axis=1), 12.5, rtol=1e-6)
    assert "3 steps of time; the first, at 12.5, is read" in str(surface.warnings[0])


def test_a_vtkhdf_file_that_is_damaged_or_holds_something_else_is_a_sentence(tmp_path):
    path = written(vtkHDFWriter(), tmp_path / "a.vtkhdf", a_sphere())
    data = path.read_bytes()
    for cut in (100, len(data) // 2, len(data) - 40):
        path.write_bytes(data[:cut])
        with pytest.raises(
            InputError, match=r"VTK cannot read .* cut short|got an HDF5 file"
        ) as said:
            read_surface(path)
        assert "\n" not in str(said.value)
    volume = vtkAppendFilter()
    volume.SetInputData(vtkImage())
    volume.Update()
    written(vtkHDFWriter(), path, volume.GetOutput())
    with pytest.raises(InputError, match="a volume mesh of 27 voxels"):
        read_surface(path)


def vtkImage():
    image = vtkImageData()
    image.SetDimensions(4, 4, 4)
    return image


OFF = """OFF # SPACE=LPS
# by hand
8 6 12
0 0 0
30 0 0
30 30 0 # a corner
0 30 0

0 0 30
30 0 30
30 30 30
0 30 30
4 3 2 1 0
4 4 5 6 7
4 0 1 5 4  255 0 0
3 1 2 6
3 1 6 5
4 2 3 7 6
"""


def test_off_is_read_with_comments_colors_and_polygons(tmp_path):
    (tmp_path / "a.off").write_text(OFF, encoding="ascii")
    surface = read_surface(tmp_path / "a.off")
    assert surface.frame == "LPS"
    assert len(surface.points) == 8
    assert surface.surface.face_areas.sum() == pytest.approx(5 * 900)
    assert surface.warnings[0] == Caution(
        "contents-not-kept",
        {"contents": "colors of faces", "format": "OFF"},
        label=f"{tmp_path / 'a.off'}: ",
    )
    mesh = decode_off(OFF.replace("OFF ", "OFF 8 6 0 ").replace("8 6 12\n", "").encode(), "a.off")
    assert len(mesh.points) == 8
    crlf = decode_off(OFF.replace("\n", "\r\n").encode(), "a.off")
    assert np.array_equal(crlf.corners, mesh.corners)


@pytest.mark.parametrize("head", ["COFF", "NOFF", "NCOFF", "CNOFF", "STOFF"])
def test_what_off_has_behind_its_coordinates_is_left_out_and_said(head):
    rows = OFF.split("\n")
    rows = [row + " 1 0 0" if row.count(" ") == 2 and row[0] in "03" else row for row in rows]
    mesh = decode_off("\n".join(rows).replace("OFF", head, 1).encode(), "a.off")
    assert mesh.points.shape == (8, 3)
    (said,) = map(str, mesh.warnings)
    assert all(words in said for words in {"C": ["colors"], "N": ["normals"]}.get(head[0], []))


@pytest.mark.parametrize("with_normals", [False, True])
def test_meshlabs_off_is_read(tmp_path, with_normals):
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(POINTS, TRIANGLES))
    meshes.save_current_mesh(str(tmp_path / "a.off"), save_vertex_normal=with_normals)
    surface = read_surface(tmp_path / "a.off")
    np.testing.assert_allclose(surface.points, POINTS, atol=1e-4)
    assert np.array_equal(surface.triangles, TRIANGLES)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("OFF", "4OFF", "expected points of three numbers as text"),
        ("OFF #", "OFF BINARY #", "expected points of three numbers as text"),
        ("OFF", "ply", "expected what its name says|expected an OFF file"),
        ("8 6 12", "9 6 12", "do not fit its OFF header"),
        ("8 6 12", "8 -6 12", "do not fit its OFF header"),
        ("3 1 2 6", "4 1 2 6", "do not fit its OFF header"),
        ("3 1 2 6", "2 1 2", "do not fit its OFF header"),
        ("3 1 2 6", "3 1 2 8", "expected point indices from 0 to 7"),
        ("30 30 30", "30 x 30", "do not fit its OFF header"),
    ],
)
def test_what_is_no_off_is_said(tmp_path, old, new, words):
    (tmp_path / "a.off").write_text(OFF.replace(old, new, 1), encoding="ascii")
    with pytest.raises(InputError, match=words):
        read_surface(tmp_path / "a.off")


def test_every_cut_of_an_off_file_is_noticed():
    data = OFF.rstrip().encode()
    for length in range(1, len(data) - 1):  # the last digit may be missing without a trace
        with pytest.raises(InputError, match=r"a\.off: "):
            decode_off(data[:length], "a.off")


NIFTI = struct.pack("<i", 348) + bytes(340) + b"n+1\0" + bytes(200)
NRRD = b"NRRD0005\ntype: short\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n" + bytes(16)
META = b"ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementDataFile = LOCAL\n" + bytes(8)
DICOM = bytes(128) + b"DICM" + bytes(100)


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.nii", NIFTI, "an image (NIfTI)"),
        ("a.nii.gz", gzip.compress(NIFTI, mtime=0), "an image (NIfTI)"),
        ("a.nii.gz", gzip.compress(NIFTI, mtime=0)[:12], "an image (NIfTI)"),
        ("a.nrrd", NRRD, "an image (NRRD)"),
        ("a.nhdr", NRRD, "an image (NRRD)"),
        ("a.seg.nrrd", NRRD.replace(b"\n\n", b"\nSegment0_ID:=a\n\n"), "a segmentation (NRRD)"),
        ("b.seg.nrrd", NRRD, "a segmentation (NRRD)"),
        ("a.gipl", b"no magic of its own", "an image (GIPL)"),
        ("a.mha", META, "an image (MetaImage)"),
        ("a.mhd", META, "an image (MetaImage)"),
        ("a.dcm", DICOM, "an image (DICOM)"),
        ("IM0001", DICOM, "an image (DICOM)"),
        ("vessel.stl", DICOM, "an image (DICOM)"),
        ("vessel.vtp", NIFTI, "an image (NIfTI)"),
    ],
)
def test_an_image_is_called_one_with_what_to_do(tmp_path, name, data, words):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as said:
        read_surface(tmp_path / name)
    assert f"{name}: expected a mesh or a line, got {words}; " in str(said.value)
    todo = "Segmentations" if "segmentation" in words else "Segment Editor"
    assert f"in 3D Slicer{', ' if todo == 'Segmentations' else ': '}{todo}" in str(said.value)
    assert "model (.vtp)" in str(said.value)


def test_images_of_vtk_and_folders_of_dicom_are_called_so(tmp_path):
    path = written(vtkXMLImageDataWriter(), tmp_path / "a.vti", vtkImage())
    legacy = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
    (tmp_path / "a.vtk").write_text(legacy, encoding="ascii")
    series = tmp_path / "study" / "series"
    series.mkdir(parents=True)
    (series / "IM1").write_bytes(DICOM)
    for one, words in (
        (path, "got an image"),
        (tmp_path / "a.vtk", "got an image"),
        (series, "got a folder of images"),
        (series.parent, "got a folder of images"),
    ):
        with pytest.raises(InputError, match=words):
            read_surface(one)


def test_a_mesh_called_as_an_image_is_named_by_its_content(tmp_path):
    saved(tmp_path / "a.nrrd", a_sphere())
    with pytest.raises(InputError, match=r"got '\.nrrd', a VTK XML file; name it \.vtp"):
        read_surface(tmp_path / "a.nrrd")


def test_a_file_under_another_formats_name_is_named_by_its_content(tmp_path):
    """Every format under the suffix of every other."""
    surface = read_surface(saved(tmp_path / "a.vtp", a_sphere()))
    for suffix in WRITTEN_SUFFIXES:
        write_surface(tmp_path / f"a{suffix}", surface, surface.points)
    written(vtkXMLUnstructuredGridWriter(), tmp_path / "a.vtu", as_grid(a_sphere()))
    written(vtkHDFWriter(), tmp_path / "a.vtkhdf", a_sphere())
    (tmp_path / "a.off").write_text(OFF, encoding="ascii")
    originals = [path for path in sorted(tmp_path.iterdir()) if path.suffix != ".stl"]
    for path in originals:
        for suffix in READ_SUFFIXES:
            wrong = tmp_path / f"wrong{suffix}"
            if suffix == path.suffix or suffix.startswith(".p"):
                continue
            wrong.write_bytes(path.read_bytes())
            with pytest.raises(InputError, match=rf"; name it \{path.suffix}\.") as said:
                read_surface(wrong)
            assert "\n" not in str(said.value)
            wrong.unlink()


def test_what_is_read_only_is_written_under_another_suffix(tmp_path):
    surface = read_surface(saved(tmp_path / "a.vtp", a_sphere()))
    for suffix in set(READ_SUFFIXES) - set(WRITTEN_SUFFIXES):
        with pytest.raises(InputError, match=r"ends in \.vtp, .*; rename it"):
            write_surface(tmp_path / f"out{suffix}", surface, surface.points)
        assert not (tmp_path / f"out{suffix}").exists()


def test_the_documents_and_the_help_name_the_formats_of_the_table():
    text = (PROJECT / "docs" / "files.md").read_text(encoding="utf-8")
    text = text.split("\n## Centerlines\n")[0]
    rows = re.findall(r"^\| (`\..*?) \| .* \| (yes|no) \|$", text, re.MULTILINE)
    listed = {suffix: said == "yes" for cell, said in rows for suffix in re.findall(r"\.\w+", cell)}
    assert listed == {one.suffix: one.is_written for one in SURFACE_FORMATS}
    assert FORMATS_IN_WORDS in " ".join(SURFACE.split())
    assert written_suffix(".STL") == ".STL"
    assert written_suffix(".vtu") == ".vtp"


def test_a_plan_of_a_file_that_is_only_read_writes_the_usual_format(tmp_path, monkeypatch, capsys):
    tube = stenosed_tube()
    wall = polydata_from_arrays(tube.points, tube.triangles)
    written(vtkXMLUnstructuredGridWriter(), tmp_path / "a.vtu", as_grid(wall))
    line = polydata_from_lines(tube.centerline.points, [np.arange(len(tube.centerline.points))])
    saved(tmp_path / "line.vtp", line)
    monkeypatch.chdir(tmp_path)
    stent = ["--center", *map(str, tube.centerline.points[len(tube.centerline.points) // 2])]
    words = ["deploy", "a.vtu", "--centerline", "line.vtp", *stent, "--length", "12"]
    words += ["--diameter", "6", "--save-plan", "plan.json", "--quiet"]
    assert main([*words, "-o", "out.vtu"]) == 2
    assert "expected a surface that ends in .vtp" in capsys.readouterr().err
    assert main([*words, "-o", "out.stl"]) == 0
    assert main(["run", "plan.json", "-o", "again", "--quiet"]) == 0
    assert (tmp_path / "again" / "a_stented.vtp").is_file()
    stented = read_surface("again/a_stented.vtp").points
    assert np.array_equal(read_surface("out.stl").points.shape, stented.shape)
