"""Inputs of unusual size or form: done in time that goes with their size, or refused at once."""

import json
import time

import numpy as np
import pytest
from child_processes import measured
from cohort_cases import write_sweep
from tube_files import plan_of, write_tube

from SDFStentLib.cli import main
from SDFStentLib.files import encode_vtp, polydata_from_lines, read_lines

SECONDS = 25
"""Of processor time: start, reading and a deployment take about 2, what was quadratic over 60."""

MEMORY_MB = 1000
"""Of a process at its largest: a start and a deployment take 150."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("long")
    write_tube(made)
    return made


@pytest.fixture
def in_time(folder, monkeypatch, capsys):
    """Carries out a command in the folder within the processor time that it may take."""

    def run(*arguments):
        monkeypatch.chdir(folder)
        before = time.process_time()
        code = main(list(arguments))
        used = time.process_time() - before
        said = capsys.readouterr().err
        assert used < SECONDS, (used, arguments)
        assert "Warning:" not in said, said
        return code, said

    return run


def write_lines(path, points, lines):
    path.write_bytes(encode_vtp(polydata_from_lines(np.asarray(points, dtype=float), lines)))


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


def test_polygons_of_many_corners_are_refused_by_their_number(folder, in_time):
    write_prism(folder / "prism.ply", 800)
    assert in_time("check", "prism.ply") == (0, "")
    write_prism(folder / "prism.ply", 20_000)
    code, said = in_time("check", "prism.ply")
    assert code == 2
    assert "at most 1,000 corners, got one of 20,000" in said


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
    ("kind", "count"),
    [
        pytest.param("line", 300_000, marks=pytest.mark.bench),
        ("fork", 100_000),
        pytest.param("cells", 100_000, marks=pytest.mark.bench),
    ],
)
def test_dense_centerlines_are_worked_off_and_written_with_every_point(
    folder, in_time, kind, count
):
    points, lines = dense_lines(kind, count)
    write_lines(folder / "dense.vtp", points, lines)
    code, said = in_time(
        "deploy", "tube.vtp", "--units", "cm", "--centerline", "dense.vtp", "--center", "0", "0",
        "1.5", "--length", "10", "--diameter", "6", "-o", "out.vtp", "--report", "out.json",
        "--output-centerline", "moved.vtp",
    )  # fmt: skip
    assert code == 0, said
    assert len(read_lines(folder / "moved.vtp", units="cm").points) == len(points)
    stent = json.loads((folder / "out.json").read_text(encoding="utf-8"))["stents"][0]
    assert stent["deployed_length_mm"] == pytest.approx(9.0, abs=1e-3)
    assert stent["axis"]["length_mm"] == pytest.approx(9.0, abs=1e-3)


@pytest.mark.parametrize("method", [pytest.param("grid", marks=pytest.mark.bench), "sobol"])
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
    run = measured("sweep", "sweep.json", "--dry-run", folder=folder)
    assert run.code == 0, run.said
    assert run.seconds < SECONDS
    assert run.peak_mb < MEMORY_MB
    assert "9000000 cases, 1 patient(s)." in run.said
    assert "By 3 cases carried out now" in run.said


STENT = {
    "diameter": 6, "length": 0.2, "foreshortening_fraction": 0, "placement": {"center": [0, 0, 2]},
}  # fmt: skip


def write_plan(folder, stents):
    (folder / "plan.json").write_text(json.dumps(plan_of(*stents)), encoding="utf-8")


@pytest.mark.bench
def test_thirty_stents_at_one_place_are_deployed_and_drawn(folder, in_time):
    write_plan(folder, [STENT] * 30)
    code, said = in_time("run", "plan.json", "-o", "thirty")
    assert code == 0, said
    assert (folder / "thirty" / "report.html").exists()


TURN = 2 * np.pi * np.arange(41) / 40
CIRCLE = np.c_[0 * TURN, 0.1 * np.cos(TURN), 2 + 0.1 * np.sin(TURN)]
AXES = {
    "circle": (CIRCLE, "closed loop"),
    "nearly closed": ([*CIRCLE[:-1].tolist(), [1e-07, 0.1, 2]], "closed loop"),
    "there and back": ([[0, 0, 1.2], [0, 0, 2.8], [0, 0, 1.2]], "closed loop"),
    "partly back": ([[0, 0, 1.2], [0, 0, 2.8], [0, 0, 2.2]], "turns back on itself at (0, 0, 28)"),
    "1e300": ([[0, 0, 1.2], [0, 0, 1e300]], "coordinates up to 1e+06 mm"),
    "1e9": ([[0, 0, 1.2], [0, 0, 1e9]], "coordinates up to 1e+06 mm"),
    "20 m": ([[0, 0, 1], [0, 0, 2], [0, 0, 3], [0, 2000, 3]], "at most 1000 mm, got 20,020 mm"),
}
FAR = "coordinates up to 1e+06 mm"
PLANS = {
    "too many stents": (
        [{**STENT, "enabled": False}] * 100_000 + [STENT],
        "stents: expected at most 1,000, got 100,001",
    ),
    "stents that are all switched off": (
        [{**STENT, "enabled": False}] * 1_001,
        "stents: expected at most 1,000, got 1,001",
    ),
    **{
        f"{places[-1]} far away": (
            [
                {
                    "diameter": 6,
                    **({} if "to" in places else {"length": 10}),
                    "placement": {key: [0, 0, 1e300] for key in places},
                }
            ],
            FAR,
        )
        for places in (["center"], ["from", "to"], ["distal"], ["proximal"])
    },
    **{
        f"axis: {name}": (
            [{"diameter": 6, "placement": {"axis": {"points": np.asarray(points).tolist()}}}],
            words,
        )
        for name, (points, words) in AXES.items()
    },
}


def assert_one_sentence(ended, words):
    code, said = ended
    assert code == 2, said
    assert words in said
    assert "nan" not in said.lower()
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize("name", PLANS)
def test_a_plan_with_too_many_stents_or_one_that_lies_nowhere_is_refused(folder, in_time, name):
    stents, words = PLANS[name]
    write_plan(folder, stents)
    assert_one_sentence(in_time("run", "plan.json", "-o", "odd"), words)


@pytest.mark.parametrize("name", AXES)
def test_a_loop_or_a_point_far_away_is_no_axis_and_is_called_so(folder, in_time, name):
    points, words = AXES[name]
    write_lines(folder / "odd.vtp", points, [np.arange(len(points))])
    axis = ["tube.vtp", "--units", "cm", "--axis", "odd.vtp"]
    assert_one_sentence(in_time("deploy", *axis, "--diameter", "6", "-o", "out.vtp"), words)
    assert_one_sentence(in_time("measure", *axis), words)
