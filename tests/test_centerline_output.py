import json

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy

from SDFStentLib.files import (
    add_arrays,
    check_line_output,
    encode_vtp,
    in_frame_of,
    polydata_from_lines,
    read_axis,
    read_lines,
    set_frame_of_polydata,
    write_centerline,
)
from SDFStentLib.files.formats.markups import new_markups
from SDFStentLib.validation import InputError

POINTS = np.array([[i / 3, 0.1 * i * i, 2.0] for i in range(20)])


def line_file(folder, lines=((19, *range(19)), (3, 4)), frame="LPS", kind=np.float64):
    polydata = polydata_from_lines(POINTS.astype(kind), list(lines))
    add_arrays(polydata, {"Radius": np.ones(20)}, {"GroupIds": np.arange(len(lines))})
    set_frame_of_polydata(polydata, frame)
    path = folder / "in.vtp"
    path.write_bytes(encode_vtp(polydata))
    return read_lines(path, "cm")


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("suffix", ["vtp", "vtk"])
@pytest.mark.parametrize("frame", ["LPS", "RAS", None])
def test_moved_points_are_written_and_the_rest_is_kept(tmp_path, kind, suffix, frame):
    lines = in_frame_of(line_file(tmp_path, kind=kind), frame)
    moved = lines.points.copy()
    moved[5] += 1
    path = tmp_path / f"Mitte neu.{suffix}"
    assert write_centerline(path, lines, moved) == ()
    again = read_lines(path, "cm")
    assert again.frame == "LPS"  # the frame of the file, also if it was turned meanwhile
    before, after = lines.polydata(), again.polydata()
    kept = np.arange(20) != 5
    coordinates = [vtk_to_numpy(polydata.GetPoints().GetData()) for polydata in (before, after)]
    assert coordinates[1].dtype == kind
    assert coordinates[1][kept].tobytes() == coordinates[0][kept].tobytes()
    rounding = 4 * 30 * np.finfo(kind).eps
    assert np.abs(in_frame_of(again, frame).points - moved).max() < rounding
    assert [line.tolist() for line in again.lines] == [line.tolist() for line in lines.lines]
    assert np.array_equal(again.inscribed_radius, lines.inscribed_radius)
    assert vtk_to_numpy(after.GetCellData().GetArray("GroupIds")).tolist() == [0, 1]


def test_a_markups_curve_keeps_its_document(tmp_path):
    path = tmp_path / "c.mrk.json"
    document = json.loads(new_markups(POINTS, "RAS", "mm"))
    document["markups"][0]["display"] = {"color": [1, 0, 0]}
    path.write_text(json.dumps(document), encoding="utf-8")
    lines = read_lines(path)
    out = tmp_path / "moved.mrk.json"
    assert write_centerline(out, lines, lines.points + 1) == ()
    written = json.loads(out.read_text(encoding="utf-8"))
    assert written["markups"][0]["display"] == {"color": [1, 0, 0]}
    assert written["markups"][0]["coordinateSystem"] == "RAS"
    # A spline moved is the spline of the moved control points.
    assert np.abs(read_axis(out) - (lines.points + 1)).max() < 1e-12


def test_curves_and_polydata_become_each_other(tmp_path):
    path = tmp_path / "c.mrk.json"
    path.write_bytes(new_markups(POINTS, "RAS", "mm"))
    lines = read_lines(path)
    assert write_centerline(tmp_path / "c.vtp", lines, lines.points) == ()
    again = read_lines(tmp_path / "c.vtp")
    assert np.array_equal(again.points, lines.points)
    assert again.frame == "RAS"
    (said,) = write_centerline(tmp_path / "d.mrk.json", again, again.points)
    assert "arrays are not kept in .mrk.json" in str(said)
    assert np.array_equal(read_axis(tmp_path / "d.mrk.json")[::10], lines.points)


def test_outputs_that_cannot_be_are_refused(tmp_path):
    lines = line_file(tmp_path)
    with pytest.raises(InputError, match="a markups file takes one line, the centerline has 2"):
        write_centerline(tmp_path / "a.mrk.json", lines, lines.points)
    with pytest.raises(InputError, match="points: expected 20, got 3"):
        write_centerline(tmp_path / "a.vtp", lines, lines.points[:3])
    with pytest.raises(InputError, match="got NaN or infinity"):
        write_centerline(tmp_path / "a.vtp", lines, lines.points * np.nan)
    with pytest.raises(InputError, match=r"expected one of \.vtp, \.vtk, \.mrk\.json"):
        check_line_output(tmp_path / "a.stl")
    with pytest.raises(InputError, match="expected an existing folder"):
        check_line_output(tmp_path / "none" / "a.vtp")
    assert [entry.name for entry in tmp_path.iterdir()] == ["in.vtp"]
