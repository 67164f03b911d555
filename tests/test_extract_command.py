"""`sdfstent extract`: the files of a segment, as SimVascular's solvers read them."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from child_processes import PROJECT
from mesh_files import read_vtk
from tube_files import deploy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIntArray
from vtkmodules.vtkCommonDataModel import VTK_TETRA

from benchmarks.phantoms import straight_tube
from SDFStentLib.cli import main
from SDFStentLib.files import (
    MeshComplete,
    VolumeMesh,
    encode_vtp,
    read_surface,
    set_frame_of_polydata,
)
from SDFStentLib.geometry import NamedFaces, signed_volume
from SDFStentLib.validation import InputError

ENDS = ["--from", "0", "0", "0.8", "--to", "0", "0", "3.2"]


def extract(*more, ends=ENDS, surface="tube.vtp", line="line.vtp", out="seg"):
    return main(
        ["extract", surface, "--units", "cm", "--centerline", line, *ends, "-o", out, *more]
    )


def ids(data, name):
    array = (data.GetCellData() if name != "GlobalNodeID" else data.GetPointData()).GetArray(name)
    assert isinstance(array, vtkIntArray), f"{name} is no Int32"
    return vtk_to_numpy(array)


def triangles_of(data):
    return vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def points_of(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def assert_faces_are_the_exterior(folder, names):
    """Every triangle of the exterior lies in one face, with the ids of its points."""
    exterior = read_vtk(folder / "mesh-complete.exterior.vtp")
    points, triangles = points_of(exterior), triangles_of(exterior)
    assert points.dtype == np.float64
    np.testing.assert_array_equal(ids(exterior, "GlobalNodeID"), 1 + np.arange(len(points)))
    found = {path.stem: read_vtk(path) for path in (folder / "mesh-surfaces").iterdir()}
    assert set(found) == set(names)
    rows = []
    for face in found.values():
        nodes = ids(face, "GlobalNodeID") - 1
        np.testing.assert_array_equal(points_of(face), points[nodes])
        rows += nodes[triangles_of(face)].tolist()
        (number,) = np.unique(ids(face, "ModelFaceID"))
        assert (ids(exterior, "ModelFaceID") == number).sum() == len(triangles_of(face))
    assert sorted(rows) == sorted(triangles.tolist())
    walls = read_vtk(folder / "walls_combined.vtp")
    own = [name for name in names if name.startswith(("wall", "closed"))]
    assert len(triangles_of(walls)) == sum(len(triangles_of(found[name])) for name in own)
    return found


def test_a_segment_is_written_with_its_faces_in_cm(a_folder, capsys):
    assert extract() == 0
    said = capsys.readouterr().out.splitlines()
    faces = assert_faces_are_the_exterior(Path("seg/before"), ["inlet", "outlet", "wall"])
    assert points_of(faces["inlet"])[:, 2] == pytest.approx(0.8, abs=1e-7)
    assert points_of(faces["outlet"])[:, 2] == pytest.approx(3.2, abs=1e-7)
    document = json.loads(Path("seg/segment.json").read_text(encoding="utf-8"))
    exterior = read_surface("seg/before/mesh-complete.exterior.vtp", "cm")
    assert set(exterior.faces.names.values()) == {"inlet", "outlet", "wall"}
    wall = read_surface("seg/before/mesh-surfaces/wall.vtp", "cm").faces
    assert set(wall.names.values()) == {"wall"}
    surface = exterior.surface
    volume = signed_volume(surface.points, surface.triangles) / 1000
    assert document["before"]["volume"] == pytest.approx(volume)
    assert document["after"] is None
    assert said[0].startswith(f"Before: {volume:.2f} cm3 of lumen; inlet 0.2")
    assert [face["name"] for face in document["before"]["faces"]] == ["inlet", "outlet", "wall"]
    assert sum(face["area"] for face in document["before"]["faces"]) == pytest.approx(
        area(surface) / 100
    )
    assert main(["check", "seg/before/mesh-complete.exterior.vtp", "--units", "cm", "--quiet"]) == 0


def area(surface):
    first, second, third = surface.points[surface.triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1).sum()


def test_before_and_after_a_stent_lie_in_one_folder(a_folder, capsys):
    assert deploy(diameter="7") == 0
    assert extract("--after", "out.vtp") == 0
    document = json.loads(Path("seg/segment.json").read_text(encoding="utf-8"))
    for name in ("before", "after"):
        faces = assert_faces_are_the_exterior(Path("seg") / name, ["inlet", "outlet", "wall"])
        # The caps of both lie in the same planes.
        for plane, cap in zip(document["planes"], ("inlet", "outlet"), strict=True):
            heights = (points_of(faces[cap]) - plane["origin"]) @ plane["normal"]
            assert np.abs(heights).max() < 1e-6
    assert document["after"]["volume"] > 1.2 * document["before"]["volume"]
    said = capsys.readouterr().out
    assert "Before: " in said
    assert "After: " in said
    # A second run replaces the first, and leaves nothing of it.
    assert extract() == 0
    assert sorted(path.name for path in Path("seg").iterdir()) == ["before", "segment.json"]


def test_a_treated_vessel_in_another_frame_is_a_sentence(a_folder, capsys):
    for name, frame in (("tube.vtp", "RAS"), ("after.vtp", "LPS")):
        data = read_surface("tube.vtp", "cm").polydata()
        set_frame_of_polydata(data, frame)
        Path(name).write_bytes(encode_vtp(data))
    assert extract("--after", "after.vtp") == 2
    assert "after.vtp: expected the frame of tube.vtp, RAS, got LPS" in capsys.readouterr().err
    assert not Path("seg").exists()


@pytest.mark.parametrize(("factor", "moved"), [(10, 0), (0.1, 0), (1, 9)])
def test_a_treated_vessel_that_is_another_one_is_a_sentence(a_folder, capsys, factor, moved):
    """In another unit it was cut, where the planes still met it, and written."""
    treated = read_surface("tube.vtp", "cm").polydata()
    points = vtk_to_numpy(treated.GetPoints().GetData())
    points *= factor
    points += moved
    Path("after.vtp").write_bytes(encode_vtp(treated))
    assert extract("--after", "after.vtp") == 2
    said = capsys.readouterr().err
    assert "treated segment: expected" in said
    assert "give the same vessel after its treatment, in the same unit." in said
    assert not Path("seg").exists()


def meshed(surface):
    tetgen = pytest.importorskip("tetgen")
    mesher = tetgen.TetGen(surface.points, surface.triangles.astype(np.int32))
    return VolumeMesh(*mesher.tetrahedralize(switches="pq1.4YQ")[:2])


@pytest.fixture
def a_segment():
    tube = straight_tube(edge_length=1.5)
    faces = NamedFaces(tube.face_ids, {1: "wall", 2: "inlet", 3: "outlet"})
    return tube.surface, faces


def test_with_a_volume_mesh_every_triangle_names_its_tetrahedron(a_segment, tmp_path):
    surface, faces = a_segment
    volume = meshed(surface)
    MeshComplete(surface, faces, frozenset({1}), volume=volume).write(tmp_path / "mesh")
    written = assert_faces_are_the_exterior(tmp_path / "mesh", ["inlet", "outlet", "wall"])
    grid = read_vtk(tmp_path / "mesh" / "mesh-complete.mesh.vtu")
    np.testing.assert_array_equal(points_of(grid), volume.points / 10)
    tetrahedra = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    np.testing.assert_array_equal(tetrahedra, volume.tetrahedra)
    assert {grid.GetCellType(index) for index in range(len(tetrahedra))} == {VTK_TETRA}
    np.testing.assert_array_equal(ids(grid, "GlobalElementID"), 1 + np.arange(len(tetrahedra)))
    for face in written.values():
        nodes = ids(face, "GlobalNodeID") - 1
        parents = tetrahedra[ids(face, "GlobalElementID") - 1]
        for corners, parent in zip(
            nodes[triangles_of(face)].tolist(), parents.tolist(), strict=True
        ):
            assert set(corners) < set(parent)


def test_the_manual_meshes_a_segment(a_folder, monkeypatch):
    pytest.importorskip("tetgen")
    manual = (PROJECT / "docs" / "cli.md").read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(import tetgen.*?)```", manual, re.S)
    assert extract(out="DIR") == 0
    exec(compile(program, "cli.md", "exec"), {})
    written = assert_faces_are_the_exterior(Path("DIR/solver"), ["inlet", "outlet", "wall"])
    assert all(len(ids(face, "GlobalElementID")) for face in written.values())
    assert len(points_of(read_vtk(Path("DIR/solver/mesh-complete.mesh.vtu")))) > 1000


def test_a_volume_mesh_of_another_surface_is_a_sentence(a_segment, tmp_path):
    surface, faces = a_segment
    volume = meshed(surface)
    moved = surface.with_points(surface.points + 0.1)
    at_wall = (np.sort(volume.tetrahedra)[:, :3] < len(surface.points)).all(axis=1)
    lost = volume._replace(tetrahedra=volume.tetrahedra[~at_wall])
    none = volume._replace(tetrahedra=volume.tetrahedra[:0])
    for one, other in ((moved, volume), (surface, lost), (surface, none)):
        with pytest.raises(InputError, match="expected the points of the surface first"):
            MeshComplete(one, faces, frozenset({1}), volume=other).write(tmp_path / "mesh")
        assert not (tmp_path / "mesh").exists()


WAYS = {
    # Lines that part for 0.1 mm on the way, and a branch that was cut before what it comes from.
    "to a lobe": ["--from", "15.23", "-105.3", "-53.92", "--to", "-31.38", "-92.2", "-58.61"],
    "beyond it": ["--from", "14.14", "-104", "-53.6", "--to", "-49.11", "-69.19", "-65.91"],
}  # fmt: skip


def patient(command, data_dir, *more):
    """What a command does with the paper's patient, 92 outlets."""
    files = [str(data_dir / f"su0243_{name}_mm.vtp") for name in ("surface", "centerline")]
    return main([command, files[0], "--centerline", files[1], *more])


@pytest.mark.parametrize("way", ["to a lobe", pytest.param("beyond it", marks=pytest.mark.bench)])
def test_side_branches_of_a_stented_tree_are_closed_by_the_same_planes_and_named(
    data_dir, a_folder, capsys, way
):
    stent = ["--center", "-9.7", "-95.4", "-59", "--diameter", "14", "--length", "12"]
    assert patient("deploy", data_dir, *stent, "-o", "after.vtp") == 0
    capsys.readouterr()
    more = ["--close-branches", "--after", "after.vtp", "-o", "seg"]
    assert patient("extract", data_dir, *WAYS[way], *more) == 0
    said = capsys.readouterr()
    assert said.err == ""
    document = json.loads(Path("seg/segment.json").read_text(encoding="utf-8"))
    for state in ("before", "after"):
        faces = document[state]["faces"]
        assert_faces_are_the_exterior(Path("seg") / state, [face["name"] for face in faces])
        kinds = [face["kind"] for face in faces]
        assert kinds.count("inlet") == kinds.count("outlet") == 1
    assert document["after"]["volume"] > 1.02 * document["before"]["volume"]
    closed = [plane["branch"] for plane in document["planes"] if plane["closed"]]
    assert len(closed) > 2
    # "branch 157 (2 outlets)" told nobody which.
    by_size = re.compile(r"branch \d+ of [\d.]+ mm from \d+ mm on \(\d+ outlets\)$")
    assert all(by_size.match(one) for one in closed if "outlets" in one)
    assert any("outlets" in one for one in closed)
    assert said.out.startswith(f"Closed {len(closed)} of its branches: {'; '.join(closed)}.\n")
