"""A run that is killed leaves files that are whole, and what is of two runs is told."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
from child_processes import PROJECT, installed, python
from tube_files import PLACE, write_tube

from SDFStentLib.files import output_set
from SDFStentLib.report import output_facts

WRITER = """
import os, sys
from pathlib import Path
from SDFStentLib.cli.outputs import Outputs
from SDFStentLib.report import document_json, output_list
folder, at, text = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
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
    (path / "step_0000.vtp").write_text(text, encoding="utf-8")
def new(path):
    path.write_text(text, encoding="utf-8")
def report(path):
    files = output_list(outputs.beside(folder / "b" / "report.json"))
    document = {"schema": "sdfstent-report", "run": text, "outputs": files}
    path.write_text(document_json(document), encoding="utf-8")
outputs.add(folder / "b" / "report.json", report, is_last=True)
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
from SDFStentLib.report import document_json, output_list
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
FILES = ("a/one.vtp", "b/two.vtp", "b/steps/step_0000.vtp")


def everything_in(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def in_place(folder):
    """The same without what is staged."""
    found = everything_in(folder)
    return {name: text for name, text in found.items() if ".sdfstent-" not in name}


def run(folder, at, text="new"):
    return python(WRITER, folder, at, text)


@pytest.fixture(scope="module")
def old(tmp_path_factory):
    """The files of an earlier run, which are a day old."""
    folder = tmp_path_factory.mktemp("old") / "old"
    for name in ("a", "b"):
        (folder / name).mkdir(parents=True)
    assert run(folder, -1, "old").returncode == 0
    (folder / "b" / "gone.png").write_text("old", encoding="utf-8")
    age(folder, 86400)
    return folder


def age(folder, seconds):
    when = time.time() - seconds
    for path in (*folder.rglob("*"), folder):
        os.utime(path, (when, when))


@pytest.fixture
def forked():
    """Runs `WRITER` as `run` does, but for the exit code alone, in forks of one process."""
    with subprocess.Popen(
        [sys.executable, "-c", FORKING, WRITER],
        cwd=PROJECT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip

        def run(folder, at):
            print(json.dumps([str(folder), str(at), "new"]), file=process.stdin, flush=True)
            return int(process.stdout.readline())

        yield run
        process.stdin.close()


def runs_in(folder):
    """By which runs the files in a folder are, a report and what is missing apart."""
    found = in_place(folder)
    texts = {found.get(name, "") for name in FILES}
    report = json.loads(found["b/report.json"])["run"]
    return texts, report, "b/gone.png" in found


def is_told(folder):
    """Whether `check` tells of two runs: of the report, or by what is left in a folder."""
    report = output_facts(folder / "b" / "report.json")
    return not report.value("passed") or bool(report.value("warnings"))


def test_a_kill_at_any_call_leaves_whole_files_and_a_mix_is_told(old, tmp_path, forked):
    shutil.copytree(old, tmp_path / "whole")
    done = run(tmp_path / "whole", -1)
    assert done.returncode == 0, done.stderr
    assert runs_in(tmp_path / "whole") == ({"new"}, "new", False)
    assert not is_told(tmp_path / "whole")
    seen = set()
    for at in range(1, int(done.stdout) + 1):
        folder = tmp_path / str(at)
        shutil.copytree(old, folder)
        assert forked(folder, at) == -signal.SIGKILL
        texts, report, is_there = runs_in(folder)
        assert texts <= {"old", "new", ""}  # each is whole; one that is replaced may be away
        is_mixed = texts != {report} or is_there != (report == "old")
        assert is_told(folder) or not is_mixed, (at, texts, report)
        seen.add("mixed" if is_mixed else report)
        seen.add("away" if "" in texts else report)
        assert_nothing_is_lost(folder)
    assert seen == {"old", "mixed", "new", "away"}


def assert_nothing_is_lost(folder):
    """A folder is away while it is replaced: the next run, an hour later, puts it back."""
    before = set(in_place(folder))
    age(folder, 7200)
    for name in ("a", "b"):
        output_set.sweep(folder / name)
    after = set(everything_in(folder))
    assert before | set(FILES) <= after
    assert not list(folder.rglob(".sdfstent-*"))


def test_after_a_kill_the_same_run_makes_everything_new_and_nothing_is_told(old, tmp_path, forked):
    calls = int(run(shutil.copytree(old, tmp_path / "whole"), -1).stdout)
    for at in range(calls // 2, calls, 6):
        folder = shutil.copytree(old, tmp_path / str(at))
        assert forked(folder, at) == -signal.SIGKILL
        time.sleep(0.02)  # the clock of the file system ticks
        assert run(folder, -1).returncode == 0
        assert runs_in(folder) == ({"new"}, "new", False)
        assert not is_told(folder), at


def test_a_run_that_is_writing_is_left_alone(tmp_path):
    living = output_set.StagingFolder(tmp_path)
    living.staged("one.vtp").write_text("new", encoding="utf-8")
    output_set.sweep(tmp_path)
    assert living.path.is_dir()
    assert output_set.unfinished(tmp_path) == ["one.vtp"]
    living.remove()
    assert output_set.unfinished(tmp_path) == []


@pytest.mark.parametrize("link", ["new", "old", ""])
def test_a_staging_folder_that_leads_elsewhere_is_left_alone(tmp_path, link):
    elsewhere, here = tmp_path / "elsewhere", tmp_path / "here"
    for path in (elsewhere, here / ".sdfstent-x" / "new", here / ".sdfstent-x" / "old"):
        path.mkdir(parents=True)
    (elsewhere / "victim.txt").write_text("mine", encoding="utf-8")
    made = here / ".sdfstent-x" / link
    shutil.rmtree(made)
    made.symlink_to(elsewhere)
    age(here, 7200)
    os.utime(elsewhere, (0, 0))
    output_set.sweep(here)
    assert everything_in(elsewhere) == {"victim.txt": "mine"}
    assert not (here / "victim.txt").exists()
    assert output_set.unfinished(here) == []


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


def test_what_is_not_ours_is_not_swept(tmp_path):
    (tmp_path / ".sdfstent-mine").mkdir()
    (tmp_path / ".sdfstent-mine" / "notes.txt").write_text("x", encoding="utf-8")
    (tmp_path / ".sdfstent-link").symlink_to(tmp_path / ".sdfstent-mine")
    age(tmp_path, 7200)
    output_set.sweep(tmp_path)
    assert (tmp_path / ".sdfstent-mine" / "notes.txt").read_text(encoding="utf-8") == "x"


@pytest.fixture(scope="module")
def carried_out(tmp_path_factory):
    """The folder of a plan that was carried out."""
    folder = tmp_path_factory.mktemp("plan")
    write_tube(folder)
    files = ["tube.vtp", "-o", "out.vtp", "--report", "r.json", "--report", "r.html"]
    lines = ["--centerline", "line.vtp", "--output-centerline", "line_out.vtp", "--units", "cm"]
    done = installed("deploy", *files, *lines, *PLACE, "--diameter", 6, folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


def test_a_report_has_the_hashes_of_what_was_written_with_it(carried_out):
    document = json.loads((carried_out / "r.json").read_text(encoding="utf-8"))
    assert {one["file"] for one in document["outputs"]} == {"out.vtp", "line_out.vtp", "r.html"}
    for one in document["outputs"]:
        data = (carried_out / one["file"]).read_bytes()
        assert hashlib.sha256(data).hexdigest() == one["sha256"]
    done = installed("check", "r.json", folder=carried_out)
    assert done.returncode == 0
    assert done.stdout == "r.json: all 3 files are as they were written with it.\n"


@pytest.mark.parametrize(("name", "words"), [("out.vtp", "another one"), ("r.html", "missing")])
def test_check_tells_what_is_not_of_the_same_run(carried_out, tmp_path, name, words):
    folder = shutil.copytree(carried_out, tmp_path / "copy")
    (folder / name).unlink()
    if words == "another one":
        shutil.copy(folder / "tube.vtp", folder / name)
    done = installed("check", "r.json", folder=folder)
    assert done.returncode == 3
    assert done.stdout.startswith(f"r.json: {name} is {words}: the run was cut off, or ")
    told = json.loads(installed("check", "r.json", "--json", folder=folder).stdout)
    states = {one["file"]: one["state"] for one in told["outputs"]}
    assert (told["passed"], states.pop(name), set(states.values())) == (
        *(False, words),
        {"as written"},
    )
    of_surface = installed("check", "out.vtp", "--units", "cm", folder=folder)
    assert of_surface.returncode == 0
    is_told = "out.vtp is not the one that was written with r.json" in of_surface.stdout
    assert is_told == (name == "out.vtp")


def test_a_report_without_hashes_is_refused(tmp_path):
    (tmp_path / "r.json").write_text('{"schema": "sdfstent-report"}', encoding="utf-8")
    done = installed("check", "r.json", folder=tmp_path)
    assert done.returncode == 2
    assert "expected a report with the hashes of its outputs" in done.stderr


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda _path: None, "r.json: no such file; check the path."),
        (lambda path: path.mkdir(), "r.json: expected a file, got a folder; name a file in it."),
        (
            lambda path: path.touch(),
            "r.json: expected a report, got an empty file; write it again.",
        ),
    ],
    ids=["missing", "folder", "empty"],
)
def test_a_report_that_cannot_be_read_is_told_as_any_other_file(make, told, tmp_path):
    make(tmp_path / "r.json")
    done = installed("check", "r.json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (2, f"sdfstent check: {told}\n")


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
