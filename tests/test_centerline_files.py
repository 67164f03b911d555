import json

import numpy as np
import pytest
from mesh_files import assert_refused_by_name, octahedron

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    in_frame_of,
    polydata_from_arrays,
    polydata_from_lines,
    read_axis,
    read_centerline,
    read_lines,
    set_frame_of_polydata,
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


def test_a_markups_file_that_names_another_unit_is_believed(tmp_path):
    path = tmp_path / "c.mrk.json"
    path.write_bytes(new_markups(POINTS, "RAS", "cm"))
    lines = read_lines(path)
    assert lines.units == "cm"
    assert np.array_equal(lines.points[::10], 10 * POINTS)
    assert "it says that it is in cm, not mm" in str(lines.warnings[0])
    path.write_bytes(new_markups(POINTS, "RAS", "um"))
    with pytest.raises(InputError, match="expected mm, cm or m, got 'um'"):
        read_lines(path)


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
    (tmp_path / "points.vtp").write_bytes(encode_vtp(polydata_from_arrays(*octahedron())))
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
        ("c.csv", "expected a centerline as .vtp, .vtk, .mrk.json, got '.csv'"),
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
