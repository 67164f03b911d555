"""A stent has one number, that of the table, whoever tells of it and whatever is switched off."""

import itertools
import re

import numpy as np
import pytest
from panel_helpers import deploy, settle


def numbersIn(*texts):
    """Numbers of stents that some texts name."""
    found = re.findall(r"[Ss]tents? (\d+)(?:,? and (\d+))?", "\n".join(texts))
    return {int(number) for pair in found for number in pair if number}


@pytest.fixture
def threeStents(host, aStent):
    """Three overlapping stents, each of which narrows something or is overlapped."""
    for _time in range(2):
        host.click(aStent.ui.copyStentButton)
    place = aStent._parameterNode.stents[0].handle.GetNthControlPointPositionWorld(0)
    for stent, offset in zip(aStent._parameterNode.stents, (-3.0, 0.0, 3.0), strict=True):
        stent.handle.SetNthControlPointPositionWorld(0, *np.add(place, [0, 0, offset]))
    return aStent


OFF = [set(one) for count in (0, 1) for one in itertools.combinations((1, 2, 3), count)]


@pytest.mark.parametrize("off", OFF, ids=str)
def test_warnings_name_the_rows_that_are_on(host, threeStents, off):
    parameters = threeStents._parameterNode
    for number in off:
        threeStents._onEnableStent(number - 1, False)
    deploy(host, threeStents)
    warnings = parameters.warningSummary
    assert "overlap" in warnings
    assert "switched off" not in warnings
    assert numbersIn(warnings) == {1, 2, 3} - off
    assert "(Stent" not in warnings
    run = threeStents.logic.lastRun(parameters)
    assert {one.number for one in run.result.stents} == {1, 2, 3} - off
    covering = {number for lesion in run.lesions for number in lesion.stents}
    assert covering <= {1, 2, 3} - off
    for row in range(3):
        threeStents.ui.stentTable.selectRow(row)
        if row + 1 not in off:
            shown = run.result.stents[run.shownStent]
            assert shown.number == row + 1


def test_the_shell_says_the_same_numbers_of_the_saved_plan(host, threeStents, tmp_path):
    from SDFStentLib.plan import load_plan

    threeStents._onEnableStent(0, False)
    deploy(host, threeStents)
    threeStents.logic.savePlan(tmp_path / "plan.json", threeStents._parameterNode)
    stents = load_plan(tmp_path / "plan.json").stents
    assert [one.enabled for one in stents] == [False, True, True]
    run = threeStents.logic.lastRun(threeStents._parameterNode)
    for one in run.result.stents:
        assert stents[one.number - 1].name == one.stent.name


@pytest.mark.parametrize("isRedilated", [False, True])
def test_a_stent_that_is_off_and_nowhere_is_counted(host, aStent, isRedilated):
    parameters = aStent._parameterNode
    host.click(aStent.ui.copyStentButton)
    host.click(aStent.ui.moveUpButton)  # the second one above the first
    if isRedilated:
        aStent.ui.redilationSpinBox.value = 9.5
    parameters.stent.handle.RemoveAllControlPoints()
    aStent._onEnableStent(0, False)
    deploy(host, aStent)
    (treated,) = aStent.logic.lastRun(parameters).result.stents
    assert treated.number == (3 if isRedilated else 2)
    assert treated.stent.name == "Stent 1"
    assert parameters.certificateSummary


def test_one_that_is_off_and_dilates_nothing_again_stops_nobody(host, aStent):
    host.click(aStent.ui.copyStentButton)
    host.choose(aStent.ui.placementComboBox, 5)  # dilates the first one again
    host.click(aStent.ui.moveUpButton)
    aStent._onEnableStent(0, False)
    aStent.ui.autoUpdateCheckBox.checked = True
    deploy(host, aStent)
    settle(host, aStent)
    assert aStent._parameterNode.certificateSummary
    assert [one.number for one in aStent.logic.lastRun(aStent._parameterNode).result.stents] == [2]
