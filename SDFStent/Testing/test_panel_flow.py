"""The flow of the patient in the results: what the library says of the last deployment, in the words of the report."""

import json
import subprocess

import pytest
import slicer
from panel_helpers import deploy, saveAsFile, settle

from SDFStentLib.validation import DeploymentError


def words(panel):
    """What the report says of the panel's results."""
    from SDFStentLib.report import flow_moments, flow_section, stents_in

    section = flow_section(panel.logic.lastRun(panel._parameterNode).flow)
    told = flow_moments(section, stents_in(section))
    lines = [[f"{at}:", *(f"{one.label} {one.change}" for one in facts)] for at, facts in told]
    return "\n\n".join(map("\n".join, lines)), section["notes"]


def aFlow(ui):
    ui.flowMeanSpinBox.value, ui.flowPeakSpinBox.value = 3.0, 7.2
    ui.splitRightSpinBox.value = 70
    ui.inletPressureSpinBox.value, ui.wedgePressureSpinBox.value = 30, 12


def test_a_flow_tells_what_the_library_tells_of_the_same_vessels(host, aStent):
    from SDFStentLib.flow import FlowModel, FollowedChannels, Known, SideClues, channels_of

    ui = aStent.ui
    aFlow(ui)
    deploy(host, aStent)
    lines, notes = words(aStent)
    assert ui.lumenLabel.text.endswith("\n\n".join([lines, *notes]))
    assert "inlet pressure 30.0 -> " in lines
    run = aStent.logic.lastRun(aStent._parameterNode)
    known = Known(50.0, peak=120.0, inlet=30.0, wedge=12.0, split_right=0.7)
    # Once more, by hand.
    vessel, result = run.search.vessel, run.result
    channels = channels_of(vessel.surface, vessel.centerline)
    followed = FollowedChannels(vessel.surface, vessel.centerline, channels)
    answer = FlowModel(channels, known, SideClues("RAS")).answer(
        followed.after(result.centerline, result.surface)
    )
    assert run.flow.after["mean"].inlet.value == pytest.approx(
        answer.after["mean"].inlet.value, rel=1e-9
    )


@pytest.mark.parametrize("isLive", [False, True])
def test_another_flow_is_told_without_another_deployment(host, aStent, isLive):
    ui, session = aStent.ui, aStent.session
    deploy(host, aStent)
    ui.autoUpdateCheckBox.checked = isLive
    settle(host, aStent)
    run = aStent.logic.lastRun(aStent._parameterNode)
    for mean in (3.0, 4.0):
        ui.flowMeanSpinBox.value = mean
        settle(host, aStent)
        assert f"At the mean flow of {mean * 1000 / 60:.3g} mL/s" in ui.lumenLabel.text
        assert words(aStent)[0] in ui.lumenLabel.text
        assert ui.lumenLabel.enabled  # nothing has changed but what is told
        assert ui.statusLabel.text == ""
    ui.flowMeanSpinBox.value = 0.0
    settle(host, aStent)
    assert "ressure" not in ui.lumenLabel.text
    assert not session.isBusy
    assert aStent.logic.lastRun(aStent._parameterNode) is run
    aStent.logic.reset(aStent._parameterNode)
    ui.flowMeanSpinBox.value = 3.0
    settle(host, aStent)
    assert ui.lumenLabel.text == ""


def test_why_a_flow_is_not_known_is_told_at_once(host, aStent, monkeypatch):
    from SDFStentSlicer.Lesions import LesionSearch

    from SDFStentLib.validation import InputError

    def fail(_search, _known, _result):
        raise InputError(
            "flow: expected a lumen at the outlet, got none; make the centerline anew."
        )

    ui = aStent.ui
    deploy(host, aStent)
    with monkeypatch.context() as patched:
        patched.setattr(LesionSearch, "flow", fail)
        ui.flowMeanSpinBox.value = 3.0
        settle(host, aStent)
    assert ui.statusLabel.text.startswith("flow: expected a lumen at the outlet, got none")
    assert ui.statusLabel.text in ui.lumenLabel.text
    ui.flowMeanSpinBox.value = 4.0
    settle(host, aStent)
    assert ui.statusLabel.text == ""


def test_a_contradictory_flow_is_refused_in_a_sentence(host, aStent):
    ui = aStent.ui
    deploy(host, aStent)
    ui.flowMeanSpinBox.value, ui.flowPeakSpinBox.value = 6.0, 3.0
    assert ui.statusLabel.text.startswith(
        "Results: expected a peak flow of 6 L/min or more, got 3 L/min"
    )
    assert slicer.util.shownMessages[-1] == ui.statusLabel.text  # Flow is far below that
    assert not ui.deployButton.enabled
    settle(host, aStent)
    ui.flowPeakSpinBox.value = 0.0
    ui.inletPressureSpinBox.value, ui.wedgePressureSpinBox.value = 10, 12
    assert "which contradict each other" in ui.statusLabel.text
    ui.wedgePressureSpinBox.value = 5
    assert ui.statusLabel.text == ""
    settle(host, aStent)
    assert "ressure" in ui.lumenLabel.text


def test_a_plan_of_the_panel_tells_the_shell_where_right_is(host, aStent, tmp_path):
    """In the frame of the plan, which the file need not tell."""
    from SDFStentLib.plan import load_plan, run_plan

    aFlow(aStent.ui)
    deploy(host, aStent)
    for node in (aStent._parameterNode.vessel, aStent._parameterNode.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    plan = tmp_path / "plan.json"
    aStent.logic.savePlan(plan, aStent._parameterNode)
    assert load_plan(plan).flow.right is not None
    share = run_plan(load_plan(plan)).flow.after["mean"].sides[1].value
    own = aStent.logic.lastRun(aStent._parameterNode).flow.after["mean"].sides[1].value
    assert share == pytest.approx(own, abs=1e-3)


@pytest.fixture
def aPlanWithAWave(aStent, tmp_path):
    """A plan of the panel whose flow is a wave."""
    aFlow(aStent.ui)
    path = tmp_path / "wave.json"
    aStent.logic.savePlan(path, aStent._parameterNode)
    document = json.loads(path.read_text(encoding="utf-8"))
    del document["flow"]["peak"]
    document["flow"]["mean"] /= 2
    document["flow"]["wave"] = {"time": [0, 0.2, 0.5, 0.8], "flow": [10, 60, 15, 10]}
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_a_wave_of_a_plan_is_told_and_kept_until_its_peak_is_changed(
    host, aStent, aPlanWithAWave, tmp_path, monkeypatch
):
    from SDFStentLib.plan import load_plan

    for where in (
        "SDFStentLib.plan.known_entry",
        "SDFStentLib.plan.run",
    ):  # a solver takes its time
        monkeypatch.setattr(f"{where}.has_svzerod", lambda: False)

    ui, parameters = aStent.ui, aStent._parameterNode
    aStent.logic.loadPlan(aPlanWithAWave, parameters)
    deploy(host, aStent)
    wave = aStent.logic.lastRun(parameters).flow.known.wave
    assert wave.flow == pytest.approx(load_plan(aPlanWithAWave).flow.wave.flow)
    again = tmp_path / "again.json"
    aStent.logic.savePlan(again, parameters)
    assert load_plan(again).flow.wave.flow == pytest.approx(wave.flow)
    ui.flowPeakSpinBox.value += 1
    settle(host, aStent)
    assert aStent.logic.lastRun(parameters).flow.known.wave is None


def test_inlets_of_a_plan_are_told_and_kept(host, aStent, tmp_path):
    from SDFStentLib.plan import load_plan

    aFlow(aStent.ui)
    aStent.ui.splitRightSpinBox.value = 0
    path, again = tmp_path / "inlets.json", tmp_path / "again.json"
    aStent.logic.savePlan(path, aStent._parameterNode)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["flow"] |= {"inlets": [{"name": "branch 1", "mean": 50.0}], "bsa": 1.2}
    path.write_text(json.dumps(document), encoding="utf-8")
    aStent.logic.loadPlan(path, aStent._parameterNode)
    deploy(host, aStent)
    known = aStent.logic.lastRun(aStent._parameterNode).flow.known
    assert [(one.name, one.mean) for one in known.inlets] == [("branch 1", pytest.approx(50.0))]
    aStent.ui.flowMeanSpinBox.value = 6.0
    settle(host, aStent)
    aStent.logic.savePlan(again, aStent._parameterNode)
    flow = load_plan(again).flow
    assert flow.bsa == 1.2
    assert [(one.name, one.mean) for one in flow.inlets] == [("branch 1", pytest.approx(100.0))]


def test_the_solver_of_waves_is_offered_where_it_is_missing_and_never_required(
    host, aStent, aPlanWithAWave, monkeypatch
):
    import slicer
    from SDFStentSlicer import Flow

    ui, parameters, installed = aStent.ui, aStent._parameterNode, []
    monkeypatch.setattr(slicer.util, "pip_install", installed.append, raising=False)
    for where in ("SDFStentLib.plan.known_entry", "SDFStentLib.plan.run"):
        monkeypatch.setattr(f"{where}.has_svzerod", lambda: bool(installed))
    assert not ui.installSolverButton.visible
    aStent.logic.loadPlan(aPlanWithAWave, parameters)
    deploy(host, aStent)
    assert ui.installSolverButton.visible
    assert aStent.logic.lastRun(parameters).flow.is_quasi_steady
    solved = "SDFStentLib.plan.run.solved_by_svzerod"
    asked = []

    def solve(network, outlets, known):
        asked.append(known.wave)
        raise DeploymentError("svzerod: it died")

    monkeypatch.setattr(solved, solve)
    pip = ["PythonSlicer", "-m", "pip", "install", Flow.SOLVER]
    for error in (subprocess.CalledProcessError(1, pip), RuntimeError("PythonSlicer not found")):

        def fail(_requirement, error=error):
            raise error

        with monkeypatch.context() as offline:
            offline.setattr(slicer.util, "pip_install", fail, raising=False)
            host.click(ui.installSolverButton)
        said = f'svzerod: expected to install it, got "{error}"; mean and peak are told without it'
        assert said in ui.statusLabel.text
        assert ui.installSolverButton.visible
    host.click(ui.installSolverButton)
    settle(host, aStent)
    assert installed == [Flow.SOLVER]
    assert "expected to install" not in ui.statusLabel.text
    assert asked
    assert "svzerod: it died" in ui.lumenLabel.text
    assert not ui.installSolverButton.visible


def test_a_flow_beyond_the_panels_is_refused_with_its_plan(aLogic, theParameters, tmp_path):
    path = tmp_path / "plan.json"
    aLogic.savePlan(path, theParameters)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["flow"] = {"mean": 2000.0, "unusual": True}
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ValueError, match="flow: expected a mean flow of 0 to 60 L/min in the"):
        aLogic.loadPlan(path, theParameters)
    assert theParameters.flowMean == 0.0


def knownOf(parameters):
    from SDFStentLib.plan import known_of

    return known_of(parameters.get("flow"))


def test_of_a_flow_that_is_forgotten_nothing_is_taken_for_the_next_one(host, aStent):
    """As in the page, where another patient is opened."""
    ui, parameters = aStent.ui, aStent._parameterNode
    aFlow(ui)
    ui.unusualFlowCheckBox.checked = True
    host.process()
    assert knownOf(parameters).wedge == 12.0
    parameters.change({"flow": None})
    host.process()
    ui.flowMeanSpinBox.value = 4.0
    host.process()
    known = knownOf(parameters)
    assert (known.peak, known.inlet, known.wedge, known.split_right) == (None,) * 4
    assert not known.unusual
    ui.inletPressureSpinBox.value = 30
    host.process()
    assert knownOf(parameters).wedge == 0.0


def test_a_mean_flow_of_none_keeps_what_else_is_known(host, aStent):
    ui, parameters = aStent.ui, aStent._parameterNode
    aFlow(ui)
    host.process()
    before = knownOf(parameters)
    ui.flowMeanSpinBox.value = 0.0
    host.process()
    assert knownOf(parameters) is None
    ui.flowMeanSpinBox.value = 3.0
    host.process()
    assert knownOf(parameters) == before
