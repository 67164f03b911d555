"""The range of flow in the results: pressure drops as a band, in the words of the report."""

import json

import pytest
from panel_helpers import deploy, saveAsFile


@pytest.fixture
def theTube(host, aPanel, aScene):
    """The panel with a stent at the throat of a tube of 6 mm that is narrowed to 3.6, without branches."""
    from SDFStentSlicer.SampleVessels import centerlinePolyData

    from SDFStentLib.files import polydata_from_arrays
    from SDFStentLib.phantoms import stenosed_tube

    made = stenosed_tube(edge_length=0.8)
    for selector, data in (
        ("vesselSelector", polydata_from_arrays(made.points, made.triangles)),
        ("centerlineSelector", centerlinePolyData(made.centerline)),
    ):
        node = aScene.AddNewNodeByClass("vtkMRMLModelNode", selector)
        node.SetAndObservePolyData(data)
        getattr(aPanel.ui, selector).setCurrentNode(node)
    host.click(aPanel.ui.addStentButton)
    aPanel.ui.diameterSlider.value, aPanel.ui.lengthSlider.value = 6.0, 12.0
    return aPanel


def report(panel, flow):
    """What the report says of the panel's stent at a flow, mL/s."""
    from SDFStentLib.report import stent_pressure_sentences

    (treated,) = panel.logic.lastRun(panel._parameterNode).result.stents
    return stent_pressure_sentences(treated, flow, "L/min")


def test_there_is_no_pressure_drop_at_first(host, theTube):
    ui = theTube.ui
    assert (ui.flowLeastSpinBox.text, ui.flowMostSpinBox.text) == ("off", "the same")
    deploy(host, theTube)
    assert "Pressure" not in ui.lumenLabel.text


def test_a_flow_gives_the_band_of_the_report(host, theTube):
    ui = theTube.ui
    ui.flowLeastSpinBox.value, ui.flowMostSpinBox.value = 0.3, 0.6  # L/min
    deploy(host, theTube)
    words, note = report(theTube, (5.0, 10.0))
    assert words.startswith("Pressure drop over the stented length, estimated: before ")
    assert "mmHg at 0.3 L/min (5 mL/s), " in words
    assert ui.lumenLabel.text.endswith(f"{words}\n\n{note}")


def test_another_flow_is_told_without_another_deployment(host, theTube):
    ui, session = theTube.ui, theTube.session
    ui.flowLeastSpinBox.value = 0.3
    deploy(host, theTube)
    run = theTube.logic.lastRun(theTube._parameterNode)
    assert report(theTube, (5.0, 5.0))[0] in ui.lumenLabel.text
    ui.flowMostSpinBox.value = 0.9
    assert report(theTube, (5.0, 15.0))[0] in ui.lumenLabel.text
    assert ui.lumenLabel.enabled  # nothing has changed but what is told
    assert ui.statusLabel.text == ""
    ui.flowLeastSpinBox.value = 0.0
    assert "Pressure" not in ui.lumenLabel.text
    assert not session.isBusy
    assert theTube.logic.lastRun(theTube._parameterNode) is run
    host.click(ui.resetButton)
    ui.flowLeastSpinBox.value = 0.3
    assert ui.lumenLabel.text == ""


def test_a_contradictory_flow_is_refused_in_the_librarys_sentence(host, theTube):
    ui = theTube.ui
    deploy(host, theTube)
    ui.flowLeastSpinBox.value, ui.flowMostSpinBox.value = 0.6, 0.3
    assert ui.statusLabel.text.startswith(
        "Results: expected a flow at most of 0.6 L/min or more, got 0.3 L/min"
    )
    assert not ui.deployButton.enabled
    assert "Pressure" not in ui.lumenLabel.text
    ui.flowMostSpinBox.value = 0.6
    assert ui.statusLabel.text == ""
    assert "Pressure" in ui.lumenLabel.text


def test_there_is_no_upper_flow_while_the_flow_is_off(host, theTube):
    ui = theTube.ui
    assert not ui.flowMostSpinBox.enabled
    ui.flowLeastSpinBox.value = 0.3
    assert ui.flowMostSpinBox.enabled
    ui.flowMostSpinBox.value = 0.6
    ui.flowLeastSpinBox.value = 0.0
    assert not ui.flowMostSpinBox.enabled


def test_a_branch_within_the_stent_takes_the_estimate_away(host, aStent):
    from SDFStentLib.vessel import Ostium

    ui, parameters = aStent.ui, aStent._parameterNode
    tree = aStent.logic.centerlineOf(parameters)
    trunk = tree.path_from_proximal(tree.points[tree.roots[0]], 38.0).points[-1]
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *trunk)
    ui.diameterSlider.value, ui.lengthSlider.value = 10.0, 26.0
    ui.flowLeastSpinBox.value = 2.0
    deploy(host, aStent)
    (treated,) = aStent.logic.lastRun(parameters).result.stents
    assert [type(branch) for branch in treated.branches] == [Ostium]
    assert "Pressure drop: not estimated; flow leaves through" in ui.lumenLabel.text
    assert "No measured gradient" not in ui.lumenLabel.text


def test_the_flow_survives_scenes_and_plans(host, theTube, aScene, tmp_path):
    ui = theTube.ui
    ui.flowLeastSpinBox.value, ui.flowMostSpinBox.value = 2.0, 5.0
    for node in (theTube._parameterNode.vessel, theTube._parameterNode.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    plan = tmp_path / "plan.json"
    theTube.logic.savePlan(plan, theTube._parameterNode)
    assert json.loads(plan.read_text(encoding="utf-8"))["flow"] == pytest.approx([100 / 3, 250 / 3])
    host.saveAndLoad(tmp_path / "scene.mrb")
    assert (ui.flowLeastSpinBox.value, ui.flowMostSpinBox.value) == (2.0, 5.0)
    ui.flowLeastSpinBox.value = 0.0
    theTube.logic.loadPlan(plan, theTube._parameterNode)
    assert (ui.flowLeastSpinBox.value, ui.flowMostSpinBox.value) == (2.0, 5.0)


def test_a_flow_beyond_the_panels_is_refused_with_its_plan(aLogic, theParameters, tmp_path):
    path = tmp_path / "plan.json"
    aLogic.savePlan(path, theParameters)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["flow"] = [10.0, 2000.0]
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ValueError, match="flow: expected a flow at most of 0 to 60 L/min in the"):
        aLogic.loadPlan(path, theParameters)
    assert theParameters.flowLeast == 0.0
