import numpy as np
import pytest
from child_processes import python
from mesh_files import octahedron
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIntArray, vtkStringArray

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    read_surface,
    set_frame_of_polydata,
    write_surface,
)
from SDFStentLib.geometry import vertex_normals
from SDFStentLib.validation import InputError

MOVED = np.array([4, 17])


def rich_surface(folder, kind=np.float32, frame="LPS"):
    """A surface in centimetres with arrays of many types."""
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
