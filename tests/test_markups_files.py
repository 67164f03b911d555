import json

import numpy as np
import pytest

from SDFStentLib.files.content import FileContent
from SDFStentLib.files.formats.markups import decode_markups, encode_markups
from SDFStentLib.validation import InputError

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
