import os
import stat

import pytest
from child_processes import python

from SDFStentLib.files import atomic_path, check_writable, write_bytes
from SDFStentLib.validation import InputError


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


def test_a_new_file_has_the_usual_permissions(tmp_path):
    write_bytes(tmp_path / "ours", b"")
    (tmp_path / "theirs").write_bytes(b"")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "theirs").stat().st_mode


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


def test_a_full_disk_is_one_sentence_and_leaves_the_old_file(tmp_path):
    # A limit on the size of files fails in the same place as a full disk.
    target = tmp_path / "out"
    target.write_bytes(b"old")
    script = """
import resource, sys
from SDFStentLib.files.atomic import write_bytes
from SDFStentLib.validation import InputError
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_bytes(sys.argv[1], b"x" * 100_000)
except InputError as error:
    print(error)
"""
    run = python(script, target)
    assert "cannot be written (File too large); free space" in run.stdout
    assert target.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [target]
