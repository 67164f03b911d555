"""Sweeps on a real Dask cluster on this machine: a scheduler and workers as processes."""

import contextlib
import io
import os
import random
import re
import signal
import socket
import subprocess
import sys
from collections import deque
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from types import SimpleNamespace

import pytest
from child_processes import COMMAND, PATIENCE, PROJECT, begun
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

from SDFStentLib import InputError
from SDFStentLib.cli import main
from SDFStentLib.cohort import Cohort, executors, run_sweep

pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")

SWEEP = {"axes": {"diameter": {"from": 6, "to": 7, "steps": 4}}, "store": "moved"}
PLACES = "SDFStentLib.cohort.executors"
SECONDS = 240
"""All tests of this file take ten together; a cluster that waits for itself would wait for ever."""


@pytest.fixture(autouse=True)
def _in_time():
    """Fails with the line at which nothing comes, and ends the sweeps that still run."""

    def over(*_):
        pytest.fail(
            f"a cluster did nothing for {SECONDS} s; the traceback says what was waited for"
        )

    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)
    for process in SWEEPS:
        process.kill()
        process.wait()
    SWEEPS.clear()


SWEEPS: list[subprocess.Popen[str]] = []
"""That were started by a test."""


def free_port():
    """One that the system gives to nobody who asks for any, so that it stays free."""
    ports = random.SystemRandom()
    # Ends: most of them are free.
    while True:
        with socket.socket() as one, contextlib.suppress(OSError):
            one.bind(("127.0.0.1", ports.randrange(15_000, 30_000)))
            return one.getsockname()[1]


class Cluster:
    """A scheduler and workers that can be killed and started again."""

    def __init__(self, folder):
        self.folder, self.port, self.processes = folder, free_port(), []
        tube_folder(folder)
        write_sweep(folder, **SWEEP)
        path = f"{folder}{os.pathsep}{PROJECT}"
        self.environment = {**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"}
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.scheduler = self.start_scheduler()
        wait_for(self.answers)

    def start(self, *words):
        log = (self.folder / "cluster.log").open("a", encoding="utf-8")
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *words],
            env=self.environment,
            cwd=self.folder,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        log.close()
        self.processes.append(process)
        return process

    def start_scheduler(self):
        address = ["--host", "127.0.0.1", "--port", str(self.port)]
        return self.start("scheduler", *address, "--no-dashboard", "--no-show")

    def answers(self):
        with contextlib.suppress(OSError):
            socket.create_connection(("127.0.0.1", self.port)).close()
            return True
        return False

    def start_worker(self):
        small = ["--nthreads", "1", "--no-dashboard", "--no-nanny"]
        return self.start("worker", self.address, "--death-timeout", str(PATIENCE), *small)

    def kill_scheduler(self):
        os.kill(self.scheduler.pid, signal.SIGKILL)
        self.scheduler.wait()

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        print((self.folder / "cluster.log").read_text(encoding="utf-8"))  # where a test has failed


@pytest.fixture
def cluster(tmp_path):
    with contextlib.closing(Cluster(tmp_path)) as made:
        yield made


def started(folder, address, environment):
    words = ["sweep", "sweep.json", "-o", "out", "--scheduler", address]
    SWEEPS.append(begun(COMMAND, *words, folder=folder, env=environment))
    return SWEEPS[-1]


def status_of(folder):
    """What another shell is told, "" before the folder is there."""
    words = io.StringIO()
    with contextlib.redirect_stdout(words), contextlib.suppress(SystemExit):
        main(["sweep", "--status", str(folder / "out")])
    return words.getvalue()


@pytest.mark.bench
def test_a_cluster_gives_the_same_bytes_also_when_a_worker_and_the_scheduler_are_killed(cluster):
    """Begun without workers. Held at 1 case the first is killed, held at 2 the scheduler."""
    folder = cluster.folder
    environment = hold_at(folder, 1)
    with (folder / "sitecustomize.py").open("a", encoding="utf-8") as file:
        file.write(f"import {PLACES} as places\nplaces.SCHEDULER_SECONDS = {SECONDS}\n")
    sweep = started(folder, cluster.address, environment)
    wait_for(lambda: "no workers: they are waited for" in status_of(folder))
    first = cluster.start_worker()
    wait_for(lambda: len(whole_cases(folder)) == 1)
    cluster.start_worker()
    os.kill(first.pid, signal.SIGKILL)
    hold_at(folder, 2)
    wait_for(lambda: len(whole_cases(folder)) == 2)
    cluster.kill_scheduler()
    cluster.start_scheduler()
    cluster.start_worker()  # those of the old one have ended with it
    let_go(folder)
    out, error = sweep.communicate(timeout=PATIENCE)
    assert sweep.returncode == 0, error
    assert "4 of 4 cases: 4 certified for meshing." in out
    with ThreadPoolExecutor(1) as thread:
        run_sweep(sweep_in(folder, **SWEEP), folder / "here", executor=thread)
    assert bytes_of(folder / "out") == bytes_of(folder / "here")


SOON_LOST = f"""
import pathlib
import {PLACES} as places

def client(address, plain=places._client):
    places.SCHEDULER_SECONDS = 2 if pathlib.Path("lost").exists() else {SECONDS / 4}
    return plain(address)

places._client = client
"""


@pytest.mark.bench
def test_a_scheduler_that_is_lost_is_told_in_one_sentence(cluster):
    folder = cluster.folder
    environment = hold_at(folder, 1)
    with (folder / "sitecustomize.py").open("a", encoding="utf-8") as file:
        file.write(SOON_LOST)
    cluster.start_worker()
    sweep = started(folder, cluster.address, environment)
    wait_for(lambda: len(whole_cases(folder)) == 1)
    (folder / "lost").touch()
    cluster.kill_scheduler()
    _, error = sweep.communicate(timeout=PATIENCE)
    assert sweep.returncode == 4
    assert error == (
        "sdfstent sweep: the scheduler does not answer any more; what is whole is kept, run the "
        "sweep again to go on.\n"
    )


def test_a_scheduler_that_is_lost_is_asked_nothing_more():
    """It would be waited for, as long as it is when a sweep begins."""
    future, asked = Future(), []
    future.cancel()
    future.set_running_or_notify_cancel()
    executor = SimpleNamespace(submit=lambda *_: future)
    with pytest.raises(CancelledError):
        list(executors.finished(executor, deque(["a task"]), 1, {}, lambda: asked.append(1)))
    assert not asked


STAND_IN = """
from distributed import LocalCluster

class SLURMCluster(LocalCluster):
    def __init__(self, cores, processes, memory, walltime):
        super().__init__(n_workers=1, threads_per_worker=1, dashboard_address=None)
    def adapt(self, maximum_jobs):
        pass

import sys
if sys.argv[0].endswith("cluster.py"):
    # A program that starts processes is read again by each; that of Slurm starts none itself.
    import multiprocessing.spawn as spawn
    spawn.get_preparation_data = lambda name, plain=spawn.get_preparation_data: {
        key: value for key, value in plain(name).items() if not key.startswith("init_main")
    }
"""


@pytest.mark.bench
def test_the_program_that_keeps_a_cluster_keeps_it_until_it_is_ended(tmp_path):
    """That of the document, with a cluster of one machine that is called as dask-jobqueue's."""
    text = (PROJECT / "docs" / "cohorts.md").read_text(encoding="utf-8")
    programs = re.findall(r"```python\n(.*?)```", text, re.S)
    (program,) = [one for one in programs if "SLURMCluster" in one]
    (tmp_path / "cluster.py").write_text(program, encoding="utf-8")
    (tmp_path / "dask_jobqueue.py").write_text(STAND_IN, encoding="utf-8")
    write_sweep(tube_folder(tmp_path), axes={"diameter": [6]}, store="moved")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{PROJECT}"}
    kept = begun(sys.executable, "cluster.py", folder=tmp_path, env=environment, stderr=None)
    try:
        address = kept.stdout.readline().strip()
        sweep = started(tmp_path, address, environment)
        out, error = sweep.communicate(timeout=PATIENCE)
        assert sweep.returncode == 0, error
        assert "1 of 1 cases: 1 certified for meshing." in out
        assert kept.poll() is None
    finally:
        kept.send_signal(signal.SIGINT)
        kept.communicate(timeout=PATIENCE)


def test_a_case_that_dask_gave_up_has_failed_and_the_others_finish(tmp_path):
    """Dask's own exception, as its executor hands it on."""
    from distributed.scheduler import KilledWorker

    class GivingUp(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            if args[0].case.number != 2:
                return super().submit(fn, *args, **kwargs)
            future = Future()
            future.set_exception(KilledWorker("run_case", None, 3))
            return future

    sweep = sweep_in(tube_folder(tmp_path), axes={"diameter": [6, 6.5, 7]})
    with GivingUp(1) as executor:
        tally = run_sweep(sweep, tmp_path / "out", executor=executor)
    assert (tally.certified, tally.failed) == (2, 1)
    assert Cohort(tmp_path / "out").columns["reason"][1].startswith("its worker ended without")


def test_a_scheduler_that_does_not_answer_is_told_in_one_sentence(tmp_path, monkeypatch):
    tube_folder(tmp_path)
    monkeypatch.setattr(executors, "SCHEDULER_SECONDS", 0.5)
    address = f"tcp://127.0.0.1:{free_port()}"
    with pytest.raises(InputError, match=rf"scheduler: expected one at {address}, none answered"):
        run_sweep(sweep_in(tmp_path), tmp_path / "out", executor=address)


def test_an_address_that_is_none_is_told_in_one_sentence(tmp_path):
    tube_folder(tmp_path)
    with pytest.raises(InputError, match="scheduler: expected one at somewhere"):
        run_sweep(sweep_in(tmp_path), tmp_path / "out", executor="somewhere")
