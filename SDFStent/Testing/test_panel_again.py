"""Stents that dilate another one again, wherever they come in the plan."""

import numpy as np
import pytest
from panel_helpers import deploy, handleNames, planned, settle, theThroat

from SDFStentLib.report import stent_facts


@pytest.fixture
def twoStents(host, aStent):
    """The panel with two overlapping stents of 6 mm; the second is selected."""
    aStent.ui.diameterSlider.value = 6.0
    host.click(aStent.ui.copyStentButton)
    return aStent


def again(host, panel, diameter):
    """A third stent that dilates another one, as the user adds it."""
    host.click(panel.ui.copyStentButton)
    host.choose(panel.ui.placementComboBox, 5)
    panel.ui.diameterSlider.value = diameter
    host.process()


def test_a_stent_that_dilates_again_takes_the_handle_above_it_and_leaves_none(
    host, twoStents, aScene
):
    ui, parameters = twoStents.ui, twoStents._parameterNode
    count = len(handleNames(aScene))
    again(host, twoStents, 8.0)
    first, second, third = parameters.stents
    assert third.handle is second.handle
    assert len(handleNames(aScene)) == count
    assert [getattr(one.placement, "number", None) for one in planned(twoStents)] == [None, None, 2]
    assert not ui.lengthSlider.enabled
    assert ui.stentTable.item(2, 2).text() == "as placed"
    ui.handleSelector.setCurrentNode(first.handle)
    assert planned(twoStents)[2].placement.number == 1
    host.choose(ui.placementComboBox, 0)  # a stent of its own once more
    third = parameters.stents[2]
    assert third.handle not in (first.handle, second.handle)
    np.testing.assert_allclose(third.handle.GetNthControlPointPositionWorld(0), theThroat())


def test_a_stent_is_dilated_again_after_another_one(host, twoStents):
    """Against the library's treatment of the same stents."""
    from SDFStentLib.stent import AtCenter, OfStent, Stent
    from SDFStentLib.treatment import Treatment

    parameters, logic = twoStents._parameterNode, twoStents.logic
    tree = logic.centerlineOf(parameters)
    beyond = tree.path_around(theThroat(), 10.0).points[-1]
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *beyond)
    again(host, twoStents, 8.0)
    twoStents.ui.handleSelector.setCurrentNode(parameters.stents[0].handle)
    places = [stent.handle.GetNthControlPointPositionWorld(0) for stent in parameters.stents]
    deploy(host, twoStents)
    run = logic.lastRun(parameters)
    stents = [
        Stent(6.0, placement=AtCenter(np.array(places[0])), length=14.0),
        Stent(6.0, placement=AtCenter(np.array(places[1])), length=14.0),
        Stent(8.0, placement=OfStent(1)),
    ]
    expected = Treatment(logic._inputs.vessel(parameters).surface, stents, tree).result
    np.testing.assert_allclose(run.points, expected.points, atol=1e-9)
    assert run.result.certificate.passed
    assert run.result.stents[2].after.minimum == pytest.approx(8.0, abs=0.15)
    assert twoStents.ui.lumenLabel.text.count("Minimum lumen diameter") == 3


def test_without_a_stent_above_it_nothing_is_dilated_again_and_that_is_said(host, twoStents):
    ui = twoStents.ui
    again(host, twoStents, 8.0)
    name = twoStents._parameterNode.stent.label
    missing = f"{name}: choose the handle of the stent that it dilates again, which has to be above"
    for _ in range(2):
        host.click(ui.moveUpButton)
    assert ui.statusLabel.text.startswith(missing)
    assert not ui.deployButton.enabled
    for _ in range(2):
        host.click(ui.moveDownButton)
    assert ui.deployButton.enabled
    twoStents.stents.enable(1, False)
    assert ui.statusLabel.text.startswith(missing)
    twoStents.stents.enable(1, True)
    ui.stentTable.selectRow(1)
    host.click(ui.removeStentButton)
    assert ui.statusLabel.text.startswith(missing)
    handle = twoStents._parameterNode.stents[1].handle
    assert handle.GetScene() is not None  # still in use


def test_a_second_balloon_recoils_by_the_rule_in_the_lumen_of_the_first(host, twoStents):
    from SDFStentLib.stent import balloon_by_rule

    ui = twoStents.ui
    again(host, twoStents, 8.0)
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 20.0  # more than three times the lumen of 6 mm
    host.processUntil(lambda: not twoStents.recoil.isBusy)
    assert planned(twoStents)[2].balloon == balloon_by_rule(20.0, 6.0)
    assert planned(twoStents)[2].balloon != balloon_by_rule(20.0, 10.0)


def test_a_copied_plan_dilates_its_own_stent(host, twoStents):
    again(host, twoStents, 8.0)
    parameters, logic = twoStents._parameterNode, twoStents.logic
    copy = logic.duplicatePlan(parameters)
    _first, second, third = copy.stents
    assert third.handle is second.handle
    assert second.handle is not parameters.stents[1].handle
    assert planned(twoStents)[2].diameter == 8.0


def test_messages_count_stents_as_the_table_does(host, twoStents):
    """The first is dilated again at once, which is no row of its own: the second stays the second."""
    from SDFStentSlicer.Tiles import tilesOf

    ui, parameters = twoStents.ui, twoStents._parameterNode
    ui.flowMeanSpinBox.value = 3.0
    ui.stentTable.selectRow(0)
    ui.redilationSpinBox.value = 8.0
    ui.stentTable.selectRow(1)
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    deploy(host, twoStents)
    assert [one.number for one in treatedStents(twoStents)] == [1, 2, 3]
    assert [one.row for one in treatedStents(twoStents)] == [1, 1, 2]
    told = ui.warningLabel.text + ui.lumenLabel.text
    assert "Stents 1 and 2 overlap" in told
    assert "Stent 2" in told
    assert "tent 3" not in told
    assert "It is dilated again at once, and lies in the vessel as that." in told
    assert "as stent 2" not in told
    assert "drop over stent 1" in told
    assert "drop over stent 2" in told
    assert "Pressure drop" in [one.name for one in tilesOf(parameters)]
    assert "drop" in parameters.atHand
    parameters.stent.diameter = 60.0  # beyond any lumen here
    host.click(ui.deployButton)
    settle(host, twoStents)
    assert ui.statusLabel.text.startswith("Stent 2: ")


def treatedStents(panel):
    return panel.logic.lastRun(panel._parameterNode).result.stents


def test_a_stent_that_is_dilated_again_names_the_row_that_it_then_is(host, twoStents):
    """The library's stent 4 is the third row of the table: the first row is two of its stents."""
    ui = twoStents.ui
    ui.stentTable.selectRow(0)
    ui.redilationSpinBox.value = 8.0
    ui.stentTable.selectRow(1)
    again(host, twoStents, 9.0)
    deploy(host, twoStents)
    second = treatedStents(twoStents)[2]
    assert (second.number, second.row, second.again, second.again_row) == (3, 2, 4, 3)
    assert "It is dilated again as stent 3, and lies" in ui.lumenLabel.text
    assert "stent 4" not in ui.lumenLabel.text
    named = [stent_facts(one, None) for one in treatedStents(twoStents)]
    words = [one.named("redilates").words for one in named if one.value("redilates") is not None]
    assert words == ["at once", "of stent 2"]
