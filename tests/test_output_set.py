"""A set of outputs changes together, wherever its run is killed; the next run cleans up."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys

import pytest
from child_processes import PROJECT, python

from SDFStentLib.cli.outputs import Outputs
from SDFStentLib.files import output_set
from SDFStentLib.validation import InputError

pytest.importorskip("fcntl", reason="what killed runs leave is swept where files can be locked")

WRITER = """
import os, sys
from pathlib import Path
from SDFStentLib.files import output_set
from SDFStentLib.cli.outputs import Outputs
folder, at = Path(sys.argv[1]), int(sys.argv[2])
calls = 0
def dying(function):
    def call(*arguments, **named):
        global calls
        calls += 1
        if calls == at:
            os.kill(os.getpid(), 9)
        return function(*arguments, **named)
    return call
for name in ("replace", "link", "unlink", "rmdir", "mkdir", "open", "write", "chmod"):
    setattr(os, name, dying(getattr(os, name)))
outputs = Outputs()
def steps(path):
    path.mkdir()
    (path / "step_0000.vtp").write_text("new", encoding="utf-8")
def new(path):
    path.write_text("new", encoding="utf-8")
outputs.add(folder / "a" / "one.vtp", new)
outputs.add(folder / "b" / "two.vtp", new)
outputs.add(folder / "b" / "gone.png", lambda path: None, may_be_missing=True)
outputs.add_folder(folder / "b" / "steps", steps, lambda name: name.startswith("step_"))
outputs.write()
print(calls)
"""
FORKING = """
import json, os, sys
from SDFStentLib.cli.outputs import Outputs
program = sys.argv[1]
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        sys.argv[1:] = json.loads(line)
        exec(program, {})
        os._exit(0)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
"""The exit code of the program that is the first argument, for every line of its arguments."""
OLD = {"a/one.vtp": "old", "b/two.vtp": "old", "b/gone.png": "old", "b/steps/step_0000.vtp": "old"}
NEW = {"a/one.vtp": "new", "b/two.vtp": "new", "b/steps/step_0000.vtp": "new"}


def everything_in(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def prepare(folder):
    for name, text in OLD.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def run(folder, at, program=WRITER):
    return python(program, folder, at)


@pytest.fixture
def forked():
    """Runs `WRITER` as `run` does, but for the exit code alone, in forks of one process."""
    with subprocess.Popen(
        [sys.executable, "-c", FORKING, WRITER],
        cwd=PROJECT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip

        def run(folder, at):
            print(json.dumps([str(folder), str(at)]), file=process.stdin, flush=True)
            return int(process.stdout.readline())

        yield run
        process.stdin.close()


def next_run(folder):
    outputs = Outputs()
    for name in ("a", "b"):
        outputs.add(
            folder / name / "other.txt",
            lambda path: path.write_text("x", encoding="utf-8") and None,
        )
    outputs.write()
    for name in ("a", "b"):
        (folder / name / "other.txt").unlink()


def test_a_kill_at_any_call_leaves_all_old_or_all_new_after_the_next_run(tmp_path, forked):
    prepare(tmp_path / "whole")
    done = run(tmp_path / "whole", -1)
    assert everything_in(tmp_path / "whole") == NEW, done.stderr
    seen = set()
    for at in range(1, int(done.stdout) + 1):
        folder = tmp_path / str(at)
        prepare(folder)
        assert forked(folder, at) == -signal.SIGKILL
        next_run(folder)
        found = everything_in(folder)
        assert found in (OLD, NEW), at
        assert not list(folder.rglob(".sdfstent-*")), at
        seen.add(found == NEW)
    assert seen == {True, False}


def staged(folder):
    """New files for `OLD`'s two folders, ready to be moved there."""
    sets = {}
    for name in ("a", "b"):
        staging = output_set.StagingFolder(folder / name)
        for path in NEW:
            if path.startswith(f"{name}/"):
                new = staging.staged(path[2:])
                new.parent.mkdir(exist_ok=True)
                new.write_text("new", encoding="utf-8")
        sets[staging] = {path.split("/")[1] for path in OLD if path.startswith(f"{name}/")}
    return sets


def failing(monkeypatch, at, error):
    """Let the `at`th move of an output, to its place or aside, fail; a move back does not."""
    replace, calls = os.replace, []

    def moved(source, target):
        if os.path.basename(source) not in ("moves.json.part", "committed.part"):
            calls.append(source)
        if len(calls) == at and source == calls[-1]:
            raise error
        replace(source, target)

    monkeypatch.setattr(output_set.os, "replace", moved)


@pytest.mark.parametrize("at", range(1, 6))
def test_what_dies_before_it_has_taken_back_is_taken_back_by_the_next_run(
    tmp_path, monkeypatch, at
):
    prepare(tmp_path)
    sets = staged(tmp_path)
    failing(monkeypatch, at, OSError(28, "No space left on device"))
    with monkeypatch.context() as dying:
        dying.setattr(output_set, "_take_back", lambda path: None)
        with pytest.raises(InputError):
            output_set.commit(sets)
    for staging in sets:
        os.close(staging._lock)  # as the system does with a dead process
    next_run(tmp_path)
    assert everything_in(tmp_path) == OLD


def test_the_staging_folder_of_a_living_run_is_left_alone(tmp_path):
    living = output_set.StagingFolder(tmp_path)
    output_set.sweep(tmp_path)
    assert living.path.is_dir()
    living.remove()
    assert not any(tmp_path.iterdir())


def foreign(
    folder, name, *, moves, listed=False, first=None, links=(), is_own=False, committed=True
):
    """A staging folder as if a run had left it; `is_own`: as if that run had been here."""
    path = folder / name
    for part in ("new", "old"):
        if part in links:
            path.mkdir(parents=True, exist_ok=True)
            (path / part).symlink_to(folder.parent / "elsewhere")
        else:
            (path / part).mkdir(parents=True)
    for move in moves if committed else ():
        with contextlib.suppress(OSError):
            (path / "new" / move).write_text("from elsewhere", encoding="utf-8")
    said = {"first": str(first or path), "moves": moves if listed else dict.fromkeys(moves, True)}
    (path / "moves.json").write_text(json.dumps(said), encoding="utf-8")
    if committed:
        (path / "committed").write_text(json.dumps([str(path)]), encoding="utf-8")
    (path / "lock").touch()
    if is_own:
        numbers = [path.stat().st_ino, (path / "lock").stat().st_ino]
        (path / "lock").write_text(json.dumps(numbers), encoding="utf-8")
    return path


def victims(folder):
    """What lies in a folder and beside it, but for the staging folders."""
    names = ("victim.txt", "elsewhere/victim.txt", "results/victim.txt", "results/kept.csv")
    for name in names:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("mine", encoding="utf-8")
    return lambda: {name: (folder / name).read_text(encoding="utf-8") for name in names}


FOREIGN = {
    "a path, as in the report": {"moves": ["../victim.txt"]},
    "an absolute path": {"moves": ["{root}/victim.txt"]},
    "a name here": {"moves": ["victim.txt"]},
    "a path, with numbers that fit": {"moves": ["../victim.txt"], "is_own": True},
    "an absolute path, with numbers that fit": {"moves": ["{root}/victim.txt"], "is_own": True},
    "the folder above": {"moves": [".."], "is_own": True},
    "the folder itself": {"moves": [""], "is_own": True},
    "a list of names": {"moves": ["victim.txt"], "is_own": True, "listed": True},
    "new files that lie elsewhere": {"moves": ["victim.txt"], "links": ["new"], "is_own": True},
    "old files that go elsewhere": {"moves": ["victim.txt"], "links": ["old"], "is_own": True},
    "taking back": {"moves": ["victim.txt"], "committed": False},
    "taking back from elsewhere": {
        **{"moves": ["victim.txt"], "links": ["old"], "is_own": True, "committed": False}
    },
}


def test_the_command_obeys_no_folder_from_elsewhere(a_folder, shell):
    """All of them at once, and one that names another folder as its first."""
    results = a_folder / "results"
    made = [
        foreign(
            results,
            f".sdfstent-{number}",
            **{**one, "moves": [name.format(root=a_folder) for name in one["moves"]]},
        )
        for number, one in enumerate(FOREIGN.values())
    ]
    foreign(results, ".sdfstent-first", moves=["victim.txt"], first=made[0], committed=False)
    found = victims(a_folder)
    before = found()
    words = ["measure", "tube.vtp", "--units", "cm", "--centerline", "line.vtp"]
    done = shell(*words, "--csv", "results/l.csv", folder=a_folder)
    assert done.returncode == 0, done.stderr
    assert (results / "l.csv").is_file()
    assert found() == before


def test_what_a_killed_run_left_is_not_obeyed_where_it_was_copied_to(tmp_path, forked):
    prepare(tmp_path / "here")
    calls = int(run(tmp_path / "here", -1).stdout)
    prepare(tmp_path / "here")
    # Ends: some call comes after the commit point and before the last move.
    next(at for at in range(calls, 0, -1) if is_half_moved(forked, tmp_path / "here", at))
    copied = shutil.copytree(tmp_path / "here", tmp_path / "there", symlinks=True)
    before = everything_in(copied)
    next_run(copied)
    assert everything_in(copied) == before
    next_run(tmp_path / "here")
    assert everything_in(tmp_path / "here") == NEW


def is_half_moved(forked, folder, at):
    """Kill a run at a call; whether it was amidst its moves. Else all is old again."""
    forked(folder, at)
    if list(folder.glob("*/.sdfstent-*/committed")) and (folder / "b" / "gone.png").exists():
        return True
    next_run(folder)
    shutil.rmtree(folder)
    prepare(folder)
    return False


@pytest.mark.parametrize(
    ("name", "stays"),
    [(".sdfstent-0123456789ab.vtp", False), (".sdfstent-lock", True), (".sdfstent-notes", True)],
)
def test_an_old_file_is_swept_only_if_it_is_the_beginning_of_an_output(tmp_path, name, stays):
    """The lock of a cohort begins alike, and may be held for days."""
    (tmp_path / name).touch()
    os.utime(tmp_path / name, (0, 0))
    output_set.sweep(tmp_path)
    assert (tmp_path / name).exists() == stays


WINDOWS = """
import fcntl, os, subprocess, sys, types
system, unlink = types.ModuleType("msvcrt"), os.unlink
system.LK_LOCK, system.LK_NBLCK = 1, 2
def locking(descriptor, mode, count):
    assert count == 1 and os.lseek(descriptor, 0, os.SEEK_CUR) == 0
    fcntl.flock(descriptor, fcntl.LOCK_EX | (fcntl.LOCK_NB if mode == 2 else 0))
system.locking = locking
def of_closed_files(path, *, dir_fd=None):
    found = os.stat(path, dir_fd=dir_fd, follow_symlinks=False)
    for number in os.listdir("/proc/self/fd"):
        try:
            held = os.fstat(int(number))
        except OSError:
            continue
        if (held.st_dev, held.st_ino) == (found.st_dev, found.st_ino):
            raise PermissionError(13, "it is open in this process", path)
    unlink(path, dir_fd=dir_fd)
os.unlink = of_closed_files
sys.modules["fcntl"], sys.modules["msvcrt"] = None, system
"""
"""Locks and open files as the documentation of Windows has them, on top of those that are here."""

SWEEPING = """
from pathlib import Path
from SDFStentLib.files.output_set import StagingFolder, sweep
folder = Path(sys.argv[1])
living = StagingFolder(folder / "a")
sweep(folder / "a")
sweep(folder / "b")
assert living.path.is_dir()
living.remove()
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="the stand-in asks what is open")
def test_with_the_locks_of_windows_the_dead_are_told_from_the_living(tmp_path):
    """A stand-in of what is documented: this was not run on Windows."""
    prepare(tmp_path / "whole")
    calls = int(run(tmp_path / "whole", -1, WINDOWS + WRITER).stdout)
    seen = set()
    for at in (calls // 3, calls - 6):
        folder = tmp_path / str(at)
        prepare(folder)
        assert run(folder, at, WINDOWS + WRITER).returncode == -signal.SIGKILL
        assert list(folder.rglob(".sdfstent-*"))
        swept = run(folder, 0, WINDOWS + SWEEPING)
        assert swept.returncode == 0, swept.stderr
        found = everything_in(folder)
        assert found in (OLD, NEW), at
        assert not list(folder.rglob(".sdfstent-*")), at
        seen.add(found == NEW)
    assert seen == {True, False}


def test_what_is_not_ours_is_not_swept(tmp_path):
    (tmp_path / ".sdfstent-mine").mkdir()
    (tmp_path / ".sdfstent-mine" / "notes.txt").write_text("x", encoding="utf-8")
    (tmp_path / ".sdfstent-link").symlink_to(tmp_path / ".sdfstent-mine")
    output_set.sweep(tmp_path)
    assert (tmp_path / ".sdfstent-mine" / "notes.txt").read_text(encoding="utf-8") == "x"


SIGNALLED = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from SDFStentLib.cli.signals import end_at_once
end_at_once()
os.kill(os.getpid(), int(sys.argv[1]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_the_imports_ends_in_a_sentence(number):
    done = python(SIGNALLED, int(number))
    assert done.returncode == 130
    assert done.stderr == "sdfstent: interrupted; nothing was written.\n"


def test_only_the_first_signal_interrupts(monkeypatch):
    from SDFStentLib.cli.signals import interruptions

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with interruptions():
            with pytest.raises(KeyboardInterrupt):
                os.kill(os.getpid(), signal.SIGTERM)
            os.kill(os.getpid(), signal.SIGINT)  # ignored
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
