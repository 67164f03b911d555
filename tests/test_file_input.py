import hashlib
import os

import pytest

from SDFStentLib.files.content import frame_in_text, header_text, read_content
from SDFStentLib.units import as_frame, millimeters_per
from SDFStentLib.validation import InputError


def test_the_hash_is_that_of_the_bytes(tmp_path):
    path = tmp_path / "a.VTP"
    path.write_bytes(b"some bytes")
    content = read_content(path)
    assert content.sha256 == hashlib.sha256(b"some bytes").hexdigest()
    assert content.suffix == ".vtp"


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


def test_a_file_that_may_not_be_read_is_said(tmp_path, monkeypatch):
    path = tmp_path / "a.stl"
    path.write_bytes(b"x")

    def refuse(_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(path), "read_bytes", refuse)
    with pytest.raises(InputError, match=r"cannot be read \(Permission denied\)"):
        read_content(path)


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
