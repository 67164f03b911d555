"""Sweeps whose workers, disks, patients and own processes fail, with real processes."""

import json
import os
import re
import signal
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import active_children
from pathlib import Path

import pytest
from child_processes import COMMAND, PATIENCE, PROJECT, begun, python
from cohort_cases import (
    bytes_of,
    hold_at,
    let_go,
    sweep_in,
    tube_folder,
    wait_for,
    whole_cases,
    write_sweep,
)

from SDFStentLib import DeploymentError, InputError
from SDFStentLib.cohort import Cases, Cohort, last_tally, run_sweep
from SDFStentLib.cohort.store import Store

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals and limits of POSIX")

COUNT = 5
AXES = {"diameter": {"from": 6, "to": 7, "steps": COUNT}}
ALL = f"{COUNT} of {COUNT} cases"


@pytest.fixture
def there(tmp_path):
    tube_folder(tmp_path)
    write_sweep(tmp_path, axes=AXES, store="moved")
    return tmp_path


@pytest.fixture(scope="module")
def wanted(tmp_path_factory):
    """The files of the sweep that ran through."""
    folder = tube_folder(tmp_path_factory.mktemp("wanted"))
    sweep = sweep_in(folder, axes=AXES, store="moved")
    with ThreadPoolExecutor(1) as thread:
        run_sweep(sweep, folder / "out", executor=thread)
    return bytes_of(folder / "out")


def started(folder, *more, environment=None):
    """A sweep in a process of its own, leader of a group as under a shell."""
    words = ["sweep", "sweep.json", "-o", "out", *more]
    return begun(COMMAND, *words, folder=folder, env=environment, start_new_session=True)


def children_of(pid):
    """Python processes that run cases; not the one that tracks resources."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(path.read_text(encoding="utf-8").rpartition(")")[2].split()[1])
            line = path.with_name("cmdline").read_bytes()
        except OSError:
            continue
        if parent == pid and b"spawn_main" in line:
            found.append(int(path.parent.name))
    return found


def is_alive(pid):
    try:
        return (
            Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
            != "Z"
        )
    except OSError:
        return False


def ended(process):
    out, error = process.communicate(timeout=PATIENCE)
    return process.returncode, out, error


def test_a_sweep_that_is_interrupted_goes_on_where_it_was_to_the_same_bytes(there, wanted, shell):
    """By Ctrl-C to its whole group, and by kill -9.

    While it goes on, a second one into the same folder is refused, and a minute without a case is
    told; it is a second here, or more on a slow machine.
    """
    kept = 0
    for ending, code, workers in ((signal.SIGINT, 130, "2"), (signal.SIGKILL, -9, "1")):
        before = kept
        process = started(there, "--workers", workers, environment=hold_at(there, before + 1))
        wait_for(lambda before=before: len(whole_cases(there)) > before)
        children = children_of(process.pid)
        assert children
        (os.killpg if ending == signal.SIGINT else os.kill)(process.pid, ending)
        returned, _, error = ended(process)
        assert returned == code
        kept = len(whole_cases(there))
        if code == 130:
            kept_words = f"{kept} of {COUNT} cases are kept in out, run it again to go on."
            assert error == f"sdfstent: interrupted; {kept_words}\n"
        wait_for(lambda children=children: not any(map(is_alive, children)))
        assert before < kept < COUNT
    environment = hold_at(there, kept)
    changed(there, "import SDFStentLib.cli.sweep as command", "command.SILENCE = 1.0")
    process = started(there, "--workers", "1", environment=environment)
    said = process.stderr.readline()  # only now cases go on
    second = shell("sweep", "sweep.json", "-o", "out", "--workers", "1", folder=there)
    assert second.returncode == 2
    assert "expected a folder where no sweep is running, another one is" in second.stderr
    assert shell("sweep", "--status", "out", folder=there).stdout.startswith("Running: ")
    let_go(there)
    code, out, error = ended(process)
    assert code == 0
    assert f"{ALL}: {COUNT} certified for meshing." in out
    assert bytes_of(there / "out") == wanted
    assert re.match(r"warning: no case has come back for \d+ \w+; a worker may not answer\.", said)
    assert "--time-limit S" in said
    assert all(line.startswith("warning: no case") for line in error.splitlines())


@pytest.mark.bench
def test_a_worker_that_is_killed_costs_nothing(there, wanted):
    process = started(there, "--workers", "2", environment=hold_at(there, 1))
    wait_for(lambda: whole_cases(there))
    os.kill(children_of(process.pid)[0], signal.SIGKILL)
    let_go(there)
    assert ended(process)[::2] == (0, "")
    assert bytes_of(there / "out") == wanted


def changed(folder, *lines):
    """Every process of a sweep begins with these lines of Python, too."""
    with (folder / "sitecustomize.py").open("a", encoding="utf-8") as file:
        file.write("\n".join(["", *lines, ""]))


def with_changes(folder):
    """The environment of such processes."""
    return {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{PROJECT}"}


def with_a_worker_stopped(folder, *more, lines=()):
    """A sweep of which one worker does not answer, at a case, and the other does; its workers.

    One that is stopped between two cases may keep the other from the queue of cases.
    """
    environment = hold_at(folder, 1)
    changed(folder, *lines)
    process = started(folder, "--workers", "2", *more, environment=environment)
    wait_for(lambda: any(folder.glob("held-*")))
    children = children_of(process.pid)
    stopped = next(child for child in children if (folder / f"held-{child}").exists())
    os.kill(stopped, signal.SIGSTOP)
    let_go(folder)
    return process, [stopped, *(child for child in children if child != stopped)]


@pytest.mark.bench
def test_a_sweep_with_a_worker_that_does_not_answer_can_be_interrupted(there):
    process, children = with_a_worker_stopped(there)
    wait_for(lambda: len(whole_cases(there)) > 2)
    process.send_signal(signal.SIGTERM)
    code, _, error = ended(process)
    assert code == 130
    kept = len(whole_cases(there))
    assert error.startswith(f"sdfstent: interrupted; {kept} of {COUNT} cases are kept")
    assert not any(map(is_alive, children))


@pytest.mark.bench
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("", f"interrupted; {{}} of {COUNT} cases are kept in out"),
        # As on a disk that does not answer.
        ("runner.write_manifest = lambda _: time.sleep(6000)", "ended; what is whole is kept"),
    ],
)
def test_a_second_signal_ends_a_sweep_at_once_with_its_workers(there, line, words):
    process, children = with_a_worker_stopped(
        there,
        lines=(
            "import time",
            "import SDFStentLib.cohort.executors as places",
            "import SDFStentLib.cohort.runner as runner",
            "places.END_SECONDS = 6000",
            line,
        ),
    )
    process.send_signal(signal.SIGINT)
    # The other worker ends with the first signal.
    wait_for(lambda: not is_alive(children[1]))
    process.send_signal(signal.SIGINT)
    code, _, error = ended(process)
    assert code == 130
    assert error.startswith(f"sdfstent: {words.format(len(whole_cases(there)))}, run it again")
    wait_for(lambda: not any(map(is_alive, children)))


def test_a_case_that_takes_longer_than_the_limit_has_failed_and_the_others_go_on(there):
    """The limit of the option counts, whatever that of the document is.

    Its hours are over when all others are done, so that a slow machine has time for them.
    """
    limit = ["--time-limit", "9000"]
    write_sweep(there, axes=AXES, store="moved", time_limit=90_000)
    lines = (
        "import pathlib, time",
        "import SDFStentLib.cohort.watch as watch",
        "watch.monotonic = lambda: time.monotonic() + 10_000 * pathlib.Path('late').exists()",
    )
    process, children = with_a_worker_stopped(there, *limit, lines=lines)
    wait_for(lambda: last_tally(there / "out")[0].finished == COUNT - 1)
    (there / "late").touch()
    code, out, error = ended(process)
    assert (code, error) == (4, "")
    assert f"{ALL}: {COUNT - 1} certified for meshing, 1 failed" in out
    assert not any(map(is_alive, children))
    columns = Cohort(there / "out").columns
    (reason,) = columns["reason"][columns["status"] == "failed"]
    assert reason.startswith("it took longer than the time limit of 9000 s")
    with ThreadPoolExecutor(1) as thread:
        sweep = sweep_in(there, axes=AXES, store="moved")
        assert run_sweep(sweep, there / "out", executor=thread).certified == COUNT


def test_an_early_interruption_does_not_say_that_nothing_is_kept(there):
    sweep = sweep_in(there, axes={"diameter": [6, 6.5]}, store="moved")
    with ThreadPoolExecutor(1) as thread:
        run_sweep(sweep, there / "out", executor=thread)
    write_sweep(there, axes={"diameter": [6, 6.5, 7]}, store="moved")
    changed(
        there,
        "import pathlib, time",
        "import SDFStentLib.cohort.runner as runner",
        "def slowly(*_):",
        "    pathlib.Path('begun').touch()",
        "    time.sleep(6000)",
        "runner._prepare = slowly",
    )
    process = started(there, environment=with_changes(there))
    wait_for((there / "begun").exists)
    process.send_signal(signal.SIGINT)
    code, _, error = ended(process)
    words = "what was whole before is kept in out, run it again to go on."
    assert (code, error) == (130, f"sdfstent: interrupted; {words}\n")


@pytest.mark.parametrize("way", [{"executor": ThreadPoolExecutor(1)}, {"executor": "tcp://a:1"}])
def test_a_time_limit_is_refused_where_nobody_could_be_ended(there, way):
    sweep = sweep_in(there, axes=AXES, time_limit=5)
    with pytest.raises(InputError, match="time_limit: expected worker processes on this machine"):
        run_sweep(sweep, there / "out", **way)
    assert not (there / "out").exists()


@pytest.fixture
def lost_threads(monkeypatch):
    """What threads end with."""
    found = []
    monkeypatch.setattr(threading, "excepthook", found.append)
    return found


def test_a_pool_that_breaks_while_cases_wait_for_workers_ends_its_processes(
    there, monkeypatch, lost_threads
):
    """The pool tells of a killed worker case by case; who hears of the first one must wait."""
    plain, children = Future.set_exception, []

    def slowly(future, error):
        plain(future, error)
        time.sleep(0.2)

    def kill_one_then_stop(_):
        if children:
            raise KeyboardInterrupt
        children.extend(active_children())
        children[0].kill()

    monkeypatch.setattr(Future, "set_exception", slowly)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep_in(there, axes=AXES), there / "out", workers=2, progress=kill_one_then_stop)
    assert not lost_threads
    assert not active_children()


def test_workers_that_are_gone_before_their_pool_is_told_end_it_without_a_word(
    there, monkeypatch, lost_threads
):
    plain = ProcessPoolExecutor.shutdown

    def later(pool, **named):
        wait_for(lambda: not any(map(is_alive, children)))
        plain(pool, **named)

    children = []

    def stop(_):
        children.extend(child.pid for child in active_children())
        raise KeyboardInterrupt

    monkeypatch.setattr(ProcessPoolExecutor, "shutdown", later)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep_in(there, axes=AXES), there / "out", workers=2, progress=stop)
    assert children
    assert not lost_threads


def test_a_case_that_kills_its_worker_fails_alone(there):
    """A limit of memory that one case alone exceeds, as a mesh too large for the machine does."""
    changed(
        there,
        "import os, SDFStentLib.cohort.worker as worker",
        "plain = worker.plan_of_case",
        "def deadly(plan, number, parameters, *more):",
        "    if parameters['diameter'] == 6.25:",
        "        os.kill(os.getpid(), 9)",
        "    return plain(plan, number, parameters, *more)",
        "worker.plan_of_case = deadly",
    )
    code, out, error = ended(started(there, "--workers", "1", environment=with_changes(there)))
    assert (code, error) == (4, "")
    assert f"{ALL}: {COUNT - 1} certified for meshing, 1 failed" in out
    columns = Cohort(there / "out").columns
    assert columns["status"].tolist() == ["done", "failed", *["done"] * (COUNT - 2)]
    assert columns["reason"][1].startswith("its worker ended without a word")


def test_a_damaged_patient_in_the_middle_fails_and_the_others_finish(tmp_path, shell):
    tube_folder(tmp_path)
    (tmp_path / "bad.vtp").write_bytes((tmp_path / "tube.vtp").read_bytes()[:3000])
    people = [
        {"name": name, "surface": file, "centerline": "line.vtp", "units": "cm"}
        for name, file in (("A", "tube.vtp"), ("B", "bad.vtp"), ("C", "none.vtp"))
    ]
    people.append({**people[0], "name": "D", "root": [0, 0, 4]})
    write_sweep(tmp_path, axes={"diameter": [6]}, patients=people)
    done = shell("sweep", "sweep.json", "-o", "out", "--workers", "1", folder=tmp_path)
    assert done.returncode == 4
    assert "4 of 4 cases: 2 certified for meshing, 2 failed" in done.stdout
    columns = Cohort(tmp_path / "out").columns
    assert columns["patient"].tolist() == ["A", "B", "C", "D"]
    assert columns["status"].tolist() == ["done", "failed", "failed", "done"]
    assert columns["reason"][1].startswith("bad.vtp: ")
    assert columns["reason"][2].startswith("none.vtp: ")


def test_failed_cases_are_done_again_when_the_patient_is_there(tmp_path):
    tube_folder(tmp_path)
    (tmp_path / "tube.vtp").rename(tmp_path / "elsewhere.vtp")
    sweep = sweep_in(tmp_path, axes={"diameter": [6]})
    with ThreadPoolExecutor(1) as thread:
        assert run_sweep(sweep, tmp_path / "out", executor=thread).failed == 1
        (tmp_path / "elsewhere.vtp").rename(tmp_path / "tube.vtp")
        # It has another name, which says what was read; nothing was then.
        sweep = sweep_in(tmp_path, axes={"diameter": [6]})
        assert run_sweep(sweep, tmp_path / "out", executor=thread).certified == 1
    assert len(list((tmp_path / "out").glob("cases/*/*"))) == 1


def test_what_is_not_whole_is_repeated_and_what_is_whole_is_not_touched(there, wanted):
    sweep = sweep_in(there, axes=AXES, store="moved")
    out, store = there / "out", Store(there / "out")
    with ThreadPoolExecutor(1) as thread:
        run_sweep(sweep, out, executor=thread)
        one, two, three, four, *_ = [case.id for case in Cases(sweep)]
        (store.path(one) / "moved.npz").write_bytes(b"cut short")
        (store.path(two) / "case.json").write_text("{", encoding="utf-8")
        (store.path(three) / "report.json.gz").unlink()
        leftover = store.path(three).parent / ".sdfstent-killed"
        leftover.mkdir()
        before = (store.path(four) / "times.json").read_bytes()
        tally = run_sweep(sweep, out, executor=thread)
    assert tally.finished - tally.found == 3
    assert not leftover.exists()
    assert (store.path(four) / "times.json").read_bytes() == before
    assert bytes_of(out) == wanted


def test_files_that_cannot_be_written_stop_the_sweep_where_no_disk_can_be_mounted(there):
    """A limit on the size of files fails in the same places as a full disk."""
    program = (
        "import resource, signal, sys\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from SDFStentLib.cohort import load_sweep, run_sweep\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))\n"
        "run_sweep(load_sweep('sweep.json'), 'out', executor=ThreadPoolExecutor(1))\n"
    )
    last = python(program, folder=there).stderr.splitlines()[-1]
    assert "StoreError: " in last
    assert "out: cannot be written (File too large); free space" in last
    assert not whole_cases(there)


def test_a_callers_executor_that_breaks_ends_in_a_sentence_and_keeps_what_is_whole(there):
    from concurrent.futures.process import BrokenProcessPool

    class Breaking(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            if args[0].case.number > 3:
                raise BrokenProcessPool("it broke")
            return super().submit(fn, *args, **kwargs)

    sweep = sweep_in(there, axes=AXES, store="moved")
    with Breaking(1) as executor, pytest.raises(DeploymentError, match="the workers were lost"):
        run_sweep(sweep, there / "out", executor=executor)
    manifest = Cohort(there / "out").columns
    assert set(manifest["status"]) <= {"done", "open"}
    assert json.loads((there / "out" / "cohort.json").read_text(encoding="utf-8"))["cases"]


WINDOWS = """
import fcntl, os, subprocess, sys, types
system = types.ModuleType("msvcrt")
system.LK_LOCK, system.LK_NBLCK = 1, 2
def locking(descriptor, mode, count):
    assert count == 1 and os.lseek(descriptor, 0, os.SEEK_CUR) == 0
    fcntl.flock(descriptor, fcntl.LOCK_EX | (fcntl.LOCK_NB if mode == 2 else 0))
system.locking = locking
sys.modules["fcntl"], sys.modules["msvcrt"] = None, system
"""
"""The locks of Windows as its documentation has them: this was not run there."""

HELD = """
from SDFStentLib.cohort.store import Store
from SDFStentLib.validation import InputError
store = Store(sys.argv[1])
with store.locked():
    assert store.is_running()
    try:
        with Store(sys.argv[1]).locked():
            raise SystemExit(4)
    except InputError as error:
        print(error)
assert not store.is_running()
"""


@pytest.mark.parametrize("system", ["import sys", WINDOWS])
def test_a_store_has_one_sweep_at_a_time(tmp_path, system):
    done = python(system + HELD, tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "expected a folder where no sweep is running, another one is" in done.stdout
