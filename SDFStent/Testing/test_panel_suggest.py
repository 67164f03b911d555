"""Suggest: a stent for the selected lesion by the library's rule, and the ratios of sizes."""

import pytest
from panel_helpers import deploy, planned, settle, suggest
from test_panel_lesions import clickRow, found


@pytest.fixture
def aLesion(host, theInputs):
    """The panel with the first lesion selected, and that lesion."""
    lesion = found(host, theInputs)[0]
    clickRow(host, theInputs.ui.lesionTable, 0)
    return theInputs, lesion


def smallerSide(lesion):
    """Diameter of the healthy vessel beside a lesion, mm."""
    return min(side.diameter for side in (lesion.proximal, lesion.distal) if side is not None)


def suggestion(panel, number=1, **wishes):
    """What the library proposes for a lesion."""
    from SDFStentLib.treatment import SizingWishes, Vessel

    parameters, logic = panel._parameterNode, panel.logic
    vessel = Vessel(logic._inputs.vessel(parameters).surface, logic.centerlineOf(parameters))
    return vessel.suggestion(number, SizingWishes(**wishes))


def test_suggest_sizes_the_stent_that_is_there(host, aLesion):
    panel, _lesion = aLesion
    host.click(panel.ui.addStentButton)
    clickRow(host, panel.ui.lesionTable, 0)
    logic, parameters = panel.logic, panel._parameterNode
    handle = parameters.stent.handle
    logic.setDevice(parameters, "gore-vbx")
    panel.ui.waistSpinBox.value = 4.0
    panel.ui.lengthSlider.value = 30.0
    panel.ui.nameEdit.text = "Main"
    suggest(host, panel)
    (stent,) = planned(panel)
    expected = suggestion(panel, device=stent.device)
    assert (stent.diameter, stent.length) == (expected.stent.diameter, expected.stent.length)
    assert stent.foreshortening == 0  # of the device
    assert (stent.name, stent.device.name, stent.shape.waist.diameter) == ("Main", "gore-vbx", 4.0)
    assert parameters.stent.handle is handle
    handle.SetNthControlPointPositionWorld(0, 0.0, 0.0, 8.0)  # elsewhere now
    host.process()
    clickRow(host, panel.ui.lesionTable, 0)
    suggest(host, panel)
    assert len(planned(panel)) == 2
    expected = suggestion(panel)
    assert planned(panel)[1].diameter == expected.stent.diameter
    assert panel.ui.stentTable.currentRow() == 1


def test_a_suggested_stent_is_dragged_to_another_diameter(host, aLesion):
    """The balloon follows, by the recoil of the rule: the lumen is what was asked for."""
    panel, lesion = aLesion
    ui, parameters = panel.ui, panel._parameterNode
    suggest(host, panel)
    assert ui.diameterSlider.enabled
    narrowest = lesion.minimum_diameter
    for lumen, recoil in ((6.0, 0.07), (round(3.2 * narrowest, 2), 0.10), (7.0, 0.07)):
        ui.diameterSlider.value = lumen
        host.processUntil(lambda: not panel.recoil.isBusy)
        (stent,) = planned(panel)
        assert (ui.diameterSlider.value, stent.balloon.recoil_fraction) == (lumen, recoil)
        assert stent.diameter == pytest.approx(lumen)
        assert stent.balloon.diameter == pytest.approx(lumen / (1 - recoil))
        assert ui.balloonSlider.value == pytest.approx(stent.balloon.diameter, abs=0.01)
    deploy(host, panel)
    (treated,) = panel.logic.lastRun(parameters).result.stents
    assert treated.after.minimum == pytest.approx(7.0, rel=0.02)
    ui.balloonSlider.value = 8.0  # now the lumen follows
    host.processUntil(lambda: not panel.recoil.isBusy)
    assert planned(panel)[0].balloon.diameter == 8.0
    assert ui.diameterSlider.value == pytest.approx(8.0 * 0.93)


def test_ratios_are_shown_while_sizes_change(host, aLesion):
    panel, lesion = aLesion
    ui = panel.ui
    suggest(host, panel)
    ui.deviceCollapsibleButton.collapsed = False
    healthy = smallerSide(lesion)
    for balloon in (7.0, 9.0, 14.0):
        ui.balloonSlider.value = balloon
        lumen = panel._parameterNode.stent.diameter
        assert f"Stent : healthy vessel {lumen / healthy:.2f} where that is narrowest" in (
            ui.deviceLabel.text
        )
        share = balloon / lesion.minimum_diameter
        assert f"Balloon : stenosis {share:.2f}; above 3.0" in ui.deviceLabel.text
        isWide = lumen / healthy > 1.2
        assert ("times as wide as the healthy vessel" in ui.deviceLabel.text) == isWide
        assert ("times as wide as the stenosis" in ui.deviceLabel.text) == (share > 3)
        assert f"reference {lesion.reference_diameter:.2f} mm" in ui.deviceLabel.text
    host.processUntil(lambda: not panel.recoil.isBusy)
    place = panel.logic.centerlineOf(panel._parameterNode)
    root = place.points[place.roots[0]]
    panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *root)
    assert "Stent : healthy" not in ui.deviceLabel.text


def test_a_lesion_of_another_vessel_is_refused(aLogic, theParameters):
    from dataclasses import replace

    search = aLogic.lesionSearch(theParameters)
    for _part in search.portions():
        pass
    with pytest.raises(ValueError, match="lesion: expected one that was found in this vessel"):
        aLogic.suggestStent(theParameters, replace(search.found[0]))
    assert theParameters.status == ""


def test_a_suggestion_goes_by_the_ratio_and_the_margin_that_are_set(host, aLesion, tmp_path):
    """In the words of the library; kept by copies of the plan, and set back with the method."""
    from SDFStentLib.report import proposal_sentence
    from SDFStentLib.treatment import SizingWishes

    panel, _lesion = aLesion
    ui, parameters = panel.ui, panel._parameterNode
    usual = SizingWishes()
    boxes = (ui.suggestRatioSpinBox, ui.suggestMarginSpinBox)
    assert [box.value for box in boxes] == [usual.ratio, usual.margin]
    ui.suggestRatioSpinBox.value, ui.suggestMarginSpinBox.value = 0.9, 2.0
    suggest(host, panel)
    expected = suggestion(panel, ratio=0.9, margin=2.0)
    (stent,) = planned(panel)
    assert (stent.diameter, stent.length) == (expected.stent.diameter, expected.stent.length)
    assert ui.statusLabel.text.splitlines()[0] == proposal_sentence(expected)
    copy = panel.logic.duplicatePlan(parameters)
    assert (copy.suggestRatio, copy.suggestMargin) == (0.9, 2.0)
    ui.suggestMarginSpinBox.value = 3.0
    suggest(host, panel)  # sizes the stent that is there
    (stent,) = planned(panel)
    assert stent.length == suggestion(panel, ratio=0.9, margin=3.0).stent.length
    host.click(ui.defaultsButton)
    assert [box.value for box in boxes] == [usual.ratio, usual.margin]


def test_a_suggestion_says_at_once_that_it_is_made_and_then_stays(host, aLesion, monkeypatch):
    from SDFStentSlicer import Clock

    panel, _lesion = aLesion
    ui = panel.ui
    ui.autoUpdateCheckBox.checked = True
    settle(host, panel)
    monkeypatch.setattr(Clock.QtTimer, "TURN_S", (0.0, 0.0))
    ui.suggestButton.click()
    assert "Sizing a stent" in ui.statusLabel.text
    ui.suggestButton.click()  # once more changes nothing
    host.processUntil(lambda: not panel._suggesting.isRunning)
    count = len(panel._parameterNode.stents)
    told = ui.statusLabel.text
    assert "Sizing" not in told
    assert f"{panel._parameterNode.stent.diameter:.2f}" in told
    settle(host, panel)  # live: it is deployed
    host.process(0.6)
    assert panel._parameterNode.certificateSummary
    assert ui.statusLabel.text == told
    assert len(panel._parameterNode.stents) == count
    ui.diameterSlider.value = panel._parameterNode.stent.diameter + 1.0
    settle(host, panel)
    assert told not in ui.statusLabel.text


def test_a_suggestion_ends_with_its_plan(host, aLesion, aStepAtATime):
    panel, _lesion = aLesion
    count = len(panel._parameterNode.stents)
    panel.ui.suggestButton.click()
    panel._switchTo(panel.logic.duplicatePlan(panel._parameterNode))
    settle(host, panel)
    assert len(panel._parameterNode.stents) == count
    assert "Sizing" not in panel.ui.statusLabel.text
