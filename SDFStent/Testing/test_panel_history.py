"""Undo and Redo of what is done to a plan, whatever it was."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle


def stateOf(panel):
    """What a user sees of the plan: stents with their sizes and places, and the method."""
    parameters = panel._parameterNode
    stents = []
    for stent in parameters.stents:
        handle = stent.handle
        count = 0 if handle is None else handle.GetNumberOfControlPoints()
        points = [tuple(handle.GetNthControlPointPositionWorld(n)) for n in range(count)]
        length = 0.0 if stent.placement.usesHandleLength else stent.length
        sizes = (stent.diameter, length, stent.foreshortening, stent.redilation)
        stents.append((stent.label, stent.enabled, stent.placement, sizes, points))
    return stents, parameters.method.tissueGap, parameters.flowMean


def isSame(one, other):
    (stents, *rest), (others, *left) = one, other
    close = np.allclose(rest, left, rtol=0, atol=1e-9) and len(stents) == len(others)
    return close and all(
        a[:3] == b[:3]
        and np.allclose(a[3], b[3], rtol=0, atol=1e-9)
        and np.shape(a[4]) == np.shape(b[4])
        and np.allclose(a[4], b[4], rtol=0, atol=1e-9)
        for a, b in zip(stents, others, strict=True)
    )


def rest(host, panel):
    """Wait until the panel has kept the plan."""
    buttons = panel.sections[0]
    host.processUntil(lambda: not buttons._timer.isActive())


def change(host, panel, random):
    """Something that a hand does."""
    ui, parameters = panel.ui, panel._parameterNode
    kind = random.choice(["add", "copy", "remove", "size", "move", "place", "method", "order"])
    if kind == "add" or not len(parameters.stents):
        host.click(ui.addStentButton)
    elif kind in ("copy", "remove"):
        host.click(ui.copyStentButton if kind == "copy" else ui.removeStentButton)
    elif kind == "size":
        ui.diameterSlider.value = round(random.uniform(3, 12), 2)
        ui.lengthSlider.value = round(random.uniform(8, 30), 2)
    elif kind == "move":
        panel._moveStent(random.uniform(-9, 9))
    elif kind == "place":
        host.choose(ui.placementComboBox, int(random.integers(0, 4)))
    elif kind == "method":
        ui.tissueGapSlider.value = round(random.uniform(0.1, 2.0), 2)
        ui.flowMeanSpinBox.value = round(random.uniform(1.0, 5.0), 1)
    elif ui.moveUpButton.enabled:
        host.click(ui.moveUpButton)
    host.process()


def test_whatever_was_done_is_taken_back_and_done_again(host, theInputs):
    random, ui, seen = np.random.default_rng(5), theInputs.ui, []
    rest(host, theInputs)
    assert not ui.undoButton.enabled
    for _turn in range(12):
        if not seen or not isSame(seen[-1], stateOf(theInputs)):
            seen.append(stateOf(theInputs))
        change(host, theInputs, random)
        rest(host, theInputs)
    if not isSame(seen[-1], stateOf(theInputs)):
        seen.append(stateOf(theInputs))
    assert len(seen) > 6
    for button, states in ((ui.undoButton, seen[-2::-1]), (ui.redoButton, seen[1:])):
        for state in states:
            host.click(button)
            assert isSame(stateOf(theInputs), state)
            rest(host, theInputs)
        assert not button.enabled
    handles = slicer.util.getNodesByClass("vtkMRMLMarkupsFiducialNode")
    kept = {stent.handle.GetID() for stent in theInputs._parameterNode.stents}
    assert {one.GetID() for one in handles if not one.GetHideFromEditors()} == kept


def test_a_drag_is_one_step_and_the_handle_stays_the_users(host, aStent):
    parameters, ui = aStent._parameterNode, aStent.ui
    rest(host, aStent)
    handle, first = parameters.stent.handle, stateOf(aStent)
    for diameter in np.linspace(6, 8, 9):
        ui.diameterSlider.value = diameter
        aStent._moveStent(0.5)
        host.process()
    rest(host, aStent)
    host.click(ui.undoButton)
    assert isSame(stateOf(aStent), first)
    assert parameters.stent.handle is handle
    ui.lengthSlider.value = 11.0
    rest(host, aStent)
    assert not ui.redoButton.enabled  # it goes on from here
    host.click(ui.undoButton)
    assert isSame(stateOf(aStent), first)


@pytest.mark.bench
def test_a_stent_that_was_moved_goes_back_with_the_recoil_that_the_rule_found_late(host, aStent):
    """As where the application draws slowly: the rule's answer is a consequence of the move, not a step."""
    from SDFStentSlicer import Clock

    parameters, ui, recoil = aStent._parameterNode, aStent.ui, aStent.recoil
    ui.diameterSlider.value = 12.0
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 13.0
    host.processUntil(lambda: not recoil.isBusy)
    rest(host, aStent)
    first, text = stateOf(aStent), aStent.sections[0]._history.document
    recoil._timer = Clock.timer(recoil._begin, 1000)
    tree = aStent.logic.centerlineOf(parameters)
    wide = tree.path_from_proximal(tree.points[tree.roots[0]], 12.0).points[-1]
    parameters.stent.handle.SetNthControlPointPositionWorld(0, *wide)
    host.process()
    host.processUntil(lambda: not recoil.isBusy)
    rest(host, aStent)
    assert aStent.sections[0]._history.document != text
    host.click(ui.undoButton)
    assert isSame(stateOf(aStent), first)


def test_a_lumen_that_was_set_last_stays_so(host, aStent):
    """Where the rule finds another recoil the balloon follows, not the lumen that is prescribed."""
    parameters, ui, recoil = aStent._parameterNode, aStent.ui, aStent.recoil
    ui.balloonCheckBox.checked = True
    ui.balloonSlider.value = 13.0
    host.processUntil(lambda: not recoil.isBusy)
    for slider, value in ((ui.diameterSlider, 9.0), (ui.lengthSlider, 11.0)):
        slider.value = value
        host.processUntil(lambda: not recoil.isBusy)
        rest(host, aStent)
    for button in (ui.undoButton, ui.redoButton, ui.undoButton):
        host.click(button)
        host.processUntil(lambda: not recoil.isBusy)
        assert parameters.stent.draft.is_lumen_set
        assert ui.diameterSlider.value == 9.0
    host.click(ui.undoButton)
    assert not parameters.stent.draft.is_lumen_set


def test_what_a_deployment_finds_of_the_flow_is_no_step(host, aStent):
    """It takes away the place of the right branch when it begins, and finds it again in the end."""
    ui, parameters = aStent.ui, aStent._parameterNode
    ui.flowMeanSpinBox.value = 2.5
    rest(host, aStent)
    first = stateOf(aStent)
    ui.diameterSlider.value = 7.0
    rest(host, aStent)
    deploy(host, aStent)
    rest(host, aStent)
    assert parameters.rightBranch
    host.click(ui.undoButton)
    assert isSame(stateOf(aStent), first)


def test_buttons_that_are_clicked_at_once_are_steps_of_their_own(host, theInputs):
    ui, parameters = theInputs.ui, theInputs._parameterNode
    counts = []
    for button in (ui.addStentButton, ui.copyStentButton, ui.removeStentButton, ui.addStentButton):
        host.click(button)
        counts.append(len(parameters.stents))
    for count in (*counts[-2::-1], 0):
        host.click(ui.undoButton)
        assert len(parameters.stents) == count


def test_every_plan_has_changes_of_its_own_and_another_vessel_none(host, aStent):
    ui = aStent.ui
    rest(host, aStent)
    host.click(ui.duplicatePlanButton)
    rest(host, aStent)
    assert not ui.undoButton.enabled
    ui.diameterSlider.value = 5.0
    rest(host, aStent)
    aStent._switchTo(aStent.logic.alternatives(aStent._parameterNode)[0])
    host.process()
    host.click(ui.undoButton)
    assert stateOf(aStent)[0] == []  # the one stent was added
    aStent._switchTo(aStent.logic.alternatives(aStent._parameterNode)[1])
    host.click(ui.undoButton)
    assert aStent._parameterNode.stent.diameter == 8.5
    ui.centerlineSelector.setCurrentNode(None)
    rest(host, aStent)
    assert not ui.undoButton.enabled
    assert not ui.redoButton.enabled


@pytest.mark.parametrize("which", ["vessel", "centerline"])
@pytest.mark.parametrize("isChangedThere", [False, True])
def test_what_was_done_in_a_vessel_can_be_taken_back_after_a_look_at_another(
    host, aStent, which, isChangedThere
):
    from SDFStentSlicer.SampleVessels import addSampleVessel

    ui, parameters = aStent.ui, aStent._parameterNode
    rest(host, aStent)
    for diameter in (6.0, 7.0):
        ui.diameterSlider.value = diameter
        rest(host, aStent)
    former = getattr(parameters, which)
    other = addSampleVessel("branching_pulmonary_artery", "Other")[which == "centerline"]
    getattr(ui, f"{which}Selector").setCurrentNode(other)
    rest(host, aStent)
    assert not ui.undoButton.enabled  # nothing was done there
    if isChangedThere:
        ui.diameterSlider.value = 9.0
        rest(host, aStent)
    getattr(ui, f"{which}Selector").setCurrentNode(former)
    rest(host, aStent)
    back = [7.0, 6.0, 8.5] if isChangedThere else [6.0, 8.5]
    for diameter in back:
        host.click(ui.undoButton)
        assert parameters.stent.diameter == diameter
    for diameter in [*reversed(back[:-1]), 9.0 if isChangedThere else 7.0]:
        host.click(ui.redoButton)
        assert parameters.stent.diameter == diameter
    assert not ui.redoButton.enabled


def test_the_vessel_is_seen_before_and_after_the_stents_by_one_button(host, aStent):
    ui, parameters = aStent.ui, aStent._parameterNode
    assert not ui.beforeButton.enabled
    deploy(host, aStent)
    told, last = ui.lumenLabel.text, parameters.atHand.split("\n")[-1]
    for words, expansion, seen in (("After", 0, "seen before the stents"), ("Before", 100, last)):
        host.click(ui.beforeButton)
        assert (ui.beforeButton.text, parameters.expansion) == (words, expansion)
        assert aStent._state.atHand.text.split("\n")[-1] == seen
    assert ui.lumenLabel.text == told
    ui.autoUpdateCheckBox.checked = True
    host.click(ui.beforeButton)
    ui.diameterSlider.value = 8.0
    settle(host, aStent)
    assert ui.beforeButton.text == "Before"  # something new is shown


def test_zoom_goes_to_the_selected_stent(host, aStent, aScene):
    camera = aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    host.choose(aStent.ui.placementComboBox, 3)  # two points
    host.click(aStent.ui.zoomButton)
    handle = aStent._parameterNode.stent.handle
    ends = np.array([handle.GetNthControlPointPositionWorld(n) for n in (0, 1)])
    np.testing.assert_allclose(camera.GetFocalPoint(), ends.mean(axis=0), atol=1e-6)
    away = np.linalg.norm(np.subtract(camera.GetPosition(), camera.GetFocalPoint()))
    height = 2 * away * np.tan(np.radians(camera.GetViewAngle() / 2))
    assert height > 2 * np.linalg.norm(ends[1] - ends[0])


def test_a_point_that_was_deleted_in_a_view_comes_back_where_it_was(host, aStent):
    ui, handle = aStent.ui, aStent._parameterNode.stent.handle
    for _time in range(2):
        aStent._moveStent(2.0)
        rest(host, aStent)
    before = stateOf(aStent)
    handle.RemoveNthControlPoint(0)
    rest(host, aStent)
    host.click(ui.undoButton)
    assert isSame(stateOf(aStent), before)
