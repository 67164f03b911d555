"""What the examples and the document of cohorts show is run here, and a treatment as flat rows."""

import csv
import json
import os
import re
import runpy
import sys
from pathlib import Path

import pytest
from child_processes import PROJECT, begun, ended
from cohort_cases import bytes_of, tube_folder, write_sweep
from tube_files import write_tube

from SDFStentLib.certificate import NOT_READY, said_of
from SDFStentLib.cli import main
from SDFStentLib.cohort import Cohort, Tally, sweep_from_document
from SDFStentLib.cohort.worker import Outcome

TEXT = (PROJECT / "docs" / "cohorts.md").read_text(encoding="utf-8")


def block(kind, heading):
    section = TEXT.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return re.search(rf"```{kind}\n(.*?)```", section, re.S).group(1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("document")
    assert main(["demo", "-o", str(made / "patient"), "--quiet"]) == 0
    return made


def test_the_example_gives_its_table_and_its_plot(folder):
    pytest.importorskip("matplotlib")
    document = json.loads(block("json", "Two hundred cases"))
    assert document["sampling"]["count"] == 200
    document["sampling"]["count"] = 2
    (folder / "sweep.json").write_text(json.dumps(document), encoding="utf-8")
    (folder / "plot.py").write_text(block("python", "Two hundred cases"), encoding="utf-8")
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = ended(begun(sys.executable, "plot.py", folder=folder, env=environment))
    assert done.returncode == 0, done.stderr
    columns = Cohort(folder / "cohort").columns
    certified = int((columns["certified"] == 1).sum())
    assert certified >= 1
    assert done.stdout.startswith(f"{certified} certified for meshing, 0 failed, ")
    assert (folder / "lumen.png").stat().st_size > 5000
    # The stent is prescribed along all of its length, and nothing else narrows it.
    ratios = columns["lumen_after_mm"] / columns["diameter_mm"]
    assert ((ratios > 0.98) & (ratios < 1.02)).all()
    assert columns["diameter_mm"].tolist() == columns["parameter_diameter"].tolist()


def test_the_arrays_of_the_document_are_there(folder, monkeypatch):
    if not (folder / "cohort").exists():
        pytest.skip("the cohort of the example was not made")
    values = {}
    monkeypatch.chdir(folder)
    exec(compile(block("python", "Arrays for training"), "docs/cohorts.md", "exec"), values)
    data = values["data"]
    count = int((values["cohort"].columns["certified"] == 1).sum())
    assert data.parameters.shape == (count, 3)
    assert data.displacements.shape == (count, len(data.points), 3)


def test_the_sweep_document_of_the_document_is_one(tmp_path):
    plan = json.loads(block("json", "Two hundred cases"))["plan"]
    (tmp_path / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    found = sweep_from_document(json.loads(block("json", "The sweep document")), str(tmp_path))
    assert [axis.name for axis in found.axes] == ["lesion", "offset", "diameter_over_reference"]


def test_the_document_names_every_axis_and_every_exit_code():
    from SDFStentLib.cohort.axes import NAMES, SHAPE_PARTS

    table = TEXT.split("| axis | |")[1].split("\n\n")[0]
    for name in NAMES:
        last = f".{name.rpartition('.')[2]}" if name in SHAPE_PARTS else name
        assert name in table or f"`{last}`" in table, name
    manual = (PROJECT / "docs" / "cli.md").read_text(encoding="utf-8")
    codes = manual.split("| exit code | |")[1].split("\n\n")[0]
    assert set(re.findall(r"^\| (\d+) \|", codes, re.M)) == {"0", "1", "2", "3", "4", "130"}


# A treatment as flat rows, places along branches, and the researcher's loop in the documents.


def test_the_loop_in_the_documents_runs_and_its_table_can_be_read(tmp_path, monkeypatch):
    write_tube(tmp_path)
    (tmp_path / "tube.vtp").rename(tmp_path / "artery.vtp")
    (tmp_path / "line.vtp").rename(tmp_path / "centerline.vtp")
    monkeypatch.chdir(tmp_path)
    text = (PROJECT / "docs" / "cohorts.md").read_text(encoding="utf-8")
    program = re.search(r"## By hand.*?```python\n(.*?)```", text, re.S).group(1)
    exec(compile(program, "docs/cohorts.md", "exec"), {})
    with open("table.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["diameter_mm"]) for row in rows] == [6.0, 6.0, 6.5, 6.5, 7.0, 7.0]
    for row in rows:
        assert row["certified"] == "True"
        assert float(row["lumen_after_mm"]) == pytest.approx(float(row["diameter_mm"]), rel=0.01)


# The examples run, and give the number that they say.


EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_its_number_holds(path, folder, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [str(path), str(folder / "patient")])
    runpy.run_path(str(path), run_name="__main__")  # the example itself asserts its number
    assert "mm" in capsys.readouterr().out


# `sdfstent sweep`: what it says, its exit codes, `--dry-run`, `--table` and `--status`.


@pytest.fixture
def there(tmp_path, monkeypatch):
    tube_folder(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_sweep_is_carried_out_said_and_can_be_asked_for(there, capsys):
    write_sweep(there, axes={"diameter": [6, 6.5]}, store="moved")
    assert main(["sweep", "sweep.json", "-o", "out", "--workers", "1"]) == 0
    out = capsys.readouterr().out
    assert "2 of 2 cases: 2 certified for meshing." in out
    assert "Wrote out in " in out
    before = bytes_of(there / "out")
    assert main(["sweep", "--status", "out"]) == 0
    assert capsys.readouterr().out == "Finished: 2 of 2 cases: 2 certified for meshing.\n"
    (there / "out" / "manifest.csv").unlink()
    assert main(["sweep", "--table", "out"]) == 0
    assert "manifest.csv" in capsys.readouterr().out
    assert main(["sweep", "sweep.json", "-o", "out"]) == 0
    assert bytes_of(there / "out") == before


def test_a_dry_run_tells_count_cases_time_and_disk_and_writes_nothing(there, capsys):
    write_sweep(there)
    before = sorted(there.iterdir())
    assert main(["sweep", "sweep.json", "--dry-run", "--workers", "2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "6 cases, 1 patient(s)."
    assert [line.split(":")[0] for line in lines[1:6]] == ["1", "2", "3", "4", "5"]
    assert '"diameter": 6.0' in lines[1]
    assert "By 3 cases carried out now: " in lines[6]
    assert " on 2 process(es), " in lines[7]
    assert lines[7].endswith("MB of disk.")
    assert sorted(there.iterdir()) == before


def test_a_terminal_shows_counts_rate_and_time_left(there, capsys, monkeypatch):
    write_sweep(there, axes={"diameter": [6, 6.5, 40]})
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    main(["sweep", "sweep.json", "-o", "out", "--workers", "1"])
    bar = capsys.readouterr().err
    assert "Sweeping [" in bar
    last = bar.rstrip().split("\r")[-1].strip() or bar.rstrip().split("\r")[-2]
    assert "100 % 2 certified for meshing, 1 failed, " in last
    assert "/s, 0 s left" in last


def test_the_counts_tell_rate_and_time_left_of_this_run_alone():
    tally = Tally(
        total=1000,
        certified=90,
        uncertified=2,
        unready=1,
        excluded=5,
        failed=2,
        found=50,
        seconds=25,
    )
    assert (tally.finished, tally.fraction, tally.rate) == (100, 0.1, 2)
    assert tally.seconds_left == 450
    note = (
        "90 certified for meshing, 2 failed, 1 no worse than before, not ready for a mesher, "
        "2 not certified for meshing, 5 excluded, 2/s, 8 min left"
    )
    assert tally.note() == note
    unready = Outcome("1", "done", False, f"{said_of(NOT_READY)}: it is not manifold.")
    others = Outcome("2", "done", False, "Surface not certified for meshing: it has folds.")
    counted = Tally(10).counted(unready).counted(others)
    assert (counted.unready, counted.uncertified, counted.finished) == (1, 1, 2)
    assert Tally(10).note() == "0 certified for meshing, 0 failed"
