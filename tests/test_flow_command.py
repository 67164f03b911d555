"""Flow before and after on the synthetic patient: the command, and plans that know a flow."""

import json
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
from test_plan import SCHEMA
from tube_files import deploy, plan_of, write_vessel

from benchmarks.phantoms import branching_pulmonary_artery
from SDFStentLib.cli import main
from SDFStentLib.flow import Known
from SDFStentLib.plan import load_plan, save_plan
from SDFStentLib.report.facts import GLANCE
from SDFStentLib.report.flow import flow_facts


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
    # The trunk's neck, whose jet the lesion at the ostium takes, stays.
    pairs = list(zip(before["narrowings"], after["narrowings"], strict=True))
    for (old, new), kind in zip(pairs, ("recovered_mmhg", "maximal_mmhg"), strict=False):
        assert new[kind]["high"] < old[kind]["low"]
        assert new["recovered_mmhg"]["value"] < old["recovered_mmhg"]["value"]
    value = before["narrowings"][0]["recovered_mmhg"]["value"]
    assert f"drop over stent 1: recovered {value:.1f} (" in said
    assert "inlet pressure: 30.0 -> " in said
    page = Path("f.html").read_text(encoding="utf-8")
    assert "drop over stent 1" in page
    assert "Research use only" in page


def test_a_stent_in_an_ostium_changes_the_split_as_the_navier_stokes_equations_say(flow):
    """docs/flow.md: of what finite volumes lose on both ways, with resistances that are kept."""
    known = ["--inlet-pressure", "30", "--wedge", "10", "--split-right", "0.7"]
    assert flow("--plan", flow.plan, "--mean-flow", "50mL/s", *known, "--json", "f.json") == 0
    after = json.loads(Path("f.json").read_text(encoding="utf-8"))["after"]["mean"]
    left, inlet = after["share"]["left"], after["inlet_mmhg"]
    assert left["low"] < 0.318 < left["high"]
    assert left["value"] - 0.3 == pytest.approx(0.018, rel=0.3)
    assert inlet["low"] < 29.5 < inlet["high"]


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
    ("words", "told"),
    [((), ", assumed"), (("--split-right", "0.7"), ", as given"), (PRESSURES, "")],
)
def test_a_split_that_no_pressure_tells_is_no_result(flow, capsys, words, told):
    """It is as much after treatment as before, whatever a stent does."""
    assert flow("--plan", flow.plan, "--mean-flow", "50mL/s", *words, "--json", "f.json") == 0
    lines = [one for one in capsys.readouterr().out.splitlines() if "flow to the" in one]
    assert len(lines) == 2
    assert all(one.endswith(f" %{told}") for one in lines)
    facts = flow_facts(json.loads(Path("f.json").read_text(encoding="utf-8")), "mean")
    tiles = [one.tile for one in facts if one.level == GLANCE]
    assert [one.startswith("Flow to the ") for one in tiles] == ([False] if told else [True, False])


def test_what_no_vessel_of_this_kind_can_have_is_refused_before_anything_is_deployed(
    flow, capsys, monkeypatch
):
    monkeypatch.delattr("SDFStentLib.cli.flow.treatment_of")
    pressures = ("--inlet-pressure", "12.1", "--wedge", "12")
    assert flow("--plan", flow.plan, "--mean-flow", "3L/min", *pressures) == 2
    assert "12.1" in capsys.readouterr().err


def test_a_solver_that_dies_leaves_nothing(flow, capsys, monkeypatch):
    monkeypatch.setattr("SDFStentLib.plan.run.has_svzerod", lambda: True)
    monkeypatch.setattr("SDFStentLib.flow.svzerod._RUN", "import os; os._exit(9)")
    rows = "s,mL/s\n0,10\n0.2,120\n0.4,10\n0.8,10\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    assert flow("--wave", "wave.csv", "--json", "f.json") == 2
    assert "svzerod: expected an answer, got exit code 9" in capsys.readouterr().err
    assert [one.name for one in Path().iterdir()] == ["wave.csv"]


STILL = "time_s,flow_mL/s\n0,0\n0.2,100\n0.4,0\n0.8,0\n"
"""In diastole: the commonest wave of a pulmonary artery."""


@pytest.mark.parametrize("has_solver", [True, False])
def test_a_wave_that_stands_still_is_told_in_every_door(
    flow, patient, capsys, monkeypatch, recwarn, has_solver
):
    if not has_solver:
        monkeypatch.setattr("SDFStentLib.plan.run.has_svzerod", lambda: False)
    Path("wave.csv").write_text(STILL, encoding="utf-8")
    known = [
        "--wave",
        "wave.csv",
        "--mean-flow",
        "12mL/s",
        "--inlet-pressure",
        "30",
        "--wedge",
        "10",
    ]
    vessel = [str(patient / "surface.vtp"), "--centerline", str(patient / "centerline.vtp")]
    stent = ["--center", "-4", "0", "29", "--diameter", "7", "--length", "14"]
    kept = ["--save-plan", "p.json", "--report", "d.json", "--report", "d.html"]
    assert flow("--plan", flow.plan, *known, "--json", "f.json", "--report", "f.html") == 0
    assert main(["deploy", *vessel, *stent, *known, "-o", "s.vtp", *kept]) == 0
    assert main(["run", "p.json", "-o", "out"]) == 0
    assert main(["compare", "p.json", flow.plan, "-o", "c.html"]) == 0
    said = capsys.readouterr()
    line = "mean 12, peak 48 mL/s, regurgitant fraction 0 %, a cycle of 0.8 s, 75 beats/min"
    pages = [Path(name).read_text(encoding="utf-8") for name in ("f.html", "d.html", "c.html")]
    for told in (said.out, *pages, Path("out/report.html").read_text(encoding="utf-8")):
        assert line in told
        assert not re.search(r"\bnan\b|\bNone\b|-> %|\binf\b", told)
    assert not [one for one in recwarn if issubclass(one.category, RuntimeWarning)]
    for document in (read("f.json"), read("d.json")["flow"], read("out/report.json")["flow"]):
        for state in (document["before"], document["after"]):
            shares = [band["value"] for band in state["mean"]["share"].values()]
            assert sum(shares) == pytest.approx(1)
            assert all(
                0 < band["low"] < band["high"] < 1 for band in state["mean"]["share"].values()
            )
    assert read("f.json")["known"]["wave"] == pytest.approx(
        {"cycle_s": 0.8, "rate_per_min": 75, "regurgitant_fraction": 0}
    )


def test_what_is_unusual_is_carried_out_where_it_is_said_to_be_meant(a_folder, capsys):
    rows = "time_s,flow_mL/s\n0,1\n80,7\n400,1\n800,1\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    assert deploy("--wave", "wave.csv", "--save-plan", "p.json") == 2
    assert "0.075 beats/min" in capsys.readouterr().err
    assert not Path("p.json").exists()
    assert main(["flow", *TUBE, "--mean-flow", "41.7L/min"]) == 2
    assert "or tell that it is meant so (--unusual-flow)." in capsys.readouterr().err
    assert main(["flow", *TUBE, "--mean-flow", "41.7L/min", "--unusual-flow"]) == 0
    assert deploy("--wave", "wave.csv", "--unusual-flow", "--save-plan", "p.json") == 0
    assert load_plan("p.json").flow.unusual
    jsonschema.validate(read("p.json"), SCHEMA)
    assert main(["run", "p.json", "-o", "out"]) == 0
    document = read("p.json")
    del document["flow"]["unusual"]
    Path("q.json").write_text(json.dumps(document), encoding="utf-8")
    capsys.readouterr()
    assert main(["run", "q.json", "-o", "out2"]) == 2
    assert 'meant so ("unusual": true in the flow of a plan).' in capsys.readouterr().err


def test_a_cycle_is_told_and_how_rows_were_taken_is_said(a_folder, capsys):
    rows = ["time_ms,flow_mL/min"]
    rows += [f"{40 * k},{max(0, 900 * (1 - abs(k - 4) / 4))}" for k in range(20)]
    Path("wave.csv").write_text("\n".join(rows), encoding="utf-8")
    assert main(["flow", *TUBE, "--wave", "wave.csv"]) == 0
    said = capsys.readouterr()
    assert "wave.csv: The last of 20 rows does not repeat the first one" in said.err
    assert "tell its length (--cycle T) if" in said.err
    assert "mean 3, peak 15 mL/s" in said.out
    assert main(["flow", *TUBE, "--wave", "wave.csv", "--cycle", "1s"]) == 0
    said = capsys.readouterr()
    assert "mean 2.4, peak 15 mL/s, regurgitant fraction 0 %, a cycle of 1 s, 60 beats" in said.out
    assert "rows" not in said.err
    assert main(["flow", *TUBE, "--mean-flow", "40mL/s", "--cycle", "1s"]) == 2
    assert "--cycle: expected a wave beside it" in capsys.readouterr().err


def test_without_svzerod_a_wave_is_taken_as_steady_flows_and_said_so(flow, capsys, monkeypatch):
    monkeypatch.setattr("SDFStentLib.plan.run.has_svzerod", lambda: False)
    rows = "s,mL/s\n0,10\n0.2,120\n0.4,10\n0.8,10\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    assert flow("--wave", "wave.csv", "--json", "f.json") == 0
    assert "without inertia" in capsys.readouterr().out


def test_the_library_of_flow_needs_no_solver():
    """It is no dependency: nothing imports it before a wave is solved."""
    code = "import sys, SDFStentLib.flow; sys.exit('svzerod' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def read(path):
    return json.loads(Path(path).read_text(encoding="utf-8"))


PATIENT = {"mean": 50.0, "peak": 120.0, "inlet": 30.0, "wedge": 12.0, "split_right": 0.7}


def test_a_plan_that_knows_a_flow_tells_what_the_command_tells(flow, patient, tmp_path, capsys):
    """In shell, report, page and comparison; networks, too."""
    documents = {"with": read(flow.plan) | {"flow": PATIENT}, "without": read(flow.plan)}
    for name, document in documents.items():
        # Beside the files that it names.
        (patient / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    plan = str(patient / "with.json")
    assert main(["run", plan, "-o", "out", "--export-0d", "nets"]) == 0
    said = capsys.readouterr().out
    told = [*PRESSURES, "--mean-flow", "50mL/s", "--peak-flow", "120mL/s"]
    assert flow("--plan", flow.plan, *told, "--json", "f.json", "--export-0d", "nets2") == 0
    own, other = read("out/report.json")["flow"], read("f.json")
    assert own == {key: other[key] for key in own}
    assert read("nets/after.json") == read("nets2/after.json")
    value = own["after"]["mean"]["inlet_mmhg"]["value"]
    line = next(one for one in said.splitlines() if one.startswith("At the mean flow of 50 mL/s"))
    assert f"inlet pressure 30.0 -> {value:.1f} (" in line
    assert "drop over stent 1 recovered" in line
    page = Path("out/report.html").read_text(encoding="utf-8")
    assert "<h2>Pressure and flow</h2>" in page
    assert "No measured gradient" in page
    jsonschema.validate(read("out/plan.json"), SCHEMA)
    assert load_plan("out/plan.json").flow == Known(**PATIENT)
    assert main(["compare", plan, str(patient / "without.json"), "-o", "page.html"]) == 0
    page = Path("page.html").read_text(encoding="utf-8")
    assert page.count("At the peak flow of 120 mL/s (7.2 L/min), inlet pressure") == 1


def test_deploy_keeps_a_flow_in_its_plan(a_folder, capsys):
    rows = "s,L/min\n0,1\n0.2,7\n0.4,1\n0.8,1\n"
    Path("wave.csv").write_text(rows, encoding="utf-8")
    files = ["--save-plan", "p.json", "--report", "r.json", "--export-0d", "nets"]
    assert deploy("--wave", "wave.csv", "--mean-flow", "8mL/s", *files) == 0
    kept = load_plan("p.json").flow
    assert kept.mean == 8
    assert kept.wave.time == (0, 0.2, 0.4, 0.8)
    assert kept.wave.flow == pytest.approx((3.2, 22.4, 3.2, 3.2))
    assert read("r.json")["flow"]["known"]["peak_flow_ml_s"] == pytest.approx(22.4)
    before, after = (
        read(f"nets/{name}.json")["vessels"][0]["zero_d_element_values"]
        for name in ("before", "after")
    )
    assert after["stenosis_coefficient"] < 0.1 * before["stenosis_coefficient"]
    jsonschema.validate(read("p.json"), SCHEMA)
    save_plan(load_plan("p.json"), "again.json")
    assert load_plan("again.json").flow == kept


def beside(x):
    """A plan in cm whose stent has its middle beside the line of the tube."""
    place = {"placement": {"center": [x, 0, 2]}, "length": 20, "diameter": 6}
    Path("beside.json").write_text(json.dumps(plan_of(place)), encoding="utf-8")


TUBE = ("tube.vtp", "--centerline", "line.vtp")


@pytest.mark.parametrize(
    "words",
    [
        ["run", "beside.json", "-o", "out"],
        ["flow", *TUBE, "--plan", "beside.json", "--mean-flow", "50mL/s"],
        ["flow", *TUBE, "--units", "cm", "--names", "names.json", "--mean-flow", "50mL/s"],
    ],
)
def test_a_place_that_is_refused_is_told_in_the_unit_of_the_file_too(a_folder, capsys, words):
    beside(5)
    Path("names.json").write_text('{"aorta": [5, 0, 2]}', encoding="utf-8")
    assert main(words) == 2
    assert "got (50, 0, 20) mm (in the file 5, 0, 2 cm), " in capsys.readouterr().err


def test_a_warning_of_a_plan_tells_places_in_the_unit_of_the_plan(a_folder, capsys):
    beside(0.15)
    assert main(["flow", *TUBE, "--plan", "beside.json", "--mean-flow", "50mL/s"]) == 0
    assert "(0, 0, 20) mm (in the file 0, 0, 2 cm), was taken" in capsys.readouterr().err


def test_a_place_in_the_right_branch_is_in_the_unit_of_the_plan(a_folder, capsys):
    made = branching_pulmonary_artery()
    write_vessel(a_folder, made)
    tree = made.centerline
    x, y, z = (f"{value:.3f}" for value in 0.095 * tree.points[tree.leaves[0]])
    place = {"placement": {"center": [0, 0, 1]}, "length": 5, "diameter": 12}
    inputs = {"surface": {"file": "pa.vtp"}, "centerline": {"file": "line.vtp"}, "units": "cm"}
    plan = plan_of(place, inputs=inputs)
    Path("plan.json").write_text(json.dumps(plan), encoding="utf-8")
    right = ["--mean-flow", "50mL/s", "--right", x, y, z]
    vessel = ["flow", "pa.vtp", "--centerline", "line.vtp"]
    assert main([*vessel, "--units", "cm", *right, "--json", "by_units.json"]) == 0
    assert main([*vessel, "--plan", "plan.json", *right, "--json", "by_plan.json"]) == 0
    by_units, by_plan = (read(name)["before"]["mean"] for name in ("by_units.json", "by_plan.json"))
    assert by_units["share"] == by_plan["share"]
