import os

import pytest

from SDFStentLib.files.content import frame_in_text, header_text, read_content
from SDFStentLib.units import as_frame, millimeters_per
from SDFStentLib.validation import InputError


def test_what_is_no_file_is_said(tmp_path):
    (tmp_path / "empty").write_bytes(b"")
    os.mkfifo(tmp_path / "pipe")
    for name, words in (
        ("missing", "no such file"),
        (".", "got a folder"),
        ("empty", "got an empty file"),
        ("pipe", "got a device or a pipe"),
        ("x" * 300, "cannot be read"),
    ):
        with pytest.raises(InputError, match=words):
            read_content(tmp_path / name)


def test_units_are_three():
    assert [millimeters_per(units) for units in ("mm", "cm", "m")] == [1, 10, 1000]
    for units in ("inch", None, ["mm"]):
        with pytest.raises(InputError, match="units: expected one of mm, cm, m"):
            millimeters_per(units)


def test_frames_are_found_in_headers_and_as_old_numbers():
    assert as_frame(" ras ") == as_frame("0") == "RAS"
    assert as_frame("LPS") == as_frame("1") == "LPS"
    assert as_frame("IJK") is None
    assert frame_in_text("3D Slicer output. SPACE=LPS") == "LPS"
    assert frame_in_text("vtk output") is None
    for frame in ("RAS", "LPS", None):
        assert frame_in_text(header_text(frame)) == frame
