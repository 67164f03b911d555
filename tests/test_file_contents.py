"""Files as bytes: their names, frames and numbers, and how they are written whole or not at all."""

import os
import stat

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from SDFStentLib.files import atomic_path, check_writable, write_bytes
from SDFStentLib.files.content import read_content
from SDFStentLib.files.formats.text_numbers import numbers_in
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


# Numbers in text: every word a number, or an error.


KINDS = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_limits_of_every_integer_type_come_back_and_one_more_does_not(kind):
    limits = np.iinfo(kind)
    for value in (limits.min, limits.max, 0):
        assert numbers_in(f" {value} 1\n".encode(), kind).tolist() == [value, 1]
    for value in (limits.min - 1, limits.max + 1, 10**30):
        with pytest.raises(ValueError, match=r"beyond|word|data"):
            numbers_in(f"1 {value}".encode(), kind)


@given(some.lists(some.floats(allow_nan=False)))
def test_written_floats_come_back_bit_by_bit(values):
    text = " ".join(map(repr, values)).encode()
    assert numbers_in(text, np.float64).tobytes() == np.array(values, float).tobytes()


@given(some.lists(some.text(alphabet="0123456789+-.eExna_ ,\n", max_size=6), max_size=5))
def test_what_is_read_is_what_python_reads_word_by_word(words):
    text = " ".join(words)
    try:
        expected = [float(word) for word in text.split() if "_" not in word or 1 / 0]
    except (ValueError, ZeroDivisionError):
        expected = None
    try:
        found = numbers_in(text.encode(), np.float64).tolist()
    except ValueError:
        found = None
    assert (found is None) == (expected is None)
    assert found is None or np.array_equal(found, expected, equal_nan=True)


def test_a_failing_block_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "out.json"
    target.write_bytes(b"old")

    def write_half():
        with atomic_path(target) as temporary:
            temporary.write_bytes(b"half")
            raise KeyError("stop")

    with pytest.raises(KeyError, match="stop"):
        write_half()
    assert target.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_link_stays_a_link_and_permissions_stay(tmp_path):
    target, link = tmp_path / "real", tmp_path / "link"
    target.write_bytes(b"old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_bytes(link, b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_places_that_cannot_be_written_are_named(tmp_path):
    with pytest.raises(InputError, match="got a folder"):
        check_writable(tmp_path)
    with pytest.raises(InputError, match="expected an existing folder"):
        check_writable(tmp_path / "none" / "out")
    with pytest.raises(InputError, match="cannot be written"):
        check_writable("nul\0l")
    with pytest.raises(InputError, match="cannot be written"):
        write_bytes(tmp_path / ("x" * 300), b"")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="a device or a pipe"):
        check_writable(tmp_path / "pipe")


def test_a_folder_without_permission_is_named(tmp_path, monkeypatch):
    # As root every folder can be written, so the answer of the system is replaced.
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match="no permission to write"):
        check_writable(tmp_path / "out")
