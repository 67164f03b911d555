"""Deployed surfaces as files: everything but the moved points is kept, bit by bit."""

import numpy as np
import pytest
from child_processes import python
from mesh_files import octahedron
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIntArray, vtkStringArray

from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.field import CapsuleChain
from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
    set_face_names,
    set_frame_of_polydata,
    write_surface,
)
from SDFStentLib.files.plain.stl import encode_solids
from SDFStentLib.geometry import vertex_normals
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import branch_names, find_lesions

MOVED = np.array([4, 17])


def rich_surface(folder, kind=np.float32, frame="LPS"):
    """A surface in centimeters with arrays of many types."""
    points, triangles = octahedron()
    polydata = polydata_from_arrays((points / 10).astype(kind), triangles)
    count = len(points)
    add_arrays(
        polydata,
        {
            "GlobalNodeID": np.arange(count, dtype=np.int32),
            "Pressure": np.linspace(0, 1, count),
            "name": np.array([f"Gefäß {i}" for i in range(count)]),
            "Normals": vertex_normals(points, triangles).astype(np.float32),
        },
        {"ModelFaceID": np.arange(len(triangles), dtype=np.int32) % 5},
    )
    ids = numpy_to_vtk(np.arange(len(triangles), dtype=np.int64) + 7, deep=True)
    ids.SetName("GlobalElementID")
    polydata.GetCellData().SetGlobalIds(ids)
    polydata.GetPointData().SetActiveScalars("Pressure")
    patient, year = vtkStringArray(), vtkIntArray()
    for array, name, value in ((patient, "patient", "Müller"), (year, "year", 1999)):
        array.SetName(name)
        array.InsertNextValue(value)
        polydata.GetFieldData().AddArray(array)
    set_frame_of_polydata(polydata, frame)
    path = folder / "rich.vtp"
    path.write_bytes(encode_vtp(polydata))
    return read_surface(path, "cm")


def array_bits(polydata, skipped=()):
    """Name, class and values of every array, to be compared."""
    found = {}
    for kind in ("PointData", "CellData", "FieldData"):
        data = getattr(polydata, f"Get{kind}")()
        for index in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(index)
            values = [str(array.GetVariantValue(i)) for i in range(array.GetNumberOfValues())]
            if array.GetName() not in skipped:
                key = (kind, array.GetName())
                found[key] = (array.GetDataTypeAsString(), array.GetNumberOfComponents(), values)
    return found


def moved(surface):
    points = surface.points.copy()
    points[MOVED] += 1
    return points


def coordinates(polydata):
    return vtk_to_numpy(polydata.GetPoints().GetData())


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("suffix", ["vtp", "vtk"])
def test_everything_but_the_moved_points_is_kept_bit_by_bit(tmp_path, kind, suffix):
    surface = rich_surface(tmp_path, kind)
    path = tmp_path / f"Größe neu.{suffix}"
    assert write_surface(path, surface, moved(surface)) == ()
    again = read_surface(path, "cm")
    before, after = surface.polydata(), again.polydata()
    kept = np.setdiff1d(np.arange(len(surface.points)), MOVED)
    assert coordinates(after).dtype == kind
    assert coordinates(after)[kept].tobytes() == coordinates(before)[kept].tobytes()
    expected = ((surface.points[MOVED] + 1) / 10).astype(kind)
    assert np.array_equal(coordinates(after)[MOVED], expected)
    assert np.array_equal(again.points[MOVED], surface.as_stored(surface.points[MOVED] + 1))
    assert np.array_equal(again.triangles, surface.triangles)
    assert again.frame == surface.frame == "LPS"
    assert array_bits(after, ["Normals"]) == array_bits(before, ["Normals"])
    assert after.GetCellData().GetGlobalIds().GetName() == "GlobalElementID"
    assert after.GetPointData().GetScalars().GetName() == "Pressure"


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj"])
def test_plain_formats_keep_the_mesh_and_the_tag_and_name_what_they_lose(tmp_path, suffix):
    surface = rich_surface(tmp_path)
    path = tmp_path / f"a b.{suffix}"
    (said,) = write_surface(path, surface, moved(surface))
    assert f".{suffix} cannot keep the arrays" in str(said)
    assert "name" in str(said)
    assert "patient" in str(said)
    assert "SPACE" not in str(said)
    assert ("Pressure" in str(said)) == (suffix != "ply")
    again = read_surface(path, "cm")
    corners = again.points[again.triangles]
    # One rounding to single precision of numbers up to 4 cm.
    assert np.abs(corners - moved(surface)[surface.triangles]).max() < 10 * 4 * 2**-24
    assert len(again.points) == len(surface.points)
    assert again.frame == "LPS"


def test_a_file_without_a_tag_is_written_without(tmp_path):
    surface = rich_surface(tmp_path, frame=None)
    for suffix in ("vtp", "vtk", "stl", "ply", "obj"):
        path = tmp_path / f"a.{suffix}"
        write_surface(path, surface, surface.points)
        assert b"SPACE" not in path.read_bytes()
        assert read_surface(path, "cm").frame is None


def test_more_arrays_can_be_written(tmp_path):
    surface = rich_surface(tmp_path)
    stretch = np.linspace(1, 2, len(surface.triangles))
    displacement = np.ones_like(surface.points)
    path = tmp_path / "b.vtp"
    arrays = {"Displacement": displacement}, {"AreaStretch": stretch}
    write_surface(path, surface, surface.points, *arrays)
    polydata = read_surface(path, "cm").polydata()
    assert np.array_equal(vtk_to_numpy(polydata.GetCellData().GetArray("AreaStretch")), stretch)
    assert np.array_equal(
        vtk_to_numpy(polydata.GetPointData().GetArray("Displacement")), displacement
    )
    with pytest.raises(InputError, match="cell array a: expected 128 rows"):
        write_surface(path, surface, surface.points, None, {"a": np.zeros(3)})


def test_unfit_points_are_refused_and_nothing_is_written(tmp_path):
    surface = rich_surface(tmp_path)
    path = tmp_path / "b.vtp"
    for points, words in (
        (surface.points[1:], "points: expected the 66 of the surface, got 65"),
        (surface.points * np.nan, "points: expected finite"),
    ):
        with pytest.raises(InputError, match=words):
            write_surface(path, surface, points)
    assert not path.exists()


def test_a_full_disk_is_said_and_the_old_file_stays(tmp_path):
    surface = rich_surface(tmp_path)
    paths = [tmp_path / f"out.{suffix}" for suffix in ("vtp", "vtk", "stl", "ply", "obj")]
    for path in paths:
        path.write_bytes(b"old")
    script = """
import resource, sys
from SDFStentLib.files.surface_files import read_surface
from SDFStentLib.files.surface_output import write_surface
surface = read_surface(sys.argv[1], "cm")
resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))
for path in sys.argv[2:]:
    try:
        write_surface(path, surface, surface.points)
    except ValueError as error:
        print(error)
"""
    run = python(script, surface.path, *paths)
    said = run.stdout.splitlines()
    for path, sentence in zip(paths, said, strict=True):
        assert sentence.startswith(str(path))
        assert "cannot be written" in sentence
        assert path.read_bytes() == b"old"
    assert run.stderr == ""
    assert {entry.name for entry in tmp_path.iterdir()} == {"rich.vtp", *(p.name for p in paths)}


# What is promised to whoever types `sdfstent deploy`, as far as no other file shows it.

REACH = 3.0 + 6.5 + 0.4
"""Radius of the stent, influence distance and tissue gap, mm."""


@pytest.fixture(scope="module")
def from_simvascular(tmp_path_factory):
    """A file as SimVascular writes it: cm, single precision, ids of nodes, elements and faces."""
    folder = tmp_path_factory.mktemp("Gefäß im Ordner")
    made = stenosed_tube(edge_length=0.8)
    # Away from the origin, so that single precision shows.
    shift = np.array([11.0, -7.0, 130.0])
    points = ((made.points + shift) / 10).astype(np.float32)
    data = polydata_from_arrays(
        points,
        made.triangles,
        point_arrays={
            "GlobalNodeID": np.arange(1, len(points) + 1, dtype=np.int32),
            "pressure_avg": np.random.default_rng(5).normal(size=len(points)),
            "wss": np.random.default_rng(6).normal(size=(len(points), 3)).astype(np.float32),
        },
        cell_arrays={
            "ModelFaceID": made.face_ids.astype(np.int32),
            "GlobalElementID": np.arange(len(made.triangles), dtype=np.int64)[::-1] + 2**40,
            "CapID": (made.face_ids > 1).astype(np.uint8),
        },
    )
    name, when = vtkStringArray(), numpy_to_vtk(np.array([0.1, 0.2]), deep=True)
    name.SetName("patient")
    name.InsertNextValue("Müller, Jörg")
    when.SetName("TimeValue")
    data.GetFieldData().AddArray(name)
    data.GetFieldData().AddArray(when)
    (folder / "vessel.vtp").write_bytes(encode_vtp(data))
    tree = made.centerline
    line = polydata_from_lines((tree.points + shift) / 10, [np.arange(len(tree.points))])
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius / 10}, {})
    (folder / "line.vtp").write_bytes(encode_vtp(line))
    return folder


def deploy(diameter, out, *more):
    return (
        "deploy", "vessel.vtp", "--units", "cm", "--centerline", "line.vtp",
        "--center", 1.1, -0.7, 15, "--length", 20, "--diameter", diameter, "-o", out, *more,
    )  # fmt: skip


def arrays_of(data):
    """Every array by where it is: its type, its shape and its bits."""
    found = {}
    for part in ("PointData", "CellData", "FieldData"):
        attributes = getattr(data, f"Get{part}")()
        for index in range(attributes.GetNumberOfArrays()):
            array = attributes.GetAbstractArray(index)
            if array.IsNumeric():
                values = vtk_to_numpy(array)
                bits = (values.shape, values.tobytes())
            else:
                bits = tuple(array.GetValue(i) for i in range(array.GetNumberOfValues()))
            found[part, array.GetName()] = (array.GetDataTypeAsString(), bits)
    return found


@pytest.mark.parametrize("more", [(), ("--arrays",)])
def test_deploying_keeps_arrays_ids_and_untouched_points_bit_by_bit(
    shell, from_simvascular, tmp_path, more
):
    out = tmp_path / "out.vtp"
    done = shell(*deploy(6, out, *more), folder=from_simvascular)
    assert done.returncode == 0, done.stderr
    before = read_surface(from_simvascular / "vessel.vtp", "cm")
    after = read_surface(out, "cm")
    old, new = coordinates(before.polydata()), coordinates(after.polydata())

    assert new.dtype == np.float32
    assert new.shape == old.shape
    np.testing.assert_array_equal(after.triangles, before.triangles)
    kept = arrays_of(after.polydata())
    added = set(kept) - set(arrays_of(before.polydata()))
    assert {key: kept[key] for key in kept if key not in added} == arrays_of(before.polydata())
    assert {name for _, name in added} == (
        {"Displacement", "AreaStretch", "PrincipalStretchMax", "PrincipalStretchMin"}
        if more
        else set()
    )

    # The stent of 20 mm loses a tenth of its length; its middle is the throat.
    axis = np.array([[11.0, -7, 141], [11, -7, 159]])
    away = CapsuleChain.along(axis).axis_distance(before.points)
    assert new[away > REACH].tobytes() == old[away > REACH].tobytes()
    changed = (new != old).any(axis=1)
    assert 0 < changed.sum() < len(old)
    if more:
        displacement = vtk_to_numpy(after.polydata().GetPointData().GetArray("Displacement"))
        # Points that the array does not name have their bits, and the others went where it says.
        assert not displacement[~changed].any() or np.abs(displacement[~changed]).max() < 1e-5
        stored = (before.points + displacement) / 10
        # Half a unit in the last place of single precision at 16 cm.
        assert np.abs(stored - new).max() < 1e-6


def told_of(artery, surface):
    """The branches of lesions, and of the tree, by name."""
    found = find_lesions(surface.surface, artery.centerline, surface.faces)
    names = branch_names(surface.surface, artery.centerline, surface.faces)
    return [lesion.branch_name for lesion in found], list(names)


def called(surface):
    """The name of the face of every triangle; None of one without."""
    return [surface.faces.names.get(number) for number in surface.faces.ids.tolist()]


def test_solids_of_an_stl_name_branches_as_the_faces_of_a_vtp_and_come_back(tmp_path):
    artery = branching_pulmonary_artery(edge_length=1.2)
    points, names = artery.points.astype(np.float32), artery.faces.names
    polydata = polydata_from_arrays(
        points, artery.triangles, cell_arrays={"ModelFaceID": artery.face_ids}
    )
    set_face_names(polydata, names)
    set_frame_of_polydata(polydata, "LPS")
    (tmp_path / "a.vtp").write_bytes(encode_vtp(polydata))
    native = read_surface(tmp_path / "a.vtp")
    data = encode_solids(points, artery.triangles, artery.face_ids, names, "SPACE=LPS")
    (tmp_path / "a.stl").write_bytes(data)
    solids = read_surface(tmp_path / "a.stl")
    assert solids.frame == "LPS"
    assert called(solids) == called(native)
    assert told_of(artery, solids) == told_of(artery, native)

    assert write_surface(tmp_path / "again.stl", solids, solids.points) == ()
    assert (tmp_path / "again.stl").read_bytes() == data
    for suffix in (".vtp", ".vtk"):
        write_surface(tmp_path / f"again{suffix}", solids, solids.points)
        again = read_surface(tmp_path / f"again{suffix}")
        assert called(again) == called(solids)
        assert np.array_equal(again.points, solids.points)
    (said,) = write_surface(tmp_path / "again.ply", solids, solids.points)
    assert "ModelFaceNames" in str(said)
    assert np.array_equal(read_surface(tmp_path / "again.ply").faces.ids, solids.faces.ids)
    # Of another format they are not: programs join no points of different solids.
    (said,) = write_surface(tmp_path / "one.stl", native, native.points)
    assert "ModelFaceID" in str(said)
    assert read_surface(tmp_path / "one.stl").faces is None
