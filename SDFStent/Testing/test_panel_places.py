"""Plans whose stents lie at lesions, on branches, or nowhere yet, in the panel."""

import json

import numpy as np
import pytest
from panel_helpers import deploy, planned, pointsOf, saveAsFile, settle

from SDFStentLib.plan import Plan, load_plan, run_plan, save_plan
from SDFStentLib.stent import AtCenter, AtLesion, InputFile, OnBranch, Stent


@pytest.fixture(autouse=True)
def thePlacement(theModule):
    """The panel's own placements, once its package can be imported."""
    global Placement
    from SDFStentSlicer.ParameterNode import Placement


PLACES = [AtLesion(1), AtLesion(1, 1.5), OnBranch(2, 9.0), OnBranch(2, fraction=0.4)]


@pytest.fixture
def theFiles(theInputs, tmp_path):
    """Vessel and centerline of the panel, as files."""
    parameters = theInputs._parameterNode
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    return [InputFile(tmp_path / f"{name}.vtp") for name in ("Artery", "Artery centerline")]


def load(host, panel, placement, files, path, frame="LPS"):
    stent = Stent(8.0, placement=placement, length=12.0, name="there")
    save_plan(Plan([stent], *files, frame=frame), path)
    host.files.append(str(path))
    host.click(panel.ui.loadPlanButton)


@pytest.mark.parametrize("placement", PLACES)
@pytest.mark.parametrize("frame", ["LPS", None])
def test_a_plan_by_lesion_or_branch_gives_the_wall_of_the_shell_and_is_saved_as_it_was(
    host, theInputs, theFiles, tmp_path, placement, frame
):
    parameters, path = theInputs._parameterNode, tmp_path / "plan.json"
    load(host, theInputs, placement, theFiles, path, frame)
    deploy(host, theInputs)
    expected = run_plan(load_plan(path)).treatment.points * (-1, -1, 1)
    assert np.abs(expected - pointsOf(parameters.vessel)).max() > 0.3
    shown = theInputs.logic.lastRun(parameters).result.points
    np.testing.assert_allclose(shown, expected, rtol=0, atol=1e-4)
    again = tmp_path / "again.json"
    theInputs.logic.savePlan(again, parameters)
    assert load_plan(again).stents[0].placement == placement


def test_the_handle_follows_a_place_and_frees_it_when_the_mouse_takes_it(
    host, theInputs, theFiles, tmp_path
):
    ui, parameters, logic = theInputs.ui, theInputs._parameterNode, theInputs.logic
    load(host, theInputs, AtLesion(1), theFiles, tmp_path / "plan.json")
    settle(host, theInputs)

    def handle():
        return np.array(parameters.stent.handle.GetNthControlPointPositionWorld(0))

    def lying():
        return logic.lying(parameters, logic.centerlineOf(parameters)).stent.placement.point

    np.testing.assert_allclose(handle(), lying(), atol=1e-9)
    assert ui.landmarkComboBox.visible
    assert ui.landmarkComboBox.currentText.startswith("1 left pulmonary artery, 40 %")
    assert ui.landmarkSpinBox.value == -100  # as it fits
    ui.landmarkSpinBox.value = 3.0
    assert planned(theInputs)[0].placement == AtLesion(1, 3.0)
    np.testing.assert_allclose(handle(), lying(), atol=1e-9)
    ui.lengthSlider.value = 8.0
    np.testing.assert_allclose(handle(), lying(), atol=1e-9)
    point = handle()
    theInputs.onHandleGrabbed(parameters.stent.handle)
    assert parameters.stent.placement in (Placement.CENTER, Placement.DISTAL_END)
    np.testing.assert_array_equal(planned(theInputs)[0].placement.point, point)
    assert not ui.landmarkComboBox.visible


def test_a_place_is_chosen_where_the_handle_was(host, aStent):
    ui, parameters = aStent.ui, aStent._parameterNode
    settle(host, aStent)
    choose(host, ui, Placement.AT_LESION)
    assert planned(aStent)[0].placement == AtLesion(1)
    choose(host, ui, Placement.ON_BRANCH)
    place = planned(aStent)[0].placement
    names = [ui.landmarkComboBox.itemText(n) for n in range(ui.landmarkComboBox.count)]
    assert names == list(aStent.logic.landmarks(parameters).branch_names)
    assert ui.landmarkComboBox.currentIndex == place.branch - 1
    assert ui.landmarkSpinBox.value == pytest.approx(place.distance)
    tree = aStent.logic.centerlineOf(parameters)
    expected = tree.point_at(place.branch - 1, place.distance)
    at = parameters.stent.handle.GetNthControlPointPositionWorld(0)
    lying = aStent.logic.lying(parameters, tree).stent
    np.testing.assert_allclose(at, lying.placement.point, atol=1e-9)
    if isinstance(lying.placement, AtCenter):
        np.testing.assert_allclose(at, expected, atol=1e-6)
    host.choose(ui.landmarkComboBox, 2)
    assert planned(aStent)[0].placement == OnBranch(3, place.distance)
    deploy(host, aStent)
    assert parameters.certificateSummary
    choose(host, ui, Placement.CENTER)
    assert planned(aStent)[0].placement.point is not None


def choose(host, ui, kind):
    host.choose(ui.placementComboBox, list(Placement).index(kind))
    host.process()


def test_what_is_at_a_lesion_is_copied_moved_taken_back_and_kept_by_the_scene(
    host, aStent, tmp_path
):
    ui, parameters, buttons = aStent.ui, aStent._parameterNode, aStent.sections[0]
    settle(host, aStent)

    def rest():
        host.processUntil(lambda: not buttons._timer.isActive())

    rest()
    choose(host, ui, Placement.AT_LESION)
    rest()
    ui.landmarkSpinBox.value = 2.0
    rest()
    host.click(ui.undoButton)
    assert planned(aStent)[0].placement == AtLesion(1)
    host.click(ui.redoButton)
    assert planned(aStent)[0].placement == AtLesion(1, 2.0)
    rest()
    host.click(ui.copyStentButton)
    first, second = parameters.stents
    assert second.placement != Placement.AT_LESION  # it lies beside the first one
    assert first.placement == Placement.AT_LESION
    ui.stentTable.selectRow(0)
    before = np.array(first.handle.GetNthControlPointPositionWorld(0))
    aStent._moveStent(2.0)
    moved = np.array(parameters.stents[0].handle.GetNthControlPointPositionWorld(0))
    assert np.linalg.norm(moved - before) == pytest.approx(2.0, abs=0.1)
    assert parameters.stents[0].placement == Placement.CENTER


@pytest.mark.parametrize(
    ("placement", "sentence"),
    [
        (AtLesion(9), "lesion: expected 1, for so many there are, got 9"),
        (OnBranch("LPA", 9.0), "branch: expected 1 to 3 or one of"),
        (OnBranch(2, 900.0), "distance: expected a number at least 0 and at most"),
    ],
)
def test_what_the_vessel_has_not_is_told(host, theInputs, theFiles, tmp_path, placement, sentence):
    load(host, theInputs, placement, theFiles, tmp_path / "plan.json")
    settle(host, theInputs)
    host.click(theInputs.ui.deployButton)
    settle(host, theInputs)
    assert sentence in theInputs.ui.statusLabel.text
    theInputs.ui.landmarkSpinBox.value = 5.0
    host.choose(theInputs.ui.landmarkComboBox, 0)
    deploy(host, theInputs)
    assert theInputs._parameterNode.certificateSummary


def test_while_it_is_dragged_a_stent_at_a_lesion_is_previewed(host, theInputs, theFiles, tmp_path):
    load(host, theInputs, AtLesion(1), theFiles, tmp_path / "plan.json")
    settle(host, theInputs)
    theInputs.ui.autoUpdateCheckBox.checked = True
    theInputs.ui.diameterSlider.value = 9.0
    settle(host, theInputs)
    assert theInputs.logic.lastRun(theInputs._parameterNode).result is not None
    assert "9.0" in theInputs.ui.lumenLabel.text


@pytest.fixture
def oneNowhere(host, aStent):
    """The panel with a second stent that is off, and whose handle has no points yet."""
    host.click(aStent.ui.addStentButton)
    parameters = aStent._parameterNode
    host.choose(aStent.ui.placementComboBox, 2)  # by its proximal end
    parameters.stent.handle.RemoveAllControlPoints()
    aStent._onEnableStent(1, False)
    aStent.ui.diameterSlider.value = 6.5
    settle(host, aStent)
    return aStent


def test_a_stent_that_is_off_and_lies_nowhere_is_saved_and_read(host, oneNowhere, tmp_path):
    path = tmp_path / "plan.json"
    oneNowhere.logic.savePlan(path, oneNowhere._parameterNode)
    first, second = json.loads(path.read_text(encoding="utf-8"))["stents"]
    assert first["placement"] is not None
    assert (second["placement"], second["enabled"], second["diameter"]) == (None, False, 6.5)
    oneNowhere.logic.loadPlan(path, oneNowhere._parameterNode)
    stents = oneNowhere._parameterNode.stents
    assert [one.enabled for one in stents] == [True, False]
    assert stents[1].handle.GetNumberOfControlPoints() == 0
    deploy(host, oneNowhere)
    assert oneNowhere._parameterNode.certificateSummary


def test_undo_goes_on_beside_a_stent_that_lies_nowhere(host, oneNowhere):
    ui, buttons = oneNowhere.ui, oneNowhere.sections[0]

    def rest():
        host.processUntil(lambda: not buttons._timer.isActive())

    rest()
    handle = oneNowhere._parameterNode.stents[1].handle
    ui.stentTable.selectRow(0)
    ui.diameterSlider.value = 7.0
    rest()
    ui.diameterSlider.value = 9.0
    rest()
    host.click(ui.undoButton)
    first, second = oneNowhere._parameterNode.stents
    assert first.diameter == 7.0
    assert (second.placement, second.diameter) == (Placement.PROXIMAL_END, 6.5)
    assert second.handle is handle
