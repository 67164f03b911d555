"""The plan document between panel, command line and Python."""

import json

import numpy as np
import pytest
import slicer


def test_a_saved_plan_gives_the_same_points_after_loading(aLogic, theParameters, tmp_path):
    theParameters.method.influenceDistance = 5.5
    aLogic.addStent(theParameters, diameter=9.0, length=8.0, handle=theParameters.stents[0].handle)
    points = aLogic.deploy(theParameters).points
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    aLogic.restoreMethod(theParameters)
    aLogic.stentList(theParameters).replace([], -1)
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert [stent.label for stent in theParameters.stents] == ["Stent 1", "Stent 2"]
    assert theParameters.method.influenceDistance == 5.5
    np.testing.assert_allclose(aLogic.deploy(theParameters).points, points, atol=1e-9)


def test_settings_that_the_panel_does_not_show_survive(aLogic, theParameters, tmp_path):
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    document = json.loads((tmp_path / "plan.json").read_text())
    document["settings"]["calibration"] = "paper"
    (tmp_path / "plan.json").write_text(json.dumps(document))
    plain = aLogic.deploy(theParameters).points
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert np.abs(aLogic.deploy(theParameters).points - plain).max() > 1e-6
    assert json.loads(theParameters.planDocument)["settings"]["calibration"] == "paper"
    aLogic.restoreMethod(theParameters)
    np.testing.assert_allclose(aLogic.deploy(theParameters).points, plain, atol=1e-9)


@pytest.mark.parametrize("kind", ["BETWEEN_POINTS", "DISTAL_END", "ALONG_CURVE"])
def test_every_placement_survives(aLogic, theParameters, aScene, tmp_path, kind):
    from SDFStentSlicer import Conversion
    from SDFStentSlicer.ParameterNode import Placement

    stents, placement = aLogic.stentList(theParameters), Placement[kind]
    values = {**stents.values()[0], "placement": placement, "foreshortening": 3.0}
    if placement == Placement.ALONG_CURVE:
        centerline = Conversion.centerlineOf(theParameters.centerline)
        path = centerline.path_around(
            theParameters.stent.handle.GetNthControlPointPositionWorld(0), 20.0
        )
        curve = aScene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "Axis")
        slicer.util.updateMarkupsControlPointsFromArray(curve, path.points[::4])
        values.update(handle=curve, wholeCurve=False, length=11.0)
    stents.replace([values], 0)
    aLogic.fitHandle(theParameters)
    points = aLogic.deploy(theParameters).points
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert theParameters.stent.placement == placement
    # A curve gives its points in single precision once more.
    tolerance = 1e-5 if placement == Placement.ALONG_CURVE else 1e-9
    np.testing.assert_allclose(aLogic.deploy(theParameters).points, points, atol=tolerance)


def test_the_library_replays_the_plan_of_the_panel(aLogic, theParameters, tmp_path):
    """The same files, the same plan: the points of the command line, to 1e-9 mm."""
    from SDFStentLib.plan_reader import load_plan
    from SDFStentLib.plan_run import run_plan

    for node in (theParameters.vessel, theParameters.centerline):
        storage = slicer.vtkMRMLModelStorageNode()
        slicer.mrmlScene.AddNode(storage)
        node.SetAndObserveStorageNodeID(storage.GetID())
        storage.SetFileName(str(tmp_path / f"{node.GetName()}.vtp"))
        storage.SetCoordinateSystem(slicer.vtkMRMLStorageNode.CoordinateSystemRAS)
        assert storage.WriteData(node)
    points = aLogic.deploy(theParameters).points
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    plan = load_plan(tmp_path / "plan.json")
    assert plan.frame == "RAS"
    np.testing.assert_allclose(run_plan(plan).treatment.points, points, rtol=0, atol=1e-9)


def test_a_broken_plan_is_refused_in_the_panel(host, aPanel, tmp_path):
    (tmp_path / "plan.json").write_text('{"schema": "something else"}')
    host.files.append(str(tmp_path / "plan.json"))
    host.click(aPanel.ui.loadPlanButton)
    assert aPanel._parameterNode.status
    assert "Unexpected" not in aPanel._parameterNode.status
