"""Work in several threads: the same results, failures and end as in one."""

import json
import os
import signal
import sys
import threading
import time

import numpy as np
import pytest
from child_processes import PATIENCE, begun, python
from round_tubes import contoured
from scipy.spatial import Delaunay
from segmentations import FORK, voxels
from tube_files import PLACE, write_tube

from benchmarks.phantoms import hairpin_tube
from SDFStentLib import extract_centerline
from SDFStentLib.centerline import inner_balls
from SDFStentLib.cli import main
from SDFStentLib.files import read_surface
from SDFStentLib.geometry import Surface, compacted
from SDFStentLib.scan import Labelmap, prepared_vessel
from SDFStentLib.threads import ahead, cores, side_by_side, threads, use_threads
from SDFStentLib.validation import InputError


@pytest.fixture
def two_threads():
    use_threads(2)
    yield
    use_threads(1)


def deployed(folder, count):
    words = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *PLACE]
    made = ["-o", f"{count}.vtp", "--report", f"{count}.json", "--threads", str(count)]
    code = main([*words, "--diameter", "6", *made])
    use_threads(1)
    return code


def test_points_and_report_are_the_same_with_any_number(tmp_path, monkeypatch, capsys):
    write_tube(tmp_path)
    monkeypatch.chdir(tmp_path)
    points, told = [], []
    for count in (1, 2, 4):
        assert deployed(tmp_path, count) == 0
        points.append(read_surface(f"{count}.vtp", "cm").points)
        document = json.loads((tmp_path / f"{count}.json").read_text(encoding="utf-8"))
        told.append({key: document[key] for key in document if key not in OF_THIS_RUN})
    assert np.array_equal(points[0], points[1])
    assert np.array_equal(points[0], points[2])
    assert told[0] == told[1] == told[2]
    assert told[0]["lesions"]


OF_THIS_RUN = ("created", "timings", "outputs")


def test_what_fails_ahead_fails_as_it_would_alone(tmp_path, monkeypatch, capsys):
    def failing(*_arguments):
        raise InputError("lesions: expected something else.")

    write_tube(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("SDFStentLib.treatment.vessel.TreeLesions", failing)
    said = []
    for count in (1, 2):
        assert deployed(tmp_path, count) == 2
        said.append(capsys.readouterr().err)
    assert said[0] == said[1]
    assert "lesions: expected something else." in said[0]


def test_what_is_ahead_is_done_when_it_is_asked_for(two_threads):
    found = []
    done = ahead(lambda: found.append(threading.current_thread()))
    # Ends: another thread begins it.
    while not found:
        pass
    done()
    assert found != [threading.main_thread()]
    done()  # asking twice is no harm


def test_what_numpy_is_to_say_goes_along(two_threads):
    found = []
    with np.errstate(all="raise"):
        done = ahead(lambda: found.append(np.geterr()["over"]))
    # Ends: another thread begins it.
    while not found:
        pass
    done()
    assert found == ["raise"]


def test_what_fails_in_a_thread_is_left_to_who_asks(two_threads):
    begun = threading.Event()

    def failing():
        begun.set()
        raise InputError("expected something else.")

    done = ahead(failing)
    begun.wait()
    done()


def test_what_no_thread_has_begun_is_not_waited_for(two_threads):
    is_over, found = threading.Event(), []
    first = ahead(is_over.wait)
    second = ahead(lambda: found.append(2))
    second()
    is_over.set()
    first()
    assert found == []


@pytest.mark.parametrize("count", [1, 2, 4])
def test_what_is_done_side_by_side_comes_in_order(count):
    use_threads(count)
    try:
        assert side_by_side(lambda number: number**2, range(100)) == [n**2 for n in range(100)]
        assert side_by_side(str, []) == []
    finally:
        use_threads(1)


def test_two_things_side_by_side_are_done_at_once(two_threads):
    meeting = threading.Barrier(2, timeout=PATIENCE)
    assert sorted(side_by_side(lambda _: meeting.wait(), range(2))) == [0, 1]


@pytest.mark.parametrize("count", [1, 2, 4])
def test_of_what_fails_side_by_side_the_same_is_said(count):
    def work(number):
        if number in (3, 5):
            raise InputError(f"expected something else, got {number}.")

    use_threads(count)
    try:
        with pytest.raises(InputError, match=r"got 5\."):
            side_by_side(work, range(8))
    finally:
        use_threads(1)


def balls(surface, count):
    use_threads(count)
    try:
        return inner_balls(surface)
    finally:
        use_threads(1)


TUBE = hairpin_tube(edge_length=0.3).surface
BALL = contoured([((0, 0, 0), (0, 0, 1), 8.0, 8.0)], 0.35)
"""Too wide for halves."""


@pytest.mark.parametrize("surface", [TUBE, BALL], ids=["tube", "ball"])
def test_balls_are_the_same_with_any_number(surface):
    assert len(surface.points) > MANY
    one, two = balls(surface, 1), balls(surface, 2)
    assert all(np.array_equal(*columns) for columns in zip(one, two, strict=True))


@pytest.mark.parametrize(("surface", "most"), [(TUBE, 0.6), (BALL, 1)], ids=["tube", "ball"])
def test_of_halves_no_more_is_looked_at_than_balls_reach(two_threads, monkeypatch, surface, most):
    """Two thirds each, and of a ball, which is too wide for that, all points besides."""
    counts = []

    def counted(points, **options):
        counts.append(len(points))
        return Delaunay(points, **options)

    monkeypatch.setattr("scipy.spatial.Delaunay", counted)
    inner_balls(surface)
    assert max(counts) <= most * len(surface.points)
    assert sum(counts) < 1.25 * len(surface.points)


def test_a_vessel_from_voxels_is_the_same_with_any_number(two_threads):
    mask, low = voxels(FORK, 0.9)
    labelmap = Labelmap(mask, np.full(3, 0.9), low, np.eye(3))
    two = prepared_vessel(labelmap)
    use_threads(1)
    one = prepared_vessel(labelmap)
    assert np.array_equal(one.surface.points, two.surface.points)
    assert np.array_equal(one.surface.triangles, two.surface.triangles)
    assert np.array_equal(one.lines.points, two.lines.points)


@pytest.mark.parametrize("narrow", [2.0, 3.5], ids=["as known", "another one"])
def test_lines_are_the_same_with_any_number(narrow):
    """Ways are begun at the known inlet, and anew where a round end is wider than that."""
    tube = contoured([((0, 0, 0), (0, 0, 30), 3.0, narrow)], 0.4)
    middles = tube.points[tube.triangles].mean(axis=1)
    surface = Surface(*compacted(tube.points, tube.triangles[middles[:, 2] > 0]))
    lines = []
    for count in (1, 2):
        use_threads(count)
        lines.append(extract_centerline(surface).lines)
        use_threads(1)
    one, two = lines
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.inscribed_radius, two.inscribed_radius)
    assert one.points[one.lines[0][0]][2] < 5 if narrow < 3 else one.points[one.lines[0][0]][2] > 25


def test_one_thread_does_nothing_ahead():
    found = []
    assert threads() == 1
    ahead(lambda: found.append(1))()
    assert found == []


def test_the_number_is_that_of_the_cores_unless_told():
    try:
        use_threads(None)
        assert threads() == cores() >= 1
    finally:
        use_threads(1)


def test_no_threads_are_refused(capsys):
    made = ["-o", "made"]
    for words in (["demo"], ["centerline", "tube.vtp", *made], ["prepare", "tube.nii", *made]):
        assert main([*words, "--threads", "0"]) == 2
        assert "threads: expected a whole number from 1, got 0" in capsys.readouterr().err
        assert threads() == 1


LONG = """
import sys, threading, time
import SDFStentLib.treatment.vessel as vessel
from SDFStentLib.__main__ import main

begun = threading.Event()

def search(*given):
    print("begun", flush=True)
    begun.set()
    time.sleep(1800)

vessel.TreeLesions = search
sys.exit(main())
"""


def started(folder, program):
    """A deployment by a program that begins in two threads."""
    write_tube(folder)
    words = ["deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *PLACE]
    words += ["--diameter", "6", "-o", "out.vtp", "--threads", "2"]
    return begun(sys.executable, "-c", program, *words, folder=folder)


@pytest.mark.skipif(os.name == "nt", reason="no such signal there")
def test_control_c_waits_for_no_thread(tmp_path):
    process = started(tmp_path, LONG)
    assert process.stdout.readline() == "begun\n"
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    assert time.monotonic() - start < SECONDS
    assert process.returncode == 130
    assert "interrupted; nothing was written" in said
    assert not (tmp_path / "out.vtp").exists()


FAILING = LONG.replace(
    "sys.exit(main())",
    """
from SDFStentLib.treatment import Treatment
from SDFStentLib.validation import InputError

def fail(treatment):
    begun.wait()
    raise InputError("deployment: expected something else.")

Treatment.__iter__ = fail
sys.exit(main())
""",
)


def test_a_failure_waits_for_no_thread(tmp_path):
    process = started(tmp_path, FAILING)
    out, said = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (2, "begun\n")
    assert said == "sdfstent deploy: deployment: expected something else.\n"


MANY = 10_000
"""Number of points from which on balls are looked for by halves."""

SECONDS = 60
"""Of a busy machine; a quiet one takes less than one."""


WORKER = """
import SDFStentLib.cohort.worker
from SDFStentLib.threads import threads
print(threads())
"""


def test_a_worker_of_a_sweep_has_one():
    done = python(WORKER)
    assert done.stdout.strip() == "1"
