"""Plans whose stents lie at lesions, on branches, or nowhere yet, in the panel."""

import json

import numpy as np
import pytest
from panel_helpers import deploy, pointsOf, saveAsFile, settle

from SDFStentLib.plan import Plan, load_plan, run_plan, save_plan
from SDFStentLib.stent import AtLesion, InputFile, OnBranch, Stent
from SDFStentLib.validation import InputError


@pytest.mark.parametrize(
    "placement", [AtLesion(1), AtLesion(1, 1.5), OnBranch(2, 9.0), OnBranch(2, fraction=0.4)]
)
@pytest.mark.parametrize("frame", ["LPS", None])
def test_a_plan_by_lesion_or_branch_gives_the_wall_of_the_shell(
    host, theInputs, tmp_path, placement, frame
):
    parameters, path = theInputs._parameterNode, tmp_path / "plan.json"
    for node in (parameters.vessel, parameters.centerline):
        saveAsFile(node, tmp_path / f"{node.GetName()}.vtp", "LPS")
    files = [InputFile(tmp_path / f"{name}.vtp") for name in ("Artery", "Artery centerline")]
    stent = Stent(8.0, placement=placement, length=12.0, name="there")
    save_plan(Plan([stent], files[0], files[1], frame=frame), path)
    host.files.append(str(path))
    host.click(theInputs.ui.loadPlanButton)
    assert "Places at lesions and on branches are points now" in theInputs.ui.statusLabel.text
    deploy(host, theInputs)
    expected = run_plan(load_plan(path)).treatment.points * (-1, -1, 1)
    assert np.abs(expected - pointsOf(parameters.vessel)).max() > 0.3
    shown = theInputs.logic.lastRun(parameters).result.points
    np.testing.assert_allclose(shown, expected, rtol=0, atol=1e-4)


def test_without_a_vessel_such_a_plan_is_refused_in_a_sentence_and_nothing_changes(
    host, aPanel, theInputs, tmp_path
):
    path, parameters = tmp_path / "plan.json", theInputs._parameterNode
    for placement, words in ((AtLesion(9), "lesion: expected 1, for so many"),):
        save_plan(Plan([Stent(8.0, placement=placement, length=12.0)]), path)
        with pytest.raises(InputError, match=f"plan.json: stent 1: {words}"):
            theInputs.logic.loadPlan(path, parameters)
    theInputs.ui.vesselSelector.setCurrentNode(None)
    save_plan(Plan([Stent(8.0, placement=AtLesion(1), length=12.0)]), path)
    with pytest.raises(InputError, match="expected a vessel and a centerline for a place at a"):
        theInputs.logic.loadPlan(path, parameters)
    assert len(parameters.stents) == 0


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
    from SDFStentSlicer.ParameterNode import Placement

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
