"""Centerlines, axes and markups from files and into them: units, frames and what is refused."""

import json

import numpy as np
import pytest
from mesh_files import assert_refused_by_name, octahedron
from tube_files import write_wall
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from SDFStentLib.files import (
    add_arrays,
    check_line_output,
    encode_vtp,
    in_frame_of,
    polydata_from_lines,
    read_axis,
    read_centerline,
    read_lines,
    set_frame_of_polydata,
    write_centerline,
)
from SDFStentLib.files.content import FileContent
from SDFStentLib.files.formats.markups import decode_markups, encode_markups, new_markups
from SDFStentLib.validation import InputError

POINTS = np.array([[i, 0.1 * i * i, 2.0] for i in range(20)])


def saved(folder, lines, name="c.vtp", frame=None, points=POINTS, radius=None):
    polydata = polydata_from_lines(points, lines)
    set_frame_of_polydata(polydata, frame)
    if radius is not None:
        add_arrays(polydata, radius, None)
    path = folder / name
    path.write_bytes(encode_vtp(polydata))
    return path


def test_an_axis_runs_as_its_cell_says(tmp_path):
    path = saved(tmp_path, [np.arange(20)[::-1]])
    assert np.array_equal(read_axis(path), POINTS[::-1])
    with pytest.raises(InputError, match="expected one line as axis, got 2"):
        read_axis(saved(tmp_path, [[0, 1, 2], [2, 3]]))


@pytest.mark.parametrize("label", ["cm", "m", "um", ["cm", "UCUM", "centimeter"]])
def test_the_unit_that_a_markups_file_names_is_one_of_the_screen(tmp_path, label):
    """Slicer 5.12 writes positions in mm whatever unit its scene is shown in."""
    path = tmp_path / "c.mrk.json"
    path.write_bytes(new_markups(POINTS, "RAS", label))
    lines = read_lines(path)
    assert np.array_equal(lines.points[::10], POINTS)
    (said,) = lines.warnings
    unit = label if isinstance(label, str) else label[0]
    assert f"it names {unit}, the unit of the screen; its positions were read in mm" in str(said)
    assert np.array_equal(read_lines(path, "cm").points[::10], 10 * POINTS)
    path.write_bytes(new_markups(POINTS, "RAS", "mm"))
    assert read_lines(path).warnings == ()


UNPLACED = (
    {"position": "", "positionStatus": "missing"},
    {"position": "", "positionStatus": "undefined"},
    {"position": [9.0, 9.0, 9.0], "positionStatus": "preview"},
    {"position": ""},
    {"positionStatus": "undefined"},
)


@pytest.mark.parametrize("unplaced", UNPLACED)
def test_points_of_a_curve_that_were_not_placed_are_left_out(tmp_path, unplaced):
    path = tmp_path / "c.mrk.json"
    document = json.loads(new_markups(POINTS, "RAS", "mm"))
    controls = document["markups"][0]["controlPoints"]
    controls[3:3] = [unplaced]
    path.write_text(json.dumps(document), encoding="utf-8")
    lines = read_lines(path)
    assert np.array_equal(lines.points[::10], POINTS)
    write_centerline(tmp_path / "d.mrk.json", lines, lines.points + 1.0)
    moved = json.loads((tmp_path / "d.mrk.json").read_bytes())["markups"][0]["controlPoints"]
    assert moved.pop(3) == unplaced
    assert np.array_equal([one["position"] for one in moved], POINTS + 1.0)


PTH = """<?xml version="1.0" encoding="UTF-8" ?>
<format version="1.0" />
<path id="1" method="0" calculation_number="100" spacing="0">
  <timestep id="0">
    <path_element method="0" calculation_number="100" spacing="0">
      <control_points><point id="0" x="0" y="0" z="0" /><point id="1" x="9" y="0" z="0" /></control_points>
      <path_points>
        <path_point id="0"><pos x="0" y="0" z="0" /><tangent x="1" y="0" z="0" /></path_point>
        <path_point id="1"><pos x="4.5" y="0.5" z="0" /><tangent x="1" y="0" z="0" /></path_point>
        <path_point id="2"><pos x="9" y="0" z="0" /><tangent x="1" y="0" z="0" /></path_point>
      </path_points>
    </path_element>
  </timestep>
</path>
"""  # noqa: E501


def test_a_path_of_simvascular_is_a_line(tmp_path):
    path = tmp_path / "aorta.pth"
    path.write_text(PTH, encoding="utf-8")
    lines = read_lines(path, "cm")
    assert lines.points.tolist() == [[0, 0, 0], [45, 5, 0], [90, 0, 0]]
    assert lines.frame is None
    assert lines.centerline().points[0].tolist() == [0, 0, 0]
    assert write_centerline(tmp_path / "out.vtp", lines, lines.points + 1.0) == ()
    again = read_lines(tmp_path / "out.vtp", "cm")
    np.testing.assert_allclose(again.points, lines.points + 1.0)
    for text, words in (
        (PTH[:400], "expected a path of SimVascular .* cut short"),
        (PTH.replace("4.5", "far"), "expected points with numbers as x, y and z"),
        ("<format version='1.0' /><path/>", "two points or more, got 0"),
        ("<!DOCTYPE a>" + PTH, "got XML with a DTD"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=words):
            read_lines(path)
    with pytest.raises(InputError, match=r"expected one of .* to write"):
        write_centerline(tmp_path / "out.pth", lines, lines.points)


FCSV = """# Markups fiducial file version = 5.11
# CoordinateSystem = LPS
# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID
1,1,2,3,0,0,0,1,1,1,0,F-1,,,2,0
2,7,7,7,0,0,0,1,1,1,0,"F, 2",,,{status},0
3,4,5,6,0,0,0,1,1,1,0,F-3,,
"""


@pytest.mark.parametrize(("status", "is_placed"), [(0, False), (1, False), (2, True), (3, False)])
def test_placed_points_of_a_list_of_slicer_are_a_line(tmp_path, status, is_placed):
    path = tmp_path / "points.fcsv"
    path.write_text(FCSV.replace("{status}", str(status)), encoding="utf-8")
    lines = read_lines(path)
    wanted = [[1, 2, 3], *([[7, 7, 7]] if is_placed else []), [4, 5, 6]]
    assert lines.points.tolist() == wanted
    assert lines.frame == "LPS"
    path.write_text(FCSV.replace("LPS", "0"), encoding="utf-8")
    assert read_lines(path).frame == "RAS"
    for text, words in (
        (FCSV.replace("columns", "fields"), "expected a list of points as Slicer writes it"),
        (FCSV.replace("4,5,6", "4,b,6"), "expected numbers as x, y and z of every point"),
        ("\n".join(FCSV.splitlines()[:4]), "two points or more, got 1"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=words):
            read_lines(path)


@pytest.mark.parametrize("suffix", [".vtp", ".vtk"])
def test_vmtk_s_networks_have_one_radius_more_than_points_and_are_whole(tmp_path, suffix):
    path = tmp_path / f"n{suffix}"
    polydata = polydata_from_lines(POINTS, [np.arange(20)])
    radius = numpy_to_vtk(np.r_[0.0, np.arange(1.0, 20.0), 77.0], deep=True)
    radius.SetName("Radius")
    polydata.GetPointData().AddArray(radius)
    # VTK's own writers keep the value that is too many.
    writer = vtkXMLPolyDataWriter() if suffix == ".vtp" else vtkPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(polydata)
    assert writer.Write()
    found = read_lines(path).inscribed_radius
    np.testing.assert_array_equal(found, [np.nan, *range(1, 20)])


def test_frames_are_brought_together_where_both_are_known(tmp_path):
    lines = read_lines(saved(tmp_path, [np.arange(20)], frame="LPS"))
    assert in_frame_of(lines, None) is lines
    assert in_frame_of(lines, "LPS") is lines
    turned = in_frame_of(lines, "RAS")
    assert np.array_equal(turned.points, POINTS * (-1, -1, 1))
    assert (turned.frame, turned.file_frame) == ("RAS", "LPS")
    assert "it is in LPS, the surface in RAS; its x and y were negated" in str(turned.warnings[0])
    assert np.array_equal(in_frame_of(turned, "LPS").points, POINTS)
    unknown = read_lines(saved(tmp_path, [np.arange(20)]))
    assert in_frame_of(unknown, "RAS") is unknown


def test_the_polydata_is_a_copy_in_unit_and_frame_of_the_file(tmp_path):
    vtp = saved(tmp_path, [np.arange(20)], frame="LPS")
    markups = tmp_path / "c.mrk.json"
    markups.write_bytes(new_markups(POINTS, "LPS", "cm"))
    for path, step in ((vtp, 1), (markups, 10)):
        polydata = in_frame_of(read_lines(path, "cm"), "RAS").polydata()
        # Times ten and back is exact to the last bit but one.
        assert np.allclose(polydata.GetPoint(3 * step), POINTS[3], rtol=1e-15)
        assert polydata.GetNumberOfLines() == 1


def test_bad_files_give_one_sentence_with_their_name(tmp_path):
    write_wall(tmp_path / "points.vtp", *octahedron())
    saved(tmp_path, [[3]], "one.vtp")
    saved(tmp_path, [[3, 3]], "same.vtp")
    saved(tmp_path, [[0, 1]], "nan.vtp", points=np.eye(3))
    bad = polydata_from_lines(np.eye(3), [[0, 1]])
    bad.GetPoints().SetPoint(0, float("inf"), 0, 0)
    (tmp_path / "nan.vtp").write_bytes(encode_vtp(bad))
    (tmp_path / "c.csv").write_text("1,2,3", encoding="utf-8")
    (tmp_path / "cut.vtp").write_bytes(saved(tmp_path, [[0, 1]]).read_bytes()[:-40])
    (tmp_path / "c.json").write_text(json.dumps({"schema": 1}), encoding="utf-8")
    for name, words in (
        ("points.vtp", "expected a centerline of lines, got 66 points without a line"),
        ("one.vtp", "at least two different points, got one point"),
        ("same.vtp", "at least two different points, got one point"),
        ("nan.vtp", "got NaN or infinity"),
        ("c.csv", "expected a centerline as .vtp, .vtk, .mrk.json, .pth or .fcsv, got '.csv'"),
        ("cut.vtp", "its end is missing"),
        ("c.json", "expected a markups file with a curve"),
        ("missing.vtp", "no such file"),
        (".", "got a folder"),
    ):
        assert_refused_by_name(read_lines, tmp_path / name, words)
    with pytest.raises(InputError, match="units: expected one of"):
        read_lines(tmp_path / "one.vtp", "ft")


def test_pieces_too_far_apart_name_the_file(tmp_path):
    points = np.concatenate([POINTS, POINTS + 1000])
    path = saved(tmp_path, [np.arange(20), np.arange(20, 40)], points=points)
    with pytest.raises(InputError, match=r"c\.vtp: "):
        read_centerline(path)


# Markups, as Slicer saves them

CONTROL = np.array([[0, 0, 0], [10, 0, 0], [15, 10, 3], [30, 12, 5], [31, 14, 9.0]])


def markup(points=CONTROL, **changes):
    control = [{"id": str(i), "position": list(p)} for i, p in enumerate(np.asarray(points))]
    base = {"type": "Curve", "coordinateSystem": "LPS", "controlPoints": control}
    return base | changes


def positions(*places):
    return [{"position": place} for place in places]


def content(*markups, text=None):
    text = text if text is not None else json.dumps({"markups": list(markups)})
    return FileContent("c.mrk.json", text.encode(), "")


def test_a_curve_is_the_spline_that_slicer_shows():
    """Values of the curve of `vtkMRMLMarkupsCurveNode` in slicer-core 5.12, single precision."""
    (curve,) = decode_markups(content(markup())).curves
    assert len(curve) == 41
    assert np.array_equal(curve[::10], CONTROL)
    shown = [[0.202375, -0.05110714, -0.01494643], [0.764, -0.18171428, -0.05314286]]
    assert np.abs(curve[1:3] - shown).max() < 1e-6  # a single-precision number near 10


def test_a_line_has_two_points_and_two_control_points_are_a_line():
    for kind in ("Line", "Curve"):
        (curve,) = decode_markups(content(markup(CONTROL[:2], type=kind))).curves
        assert np.array_equal(curve, CONTROL[:2])


def test_points_that_are_not_placed_are_skipped_and_stay_when_written():
    one = markup()
    one["controlPoints"].insert(1, {"id": "9", "position": [9, 9, 9], "positionStatus": "preview"})
    one["controlPoints"].append({"id": "8", "positionStatus": "undefined"})
    file = content(one)
    (curve,) = decode_markups(file).curves
    assert np.array_equal(curve[::10], CONTROL)
    written = json.loads(encode_markups([curve + 1], file.data))["markups"][0]["controlPoints"]
    assert [point["id"] for point in written] == ["0", "9", "1", "2", "3", "4", "8"]
    assert written[1]["position"] == [9, 9, 9]
    assert written[2]["position"] == [11, 1, 1]


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (content(text="{"), "expected a markups file"),
        (content(text="[" * 100_000), "expected a markups file"),
        (content(text="[]"), "with a curve, got none"),
        (content(), "with a curve, got none"),
        (content(markup(type="Fiducial")), "got 'Fiducial'"),
        (content(markup(type="ClosedCurve")), "got 'ClosedCurve'"),
        (content(3), "got 3"),
        (content(markup(controlPoints=None)), "expected control points"),
        (content(markup(CONTROL[:1])), "at least two control points, got 1"),
        (content(markup(CONTROL[[0, 0]])), "got one place only"),
        (content(markup([[0, 0, float("nan")], [1, 0, 0]])), "got NaN or infinity"),
        (
            content(markup(controlPoints=[{"position": "abc"}])),
            "three numbers, the one of number 1",
        ),
        (content(markup(controlPoints=[{"position": [0, 0, 1]}, True])), "the one of number 2 is"),
        (content(markup(controlPoints=positions([0, 0, 1], [1, 0]))), "number 2 is none; save"),
        (content(markup(controlPoints=positions([0, 0, 1], [1, 0, True]))), "number 2 is none"),
        (content(markup(coordinateSystem="IJK")), "expected one coordinate system"),
        (content(markup(), markup(coordinateSystem="RAS")), "expected one coordinate system"),
    ],
)
def test_what_is_no_curve_is_said(file, words):
    with pytest.raises(InputError, match=words) as caught:
        decode_markups(file)
    assert "c.mrk.json" in str(caught.value)


# Written with a moved vessel: as polydata and as markups.

STATIONS = np.array([[i / 3, 0.1 * i * i, 2.0] for i in range(20)])


def line_file(folder, lines=((19, *range(19)), (3, 4)), frame="LPS", kind=np.float64):
    polydata = polydata_from_lines(STATIONS.astype(kind), list(lines))
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
    document = json.loads(new_markups(STATIONS, "RAS", "mm"))
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
    path.write_bytes(new_markups(STATIONS, "RAS", "mm"))
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
