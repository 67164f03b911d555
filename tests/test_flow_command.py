"""The command `flow` on the synthetic patient."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from SDFStentLib.cli import main


@pytest.fixture(scope="module")
def patient(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flow")
    assert main(["demo", "-o", str(folder), "--quiet"]) == 0
    return folder


@pytest.fixture
def flow(patient, tmp_path, monkeypatch):
    """Runs the command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*more):
        files = [str(patient / "surface.vtp"), "--centerline", str(patient / "centerline.vtp")]
        return main(["flow", *files, *more])

    run.plan = str(patient / "plan.json")
    return run


PRESSURES = ("--inlet-pressure", "30", "--wedge", "12", "--split-right", "0.7")


def test_a_plan_lowers_the_pressure_and_sends_more_to_the_treated_side(flow, capsys):
    outputs = ["--json", "f.json", "--report", "f.html", "--export-0d", "nets"]
    assert flow("--plan", flow.plan, "--mean-flow", "3L/min", *PRESSURES, *outputs) == 0
    said = capsys.readouterr().out
    document = json.loads(Path("f.json").read_text(encoding="utf-8"))
    before, after = document["before"]["mean"], document["after"]["mean"]
    assert before["flow_ml_s"] == pytest.approx(50)
    assert before["inlet_mmhg"]["value"] == pytest.approx(30)
    assert after["inlet_mmhg"]["value"] < 30
    assert before["share"]["right"]["value"] == pytest.approx(0.7)
    assert after["share"]["left"]["value"] > before["share"]["left"]["value"]
    assert sum(one["value"] for one in after["share"].values()) == pytest.approx(1)
    names = [one["name"] for one in before["narrowings"]]
    assert names[0] == "stent 1"
    assert names[1].startswith("lesion 1, ")
    for old, new in zip(before["narrowings"][:2], after["narrowings"][:2], strict=True):
        assert new["recovered_mmhg"]["high"] < old["recovered_mmhg"]["low"]
    value = before["narrowings"][0]["recovered_mmhg"]["value"]
    assert f"drop over stent 1: recovered {value:.1f} (" in said
    assert "inlet pressure: 30.0 -> " in said
    page = Path("f.html").read_text(encoding="utf-8")
    assert "drop over stent 1" in page
    assert "Research use only" in page


def test_the_networks_run_unchanged_in_svzerod(flow):
    svzerod = pytest.importorskip("svzerod")
    assert flow("--plan", flow.plan, "--mean-flow", "50mL/s", *PRESSURES, "--export-0d", "n") == 0
    inlets = [
        svzerod.simulate(str(Path("n", name))).pressure_in.iloc[0] / 1333.22
        for name in ("before.json", "after.json")
    ]
    assert inlets[0] == pytest.approx(30, rel=1e-4)
    assert inlets[1] < inlets[0]


def test_without_a_plan_and_pressures_only_drops_before_are_told(flow, capsys):
    assert flow("--mean-flow", "50mL/s", "--peak-flow", "120mL/s", "--json", "f.json") == 0
    document = json.loads(Path("f.json").read_text(encoding="utf-8"))
    assert document["after"] is None
    assert document["before"]["mean"]["inlet_mmhg"] is None
    drops = [document["before"][at]["narrowings"][0] for at in ("mean", "peak")]
    assert drops[1]["recovered_mmhg"]["value"] > 3 * drops[0]["recovered_mmhg"]["value"]
    said = capsys.readouterr().out
    assert "->" not in said
    assert "Without pressures the split is as given" in said


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ((), "expected --mean-flow Q"),
        (("--mean-flow", "50"), "--mean-flow: expected a flow with its unit"),
        (("--mean-flow=-5mL/s",), "greater than 0"),
        (("--mean-flow", "50mL/s", "--wedge", "5"), "that of the wedge alone"),
        (
            ("--mean-flow", "200mL/s", "--inlet-pressure", "13", "--wedge", "12.9"),
            "expected more than the vessel itself costs",
        ),
        (("--mean-flow", "50mL/s", "--wave", "none.csv"), "none.csv"),
        (("--mean-flow", "50mL/s", "--report", "f.txt"), "f.txt"),
    ],
)
def test_bad_input_is_a_sentence_and_nothing_is_written(flow, capsys, more, words):
    assert flow(*more, "--json", "f.json") == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not list(Path().iterdir())


def test_a_solver_that_dies_leaves_nothing(flow, capsys, monkeypatch):
    monkeypatch.setattr("SDFStentLib.cli.flow.has_svzerod", lambda: True)
    monkeypatch.setattr("SDFStentLib.flow.svzerod._RUN", "import os; os._exit(9)")
    rows = "s,mL/s\n0,10\n0.2,120\n0.4,10\n0.8,10\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    assert flow("--wave", "wave.csv", "--json", "f.json") == 2
    assert "svzerod: expected an answer, got exit code 9" in capsys.readouterr().err
    assert [one.name for one in Path().iterdir()] == ["wave.csv"]


def test_without_svzerod_a_wave_is_taken_as_steady_flows_and_said_so(flow, capsys, monkeypatch):
    monkeypatch.setattr("SDFStentLib.cli.flow.has_svzerod", lambda: False)
    rows = "s,mL/s\n0,10\n0.2,120\n0.4,10\n0.8,10\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    assert flow("--wave", "wave.csv", "--json", "f.json") == 0
    assert "without inertia" in capsys.readouterr().out


def test_the_library_of_flow_needs_no_solver():
    """It is no dependency: nothing imports it before a wave is solved."""
    code = "import sys, SDFStentLib.flow; sys.exit('svzerod' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
