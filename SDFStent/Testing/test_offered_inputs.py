"""What is loaded while the panel is open is taken where nothing has to be asked; without a centerline an axis is drawn at once."""

import pytest
import slicer
from panel_helpers import clickSample, settle


def test_vessel_and_centerline_are_taken_as_they_come(host, aPanel):
    from SDFStentSlicer.SampleVessels import addSampleVessel

    parameters = aPanel._parameterNode
    vessel, centerline = addSampleVessel("branching_pulmonary_artery", "Artery")
    slicer.mrmlScene.RemoveNode(centerline)
    host.process()
    assert parameters.vessel is vessel
    assert parameters.centerline is None
    other, centerline = addSampleVessel("branching_pulmonary_artery", "Other")
    slicer.mrmlScene.RemoveNode(other)
    host.process()
    assert (parameters.vessel, parameters.centerline) == (vessel, centerline)
    settle(host, aPanel)
    assert aPanel.ui.lesionTable.rowCount == 1


def test_of_two_none_is_taken_and_a_choice_stays(host, aPanel):
    vessel, centerline = clickSample("StenosedPulmonaryArtery")
    host.process()
    assert aPanel._parameterNode.vessel is vessel
    clickSample("AortaWithCoarctation")
    host.process()
    assert (aPanel._parameterNode.vessel, aPanel._parameterNode.centerline) == (vessel, centerline)


def test_of_two_that_come_at_once_none_is_taken(host, aPanel):
    clickSample("StenosedPulmonaryArtery")
    clickSample("AortaWithCoarctation")
    host.process()
    assert aPanel._parameterNode.vessel is None


def isPlacing():
    interaction = slicer.app.applicationLogic().GetInteractionNode()
    return interaction.GetCurrentInteractionMode() == interaction.Place


def test_without_a_centerline_add_lets_draw_at_once(host, aPanel, aVessel):
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    aPanel.ui.centerlineSelector.setCurrentNode(None)
    host.click(aPanel.ui.addStentButton)
    assert isPlacing()
    assert "click along its axis" in aPanel.ui.statusLabel.text
    handle = aPanel._parameterNode.stent.handle
    selection = slicer.app.applicationLogic().GetSelectionNode()
    assert selection.GetActivePlaceNodeID() == handle.GetID()
    aPanel.ui.placeWidget.placeModeEnabled = False


@pytest.mark.parametrize("kind", ["vessel", "lesion"])
def test_with_one_it_does_not(host, theInputs, kind):
    settle(host, theInputs)
    if kind == "lesion":
        theInputs.ui.lesionTable.selectRow(0)
    host.click(theInputs.ui.addStentButton)
    assert not isPlacing()
