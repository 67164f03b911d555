"""The plan document between panel, command line and Python."""

import json
from dataclasses import replace

import numpy as np
import pytest
import slicer
from panel_helpers import expanded, handleNames, saveAsFile, theThroat

from SDFStentLib.stent import OfStent


def test_a_saved_plan_gives_the_same_points_after_loading(aLogic, theParameters, tmp_path):
    theParameters.method.influenceDistance = 5.5
    aLogic.addStent(theParameters, diameter=9.0, length=8.0, handle=theParameters.stents[0].handle)
    points = expanded(aLogic, theParameters)
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    aLogic.restoreMethod(theParameters)
    aLogic.stentList(theParameters).replace([], -1)
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert [stent.label for stent in theParameters.stents] == ["Stent 1", "Stent 2"]
    assert theParameters.method.influenceDistance == 5.5
    np.testing.assert_allclose(expanded(aLogic, theParameters), points, atol=1e-9)


def test_handles_of_the_stents_that_a_plan_replaces_do_not_stay_in_the_views(
    aLogic, theParameters, aScene, tmp_path
):
    path, former = tmp_path / "plan.json", theParameters.stents[0].handle
    aLogic.savePlan(path, theParameters)
    own = aScene.AddNewNodeByClass("vtkMRMLMarkupsFiducialNode", "User's own")
    own.AddControlPointWorld(*theThroat())
    aLogic.addStent(theParameters, handle=own)
    other = aLogic.addParameterSet("Other")
    aLogic.addStent(other, handle=former)
    aLogic.loadPlan(path, theParameters)
    assert former.GetScene() is aScene  # the other plan has it, too
    aLogic.loadPlan(path, other)
    assert former.GetScene() is None
    handles = [plan.stents[0].handle for plan in (theParameters, other)]
    assert sorted(handleNames(aScene)) == sorted(["User's own", *(h.GetName() for h in handles)])


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
    points = expanded(aLogic, theParameters)
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert theParameters.stent.placement == placement
    # A curve gives its points in single precision once more.
    tolerance = 1e-5 if placement == Placement.ALONG_CURVE else 1e-9
    np.testing.assert_allclose(expanded(aLogic, theParameters), points, atol=tolerance)


def writePlan(path, aLogic, theParameters, change):
    """A plan of these parameters, changed as a document."""
    aLogic.savePlan(path, theParameters)
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    path.write_text(json.dumps(document), encoding="utf-8")


def inFrame(frame):
    """Give a plan's document, in RAS, another frame: its points with it."""

    def change(document):
        document["inputs"]["frame"] = frame
        for stent in document["stents"]:
            x, y, z = stent["placement"]["center"]
            stent["placement"]["center"] = [-x, -y, z]

    return change


@pytest.mark.parametrize("frame", ["RAS", "LPS"])
def test_points_without_a_frame_are_in_that_of_the_vessels_file(
    host, aPanel, aLogic, theParameters, tmp_path, frame
):
    place = theParameters.stent.handle.GetNthControlPointPositionWorld(0)
    change = inFrame(None) if frame == "LPS" else lambda d: d["inputs"].update(frame=None)
    writePlan(tmp_path / "plan.json", aLogic, theParameters, change)
    saveAsFile(theParameters.vessel, tmp_path / "artery.vtp", frame)
    host.files.append(str(tmp_path / "plan.json"))
    aPanel.ui.vesselSelector.setCurrentNode(theParameters.vessel)
    host.click(aPanel.ui.loadPlanButton)
    parameters = aPanel._parameterNode
    np.testing.assert_array_equal(parameters.stent.handle.GetNthControlPointPositionWorld(0), place)
    assert f"does not name the frame of its points; {frame} is taken" in parameters.status


def test_points_without_a_frame_and_without_a_file_are_in_ras(aLogic, theParameters, tmp_path):
    place = theParameters.stent.handle.GetNthControlPointPositionWorld(0)
    writePlan(
        tmp_path / "plan.json", aLogic, theParameters, lambda d: d["inputs"].update(frame=None)
    )
    aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    np.testing.assert_array_equal(
        theParameters.stent.handle.GetNthControlPointPositionWorld(0), place
    )
    assert "RAS is taken" in theParameters.status


@pytest.mark.parametrize("frame", ["RAS", "LPS"])
def test_a_saved_plan_fits_its_surface_without_a_space_tag(aLogic, theParameters, tmp_path, frame):
    """The library does not turn points where the file names no frame: they have to be in its own."""
    from SDFStentLib.plan import load_plan, run_plan

    for node in (theParameters.vessel, theParameters.centerline):
        path = tmp_path / f"{node.GetName()}.vtp"
        saveAsFile(node, path, frame)
        removeFrame(path)
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    plan = load_plan(tmp_path / "plan.json")
    assert plan.frame == frame
    turn = (-1, -1, 1) if frame == "LPS" else (1, 1, 1)
    expected = expanded(aLogic, theParameters) * turn
    np.testing.assert_allclose(run_plan(plan).treatment.points, expected, rtol=0, atol=1e-9)


def removeFrame(path):
    import vtk

    reader, writer = vtk.vtkXMLPolyDataReader(), vtk.vtkXMLPolyDataWriter()
    reader.SetFileName(str(path))
    reader.Update()
    reader.GetOutput().GetFieldData().Initialize()
    writer.SetFileName(str(path))
    writer.SetInputData(reader.GetOutput())
    assert writer.Write()


WIDE = {"influence_distance": 40.0, "step": 3.0, "capsule_length": 8.0, "smoothing_width": 4.0}


def test_values_that_the_library_takes_are_shown(host, aPanel, aLogic, theParameters, tmp_path):
    def change(document):
        document["stents"][0].update(diameter=65.0, length=350.0)
        document["settings"].update(WIDE)

    writePlan(tmp_path / "plan.json", aLogic, theParameters, change)
    host.files.append(str(tmp_path / "plan.json"))
    host.click(aPanel.ui.loadPlanButton)
    ui, method = aPanel.ui, aPanel._parameterNode.method
    assert aPanel._parameterNode.status == ""
    assert (ui.diameterSlider.value, ui.lengthSlider.value) == (65.0, 350.0)
    assert (
        ui.influenceDistanceSlider.value,
        ui.stepSpinBox.value,
        ui.capsuleLengthSlider.value,
    ) == (40, 3, 8)
    assert (method.influenceDistance, method.step, method.capsuleLength) == (40, 3, 8)
    assert aPanel._parameterNode.stents[0].diameter == 65.0


@pytest.mark.parametrize(
    ("key", "limit", "sentence"),
    [
        ("diameter", 8.0, r"Stent 2: expected a diameter of 0.1 to 8 mm in the panel, got 8.5;"),
        ("length", 9.0, r"Stent 2: expected a length of 0.1 to 9 mm in the panel, got 14;"),
        ("influenceDistance", 3.0, r"an influence distance of 0.05 to 3 mm .* got 6.5;"),
        ("step", 0.2, r"settings: expected a step of 0 to 0.2 mm .* got 0.3; change"),
    ],
)
def test_what_cannot_be_shown_is_said_and_leaves_nothing(
    aLogic, theParameters, aScene, tmp_path, monkeypatch, key, limit, sentence
):
    """With a panel that reaches less far than the library, which refuses the same values itself."""
    from SDFStentSlicer.PlanFields import RANGES

    from SDFStentLib.validation import InputError

    aLogic.copyStent(theParameters)
    writePlan(
        tmp_path / "plan.json",
        aLogic,
        theParameters,
        lambda document: (
            document["settings"].update(step=0.3),
            document["stents"][0].update(diameter=7.0, length=8.0),
        ),
    )
    stents, count = aLogic.stentList(theParameters).values(), aScene.GetNumberOfNodes()
    monkeypatch.setitem(RANGES, key, RANGES[key]._replace(high=limit))
    with pytest.raises(InputError, match=sentence):
        aLogic.loadPlan(tmp_path / "plan.json", theParameters)
    assert aScene.GetNumberOfNodes() == count
    assert aLogic.stentList(theParameters).values() == stents
    assert theParameters.method.step == 0.0


def test_saving_a_plan_of_vessels_without_a_file_is_said(host, aStent, tmp_path):
    parameters, path = aStent._parameterNode, tmp_path / "plan.json"
    sentence = lambda: savedWith(host, aStent, path)  # noqa: E731
    assert "The plan is saved without a file of Artery" in sentence()
    assert "Artery centerline" in sentence()
    assert "save the scene first" in sentence()
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    assert sentence() == ""
    parameters.vessel.GetPolyData().GetPoints().GetData().Modified()
    parameters.vessel.GetPolyData().Modified()
    assert "without a file of Artery:" in sentence()


def savedWith(host, panel, path):
    host.files.append(str(path))
    host.click(panel.ui.savePlanButton)
    assert path.is_file()
    return panel._parameterNode.status


DETAILED = {
    "device": {
        "name": "bench-16",
        "nominal_length": 16,
        "lengths": [[4, 16], [12, 12]],
        "source": "own bench",
    },
    "balloon": {"diameter": 8.0, "recoil_fraction": 0.1, "reason": "as given"},
    "keeps": "proximal",
    "shape": {"waist": {"diameter": 6.0, "position": 0.5, "length": None}, "cap_height": 0.5},
}
"""What a plan may say of a stent that the panel has no controls for."""


@pytest.fixture
def aDetailedPlan(aLogic, theParameters, tmp_path):
    """The panel's plan, its stent with a device, a balloon, a kept end and a waist."""
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    document = json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    stent = document["stents"][0]
    stent.update(DETAILED, diameter=7.2, length=16.0, foreshortening_fraction=None)
    (tmp_path / "plan.json").write_text(json.dumps(document), encoding="utf-8")
    return tmp_path / "plan.json"


def test_what_the_panel_has_no_controls_for_survives_a_plan(aLogic, theParameters, aDetailedPlan):
    from SDFStentLib.plan import load_plan

    aLogic.loadPlan(aDetailedPlan, theParameters)
    aLogic.savePlan(aDetailedPlan.with_name("again.json"), theParameters)
    (first,), (again,) = (
        load_plan(path).stents for path in (aDetailedPlan, aDetailedPlan.with_name("again.json"))
    )
    assert (again.device, again.balloon, again.keeps) == (first.device, first.balloon, first.keeps)
    assert again.shape == first.shape
    assert (again.diameter, again.length) == (first.diameter, first.length)
    assert again.foreshortening == first.foreshortening
    (stent,) = aLogic.deploy(theParameters).stents
    assert stent.axis.deployed_length == pytest.approx(16 - 3.2 / 2)
    assert stent.after.minimum == pytest.approx(6.0, abs=0.15)


AGAIN = {
    "diameter": 9.0,
    "balloon": {"diameter": 10.0, "recoil_fraction": 0.1},
    "keeps": "proximal",
}
"""The detailed stent dilated again as the panel does it."""


def withStent(path, **values):
    document = json.loads(path.read_text(encoding="utf-8"))
    document["stents"].append({"placement": {"stent": 1}, **values})
    path.write_text(json.dumps(document), encoding="utf-8")


@pytest.mark.parametrize(
    "change",
    [
        {"keeps": "distal"},
        {"balloon": {"diameter": 9.5, "recoil_fraction": 0.05263157894736842}},
        {"enabled": False},
        {"foreshortening_fraction": 0.2},
    ],
)
def test_a_redilation_that_is_another_than_at_once_is_a_row_of_its_own(
    aLogic, theParameters, aDetailedPlan, change
):
    from SDFStentSlicer import Plans
    from SDFStentSlicer.ParameterNode import Placement

    from SDFStentLib.plan import load_plan

    withStent(aDetailedPlan, **{**AGAIN, **change})
    aLogic.loadPlan(aDetailedPlan, theParameters)
    first, second = theParameters.stents
    assert (first.redilation, second.placement) == (0.0, Placement.AGAIN)
    assert second.handle is first.handle
    _first, expected = load_plan(aDetailedPlan).stents
    _first, found = Plans.planOf(theParameters).stents
    assert replace(found, name=expected.name) == expected
    assert found.name == (expected.name or "Stent")


def test_a_redilation_of_a_redilation_comes_back(aLogic, theParameters, aDetailedPlan, tmp_path):
    """As the library has it, at once or later, saved as a plan and with the scene."""
    from SDFStentSlicer import Plans

    from SDFStentLib.plan import load_plan

    withStent(aDetailedPlan, **AGAIN)
    withStent(
        aDetailedPlan, **{**AGAIN, "diameter": 9.9, "balloon": None, "placement": {"stent": 2}}
    )
    last = {"diameter": 10.4, "balloon": None, "placement": {"stent": 3}, "name": "last"}
    withStent(aDetailedPlan, **{**AGAIN, **last})
    expected = load_plan(aDetailedPlan).stents
    aLogic.loadPlan(aDetailedPlan, theParameters)
    saved = tmp_path / "saved.json"
    aLogic.savePlan(saved, theParameters)
    inScene = aLogic.parameterSet(theParameters.parameterNode)
    for found in (Plans.planOf(inScene).stents, load_plan(saved).stents):
        assert [one.placement for one in found[1:]] == [OfStent(1), OfStent(2), OfStent(3)]
        assert [one.diameter for one in found] == [one.diameter for one in expected]
        assert [one.balloon for one in found] == [one.balloon for one in expected]
    handles = {stent.handle.GetID() for stent in theParameters.stents}
    assert len(handles) == 1
    stents = aLogic.stentList(theParameters)
    stents.enable(1, False)  # which then is passed over
    numbers = [getattr(one.placement, "number", None) for one in Plans.planOf(theParameters).stents]
    assert numbers == [None, 1, 2, 2]


def test_a_stent_that_dilates_one_below_it_is_refused(aLogic, theParameters, aDetailedPlan):
    withStent(aDetailedPlan, **{**AGAIN, "placement": {"stent": 3}})
    before = aLogic.stentList(theParameters).values()
    with pytest.raises(ValueError, match="stent 2: expected a stent above it to dilate again, got"):
        aLogic.loadPlan(aDetailedPlan, theParameters)
    assert aLogic.stentList(theParameters).values() == before


def test_vessels_are_called_as_the_plan_does(aLogic, theParameters, tmp_path):
    """In the list of lesions, in the report and in the plan that is saved, in either frame."""
    throat = theThroat()
    x, y, z = throat.tolist()
    path = tmp_path / "plan.json"
    aLogic.savePlan(path, theParameters)
    document = json.loads(path.read_text(encoding="utf-8"))
    for frame, place in (("RAS", [x, y, z]), ("LPS", [-x, -y, z])):
        changes = {"frame": frame, "names": {"LPA": place}, "units": "mm"}
        stents = [{**one, "enabled": False} for one in document["stents"]]
        named = {**document, "inputs": document["inputs"] | changes, "stents": stents}
        path.write_text(json.dumps(named), encoding="utf-8")
        aLogic.loadPlan(path, theParameters)
        search = aLogic.lesionSearch(theParameters)
        list(search.portions())
        assert [lesion.branch_name for lesion in search.found] == ["LPA"]
        assert not search.remark
        aLogic.restoreMethod(theParameters)
        assert aLogic.lesionSearch(theParameters) is search
        aLogic.savePlan(path, theParameters)
        kept = json.loads(path.read_text(encoding="utf-8"))["inputs"]
        factor = {"mm": 1, "cm": 10}[kept["units"]] * (-1 if kept["frame"] == "LPS" else 1)
        np.testing.assert_allclose(factor * np.array(kept["names"]["LPA"][:2]), [x, y])
    named["inputs"]["names"] = {"LPA": [500, 0, 0]}
    path.write_text(json.dumps(named), encoding="utf-8")
    aLogic.loadPlan(path, theParameters)
    search = aLogic.lesionSearch(theParameters)
    list(search.portions())
    assert search.found[0].branch_name != "LPA"
    assert "expected a place in a vessel" in search.remark


@pytest.fixture
def aMarkedPlan(aLogic, theParameters, tmp_path):
    """A plan file in LPS with a root and healthy vessel of its own: those of the far end, and beside the first lesion."""
    from SDFStentLib.plan import load_plan, save_plan

    vessel, centerline = theParameters.vessel, theParameters.centerline
    for node, name in ((vessel, "wall.vtp"), (centerline, "line.vtp")):
        saveAsFile(node, tmp_path / name, "LPS")
    aLogic.savePlan(tmp_path / "plan.json", theParameters)
    plan = load_plan(tmp_path / "plan.json")
    tree = aLogic.centerlineOf(theParameters)
    search = aLogic.lesionSearch(theParameters)
    for _part in search.portions():
        pass
    path = tree.path_around(search.found[0].point, 80.0)
    marks = np.array([tree.points[tree.leaves[0]], path.points[0]]) * (-1, -1, 1)
    root, healthy = (tuple(float(value) for value in mark) for mark in marks)
    assert plan.frame == "LPS"
    save_plan(replace(plan, root=root, reference=(healthy,)), tmp_path / "marked.json")
    return tmp_path / "marked.json"


def test_root_and_healthy_vessel_of_a_plan_are_used_and_saved(
    aLogic, theParameters, aMarkedPlan, tmp_path
):
    from SDFStentLib.plan import load_plan, read_plan_inputs

    plan = load_plan(aMarkedPlan)
    before = aLogic.centerlineOf(theParameters).points[0]
    aLogic.loadPlan(aMarkedPlan, theParameters)
    assert theParameters.status == ""
    tree = aLogic.centerlineOf(theParameters)
    root = tree.points[tree.parent == -1][0] if (tree.parent == -1).any() else tree.points[0]
    inputs = read_plan_inputs(plan)
    np.testing.assert_allclose(root, inputs.vessel.root * (-1, -1, 1), atol=1e-4)
    assert np.linalg.norm(root - before) > 10.0
    search = aLogic.lesionSearch(theParameters)
    for _part in search.portions():
        pass
    found, expected = search.found, inputs.vessel.lesions
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected, strict=True):
        assert one.percent_diameter == pytest.approx(other.percent_diameter, abs=0.01)
        assert one.reference_diameter == pytest.approx(other.reference_diameter, abs=1e-3)
    aLogic.savePlan(tmp_path / "again.json", theParameters)
    again = load_plan(tmp_path / "again.json")
    np.testing.assert_allclose(again.root, plan.root, atol=1e-9)
    np.testing.assert_allclose(again.reference, plan.reference, atol=1e-9)


def test_root_and_healthy_vessel_go_along_with_the_centerline(
    aLogic, theParameters, aMarkedPlan, aScene
):
    from SDFStentSlicer import Plans
    from vtkmodules.vtkCommonMath import vtkMatrix4x4

    aLogic.loadPlan(aMarkedPlan, theParameters)
    aLogic.carry(theParameters)
    before = Plans.marksOf(theParameters)
    move = aScene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    for node in (theParameters.vessel, theParameters.centerline):
        node.SetAndObserveTransformNodeID(move.GetID())
    matrix = vtkMatrix4x4()
    for row, value in enumerate((5.0, -7.0, 11.0)):
        matrix.SetElement(row, 3, value)
    move.SetMatrixTransformToParent(matrix)
    assert aLogic.carry(theParameters)
    after = Plans.marksOf(theParameters)
    np.testing.assert_allclose(after.root - before.root, (5.0, -7.0, 11.0), atol=1e-9)
    np.testing.assert_allclose(after.reference[0] - before.reference[0], (5.0, -7.0, 11.0))
