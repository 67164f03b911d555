"""Outputs appear together or not at all, and never over each other or over an input."""

import os
import signal
from contextlib import suppress

import pytest
from test_output_set import everything_in

from SDFStentLib.cli.outputs import Outputs
from SDFStentLib.cli.signals import interruptions
from SDFStentLib.validation import InputError


def writing(text):
    def write(path):
        path.write_text(text, encoding="utf-8")

    return write


def a_folder_of(text):
    def write(path):
        path.mkdir()
        (path / "step_0000.vtp").write_text(text, encoding="utf-8")

    return write


def is_step(name):
    return name.startswith("step_")


def test_no_input_may_lie_in_a_folder_that_is_replaced(tmp_path):
    (tmp_path / "steps").mkdir()
    source = tmp_path / "steps" / "step_0000.vtp"
    source.write_text("input", encoding="utf-8")
    with pytest.raises(InputError, match=r"steps alone.*got one with step_0000\.vtp"):
        Outputs([source]).add_folder(tmp_path / "steps", a_folder_of("new"), is_step)


def test_a_mount_point_is_said_before_anything_is_computed(tmp_path, monkeypatch):
    (tmp_path / "disk").mkdir()
    monkeypatch.setattr(os.path, "ismount", lambda path: str(path).endswith("disk"))
    with pytest.raises(InputError, match="got a mount point; name a folder in it"):
        Outputs().add_folder(tmp_path / "disk", a_folder_of("new"), is_step)


@pytest.mark.parametrize("failing", range(4))
@pytest.mark.parametrize(
    "error", [PermissionError(1, "Operation not permitted"), KeyboardInterrupt()]
)
def test_when_one_output_cannot_be_moved_all_keep_their_old_state(
    tmp_path, monkeypatch, failing, error
):
    (tmp_path / "steps").mkdir()
    (tmp_path / "steps" / "step_0000.vtp").write_text("old", encoding="utf-8")
    for name in ("old.vtp", "figure.png"):
        (tmp_path / name).write_text("old", encoding="utf-8")
    before = everything_in(tmp_path)
    outputs = Outputs()
    outputs.add(tmp_path / "new.vtp", writing("new"))
    outputs.add(tmp_path / "old.vtp", writing("new"))
    outputs.add(tmp_path / "figure.png", lambda path: None, may_be_missing=True)
    outputs.add_folder(tmp_path / "steps", a_folder_of("new"), is_step)
    plain, moves = os.replace, []

    def replace(source, target):
        # Moves out of a staging folder into place; what is put aside or back does not count.
        if os.path.basename(os.path.dirname(source)) == "new":
            moves.append(target)
            if len(moves) == failing + 1:
                raise error
        plain(source, target)

    monkeypatch.setattr(os, "replace", replace)
    if failing == 3:  # one of the four is only taken away: all three moves succeed
        outputs.write()
        after = {"new.vtp": "new", "old.vtp": "new", "steps/step_0000.vtp": "new"}
        assert everything_in(tmp_path) == after
        return
    with pytest.raises((InputError, KeyboardInterrupt)):
        outputs.write()
    assert everything_in(tmp_path) == before


def test_the_old_state_comes_back_without_hard_links_as_well(tmp_path, monkeypatch):
    (tmp_path / "a.vtp").write_text("old", encoding="utf-8")
    outputs = Outputs()
    outputs.add(tmp_path / "a.vtp", writing("new"))
    outputs.add(tmp_path / "b.vtp", writing("new"))
    plain = os.replace

    def no_link(*_):
        raise OSError(95, "Operation not supported")

    def replace(source, target):
        if str(target).endswith("b.vtp"):
            raise OSError(5, "Input/output error")
        plain(source, target)

    monkeypatch.setattr(os, "link", no_link)
    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(InputError, match=r"b\.vtp: cannot be written \(Input/output error\)"):
        outputs.write()
    assert everything_in(tmp_path) == {"a.vtp": "old"}


def test_an_interruption_that_python_lost_counts_before_anything_is_written(tmp_path):
    outputs = Outputs()
    outputs.add(tmp_path / "out.txt", lambda path: path.write_text("x", encoding="utf-8") and None)
    # A test run in the background of a script ignores the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with interruptions():
            with suppress(KeyboardInterrupt):
                signal.getsignal(signal.SIGINT)(signal.SIGINT, None)
            with pytest.raises(KeyboardInterrupt):
                outputs.write()
    finally:
        signal.signal(signal.SIGINT, before)
    assert list(tmp_path.iterdir()) == []
