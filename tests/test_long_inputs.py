"""Inputs of unusual size or form: done in time that goes with their size, or refused at once."""

from __future__ import annotations

import json
import resource

import numpy as np
import pytest
from child_processes import installed
from cohort_cases import write_sweep
from tube_files import write_tube

from SDFStentLib.files import polydata
from SDFStentLib.files.formats import vtk_files as vtk_formats

SECONDS = 25
"""Of processor time: start, reading and a deployment take about 2, what was quadratic over 60."""

MEMORY = 1 << 30
"""Of a process at its largest, bytes: a start and a deployment take 0.3 GB."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("long")
    write_tube(made)
    return made


def in_time(*arguments, folder):
    """The installed command; the processor time that it may take ends it."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = installed(*arguments, folder=folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert used < SECONDS, (used, arguments)
    assert "Traceback" not in run.stderr
    assert "Warning:" not in run.stderr, run.stderr
    return run


def write_lines(path, points, lines):
    data = polydata.polydata_from_lines(np.asarray(points, dtype=float), lines)
    path.write_bytes(vtk_formats.encode_vtp(data))


def write_prism(path, count):
    """Two polygons of many corners, and the sides between them, as PLY."""
    angle = 2 * np.pi * np.arange(count) / count
    i = np.arange(count)
    j = (i + 1) % count
    rows = [f"{10 * x:g} {10 * y:g} {z}" for z in (0, 30) for x, y in zip(
        np.cos(angle), np.sin(angle), strict=True)]  # fmt: skip
    rows += [f"4 {a} {b} {b + count} {a + count}" for a, b in zip(i, j, strict=True)]
    rows += [" ".join(map(str, [count, *i[::-1]])), " ".join(map(str, [count, *(i + count)]))]
    path.write_text(
        f"ply\nformat ascii 1.0\nelement vertex {2 * count}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {count + 2}\nproperty list int int vertex_indices\n"
        "end_header\n" + "\n".join(rows) + "\n",
        encoding="utf-8",
    )


@pytest.mark.parametrize("corners", [800, 4_000, 20_000])
def test_polygons_of_many_corners_are_refused_by_their_number(folder, corners):
    write_prism(folder / "prism.ply", corners)
    run = in_time("check", "prism.ply", folder=folder)
    if corners <= 1000:
        assert run.returncode == 0, run.stdout
    else:
        assert run.returncode == 2
        assert f"at most 1,000 corners, got one of {corners:,}" in run.stderr


def dense_lines(kind, count):
    """A line through the tube, two that part, or one of cells of two points each; cm."""
    z = np.linspace(0, 4, count)
    if kind == "fork":
        x = np.maximum(z - 2, 0) / 10
        points = np.vstack([np.c_[x, 0 * z, z], np.c_[-x, 0 * z, z]])
        return points, [np.arange(count), np.arange(count) + count]
    points = np.c_[0 * z, 0 * z, z]
    steps = np.arange(count - 1)
    return points, [np.arange(count)] if kind == "line" else list(np.c_[steps, steps + 1])


@pytest.mark.parametrize(
    ("kind", "count"), [("line", 100_000), ("line", 300_000), ("fork", 100_000), ("cells", 100_000)]
)
def test_dense_centerlines_are_worked_off_and_written_with_every_point(folder, kind, count):
    write_lines(folder / "dense.vtp", *dense_lines(kind, count))
    run = in_time(
        "deploy", "tube.vtp", "--units", "cm", "--centerline", "dense.vtp", "--center", "0", "0",
        "1.5", "--length", "10", "--diameter", "6", "-o", "out.vtp", "--report", "out.json",
        "--output-centerline", "moved.vtp", folder=folder,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    from SDFStentLib.files import read_lines

    moved = read_lines(folder / "moved.vtp", units="cm")
    assert len(moved.points) == len(dense_lines(kind, count)[0])
    stent = json.loads((folder / "out.json").read_text(encoding="utf-8"))["stents"][0]
    assert stent["deployed_length_mm"] == pytest.approx(9.0, abs=1e-3)
    assert stent["axis"]["length_mm"] == pytest.approx(9.0, abs=1e-3)


@pytest.mark.parametrize("method", ["grid", "random", "sobol"])
def test_a_dry_run_of_9_million_cases_needs_no_room_for_them(folder, method):
    axes = {"diameter": (5, 7, 300), "distance": (15, 25, 300), "length": (5, 10, 100)}
    if method == "grid":
        spread = {k: {"from": a, "to": b, "steps": n} for k, (a, b, n) in axes.items()}
        changes = {"axes": {**spread, "branch": 1}}
    else:
        spread = {k: {"uniform": [a, b]} for k, (a, b, _) in axes.items()}
        sampling = {"method": method, "count": 9_000_000, "seed": 1}
        changes = {"axes": {**spread, "branch": 1}, "sampling": sampling}
    write_sweep(folder, **changes)
    run = in_time("sweep", "sweep.json", "--dry-run", folder=folder)
    assert run.returncode == 0, run.stderr
    assert "9000000 cases, 1 patient(s)." in run.stdout
    assert "By 3 cases carried out now" in run.stdout
    # The largest child so far, kB: of all tests of this file.
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 < MEMORY


STENT = {
    "diameter": 6, "length": 0.2, "foreshortening_fraction": 0, "placement": {"center": [0, 0, 2]},
}  # fmt: skip


def write_plan(folder, stents):
    inputs = {
        "units": "cm",
        "surface": {"file": "tube.vtp"},
        "centerline": {"file": "line.vtp"},
    }
    plan = {"schema": "sdfstent-plan", "version": 2, "inputs": inputs, "stents": stents}
    (folder / "plan.json").write_text(json.dumps(plan), encoding="utf-8")


def test_thirty_stents_at_one_place_are_deployed_and_drawn(folder):
    write_plan(folder, [STENT] * 30)
    run = in_time("run", "plan.json", "-o", "thirty", folder=folder)
    assert run.returncode == 0, run.stderr
    assert (folder / "thirty" / "report.html").exists()


@pytest.mark.parametrize("enabled", [True, False])
def test_a_plan_of_100_000_stents_is_refused_by_their_number(folder, enabled):
    write_plan(folder, [{**STENT, "enabled": False}] * 100_000 + [{**STENT, "enabled": enabled}])
    run = in_time("run", "plan.json", "-o", "many", folder=folder)
    assert run.returncode == 2
    assert "stents: expected at most 1,000, got 100,001" in run.stderr


@pytest.mark.parametrize("command", ["deploy", "measure"])
def test_an_axis_of_20_m_is_refused_by_its_length(folder, command):
    write_lines(folder / "axis20.vtp", [[0, 0, 0], [0, 0, 2000]], [[0, 1]])
    more = ["--diameter", "6", "-o", "out.vtp"] if command == "deploy" else []
    arguments = [command, "tube.vtp", "--units", "cm", "--axis", "axis20.vtp", *more]
    run = in_time(*arguments, folder=folder)
    assert run.returncode == 2
    assert "at most 1000 mm, got 20,000 mm" in run.stderr


TURN = 2 * np.pi * np.arange(41) / 40
CIRCLE = np.c_[0 * TURN, 0.1 * np.cos(TURN), 2 + 0.1 * np.sin(TURN)]
AXES = {
    "circle": (CIRCLE, "closed loop"),
    "nearly closed": ([*CIRCLE[:-1].tolist(), [1e-07, 0.1, 2]], "closed loop"),
    "there and back": ([[0, 0, 1.2], [0, 0, 2.8], [0, 0, 1.2]], "closed loop"),
    "partly back": ([[0, 0, 1.2], [0, 0, 2.8], [0, 0, 2.2]], "turns back on itself at (0, 0, 28)"),
    "1e300": ([[0, 0, 1.2], [0, 0, 1e300]], "coordinates up to 1e+06 mm"),
    "1e9": ([[0, 0, 1.2], [0, 0, 1e9]], "coordinates up to 1e+06 mm"),
}


@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("way", ["file", "plan"])
def test_a_loop_or_a_point_far_away_is_no_axis_and_is_called_so(folder, name, way):
    points, words = AXES[name]
    if way == "file":
        write_lines(folder / "odd.vtp", points, [np.arange(len(points))])
        run = in_time(
            "deploy", "tube.vtp", "--units", "cm", "--axis", "odd.vtp", "--diameter", "6",
            "-o", "odd_out.vtp", folder=folder,
        )  # fmt: skip
    else:
        axis = {"axis": {"points": np.asarray(points).tolist()}}
        write_plan(folder, [{"diameter": 6, "placement": axis}])
        run = in_time("run", "plan.json", "-o", "odd", folder=folder)
    assert run.returncode == 2, run.stderr
    assert words in run.stderr
    assert "nan" not in run.stderr.lower()
    assert len(run.stderr.splitlines()) == 1


@pytest.mark.parametrize("places", [["center"], ["from", "to"], ["distal"], ["proximal"]])
def test_a_place_far_away_is_refused_by_its_coordinates(folder, places):
    placement = {key: [0, 0, 1e300] for key in places}
    sizes = {} if "to" in places else {"length": 10}
    write_plan(folder, [{"diameter": 6, **sizes, "placement": placement}])
    run = in_time("run", "plan.json", "-o", "odd", folder=folder)
    assert run.returncode == 2
    assert "coordinates up to 1e+06 mm" in run.stderr
    assert len(run.stderr.splitlines()) == 1
