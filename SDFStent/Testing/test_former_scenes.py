"""Scenes of the versions that had a parameter for every value of a plan, and of those that have one document.

`former_scene.json` holds the parameters that version 7ffd2f1 wrote for two plans, and what it said that the plans are.
"""

import json
from pathlib import Path

import pytest
import slicer

FORMER = json.loads((Path(__file__).parent / "former_scene.json").read_text(encoding="utf-8"))
PARTS = ("inputs", "stents", "flow", "settings")


def addFormer(scene, name, vessel, centerline, isSlicers=False):
    """A parameter node as the former version has saved it; its name is that of the plan.

    Slicer itself adds the number of the node's kind to a role, which the stand-in does not.
    """
    node = scene.CreateNodeByClass("vtkMRMLScriptedModuleNode")
    node.UnRegister(None)
    node.SetName(name)
    node.SetAttribute("ModuleName", "SDFStent")
    node = scene.AddNode(node)
    for key, value in FORMER[name]["parameters"].items():
        node.SetParameter(key, value)
    for role, one in (("vessel", vessel), ("centerline", centerline)):
        node.SetNodeReferenceID(role, one.GetID())
    for number, (label, kind, points) in enumerate(FORMER[name]["handles"]):
        handle = scene.AddNewNodeByClass(kind, label)
        for point in points:
            handle.AddControlPointWorld(*point)
        kind = f".{int('Curve' in kind)}" if isSlicers else ""
        node.SetNodeReferenceID(f"stents.{number}.handle{kind}", handle.GetID())
    node.SetNodeReferenceID(f"stent.handle{kind}", handle.GetID())
    return node


def planIn(parameters):
    from SDFStentSlicer import Plans

    document = json.loads(Plans.textOf(parameters))
    document["flow"]["right"] = None  # which a live deployment may have found by now
    return {part: document[part] for part in PARTS}


def rounded(value):
    """As a file of markups keeps it."""
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, list):
        return [rounded(one) for one in value]
    return round(value, 6) if isinstance(value, float) else value


@pytest.fixture(params=[False, True], ids=["page", "Slicer"])
def theFormerPlans(aScene, aVessel, request):
    return {name: addFormer(aScene, name, *aVessel, request.param) for name in FORMER}


@pytest.mark.parametrize("name", FORMER)
def test_a_former_plan_is_taken_over_whole_and_said_once(aLogic, theFormerPlans, name):
    from SDFStentSlicer import FormerScenes

    node = theFormerPlans[name]
    parameters = aLogic.parameterSet(node)
    assert planIn(parameters) == FORMER[name]["plan"]
    assert "former version" in FormerScenes.toldOf(parameters)
    assert not [one for one in node.GetParameterNames() if one.startswith(("stents.", "method."))]
    assert node.GetParameter("planDocument") is None or not node.GetParameter("planDocument")
    aLogic.forget()
    again = aLogic.parameterSet(node)
    assert again is not parameters
    assert planIn(again) == FORMER[name]["plan"]
    again.stent.diameter = 8.125
    assert FormerScenes.toldOf(again) == ""


def test_former_plans_come_back_from_a_scene_and_go_on_in_the_new_form(
    host, aPanel, theFormerPlans, aScene, tmp_path
):
    former, new = tmp_path / "former.mrb", tmp_path / "new.mrb"
    assert aScene.WriteToMRB(str(former))
    for path, following in ((former, new), (new, None)):
        host.newScene()
        assert aScene.ReadFromMRB(str(path), True)
        host.process()
        nodes = aPanel.logic.getAllParameterNodes()
        assert {node.GetName() for node in nodes} == set(FORMER)
        for node in nodes:
            found = planIn(aPanel.logic.parameterSet(node))
            assert rounded(found) == rounded(FORMER[node.GetName()]["plan"])
        assert ("former version" in aPanel.ui.statusLabel.text) == (path is former)
        if following is not None:
            assert aScene.WriteToMRB(str(following))


def test_what_is_changed_in_a_former_plan_is_undone_to_it(host, aPanel, theFormerPlans):
    panel = aPanel
    panel.ui.parameterSetSelector.setCurrentNode(theFormerPlans["stents"])
    host.processUntil(lambda: not panel.sections[0]._timer.isActive())
    before, parameters = planIn(panel._parameterNode), panel._parameterNode
    assert before == FORMER["stents"]["plan"]
    panel.ui.diameterSlider.value = 9.5
    panel.ui.influenceDistanceSlider.value = 12.0
    panel.ui.flowMeanSpinBox.value = 5.5
    host.processUntil(lambda: not panel.sections[0]._timer.isActive())
    assert planIn(parameters) != before
    host.click(panel.ui.undoButton)
    assert planIn(parameters) == before


def test_the_node_holds_one_document_and_no_value_of_the_plan_beside_it(aLogic, theParameters):
    names = set(theParameters.parameterNode.GetParameterNames())
    assert not [one for one in names if one.startswith(("stent", "method", "flow"))]
    document = json.loads(theParameters.parameterNode.GetParameter("plan"))
    assert document["stents"][0]["diameter"] == theParameters.stent.diameter == 8.5
    theParameters.change({"stents.0.diameter": 7.25, "settings.tissue_gap": 0.5})
    assert theParameters.stents[0].diameter == 7.25
    assert theParameters.method.tissueGap == 0.5
    references = []
    theParameters.parameterNode.GetNodeReferenceRoles(references)
    assert slicer.mrmlScene is not None
    assert "stents.0.handle" in references


def test_every_bound_widget_has_a_value_of_the_plan(aPanel):
    """By the schema of plans, but for what only the panel knows of a stent."""
    from SDFStentLib.plan import NEW_STENT, plan_schema

    own = {"handle", "whole_curve", "device_shortening", "redilation"}
    assert own - {"handle"} <= set(NEW_STENT)
    paths = [one.property("plan") for one in vars(aPanel.ui).values() if hasattr(one, "property")]
    paths = [path for path in paths if path]
    assert len(paths) == len(set(paths)) >= 30
    for path in paths:
        parts = path.removeprefix("stents.selected.").split(".")
        kind = plan_schema()["properties"]
        if path.startswith("stents."):
            if parts[0] in own or parts == ["balloon", "by_rule"]:  # which its reason says
                continue
            kind = kind["stents"]["items"]["properties"]
        for number, part in enumerate(parts):
            assert part in kind, path
            if number < len(parts) - 1:
                inner = kind[part]
                kind = (inner.get("anyOf") or [inner])[0]["properties"]


def test_every_other_bound_widget_has_a_parameter_of_the_node(aPanel):
    widgets = [one for one in vars(aPanel.ui).values() if hasattr(one, "property")]
    names = [name for one in widgets if (name := one.property("SlicerParameterName"))]
    assert len(names) == len(set(names)) >= 15
    assert set(names) <= set(aPanel._parameterNode.allParameters)
