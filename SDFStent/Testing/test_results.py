"""What the panel shows of a deployment: whether it still holds, and of which stent."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, settle, theThroat

CHANGED = "Changed since this deployment"


def isMarked(panel):
    """Whether the panel says that its results are old, above them and below Deploy; they stay as legible as others."""
    ui = panel.ui
    assert all(one.enabled for one in (ui.lumenLabel, ui.certificateLabel, ui.warningLabel))
    assert (CHANGED in ui.statusLabel.text and ui.statusLabel.visible) == ui.oldLabel.visible
    assert ui.oldLabel.text == "Before the last change of the plan:"
    return ui.oldLabel.visible


def test_results_are_marked_while_the_plan_is_another_one(host, aStent):
    assert not isMarked(aStent)
    deploy(host, aStent)
    assert not isMarked(aStent)
    aStent.ui.diameterSlider.value = 7.0
    assert isMarked(aStent)
    assert "prescribed 8.5 mm" in aStent.ui.lumenLabel.text
    aStent.ui.diameterSlider.value = 8.5  # as deployed
    assert not isMarked(aStent)
    aStent.ui.diameterSlider.value = 7.0
    deploy(host, aStent)
    assert not isMarked(aStent)
    assert "prescribed 7 mm" in aStent.ui.lumenLabel.text


def test_auto_update_marks_nothing_that_it_is_about_to_renew(host, aStent):
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    aStent.ui.diameterSlider.value = 7.0
    assert not isMarked(aStent)
    settle(host, aStent)
    assert not isMarked(aStent)
    line = aStent._parameterNode.outputChart.GetNthPlotSeriesNode(0)
    assert line.GetOpacity() == 1.0
    aStent._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, 500, 500, 500)
    settle(host, aStent)  # ends with an error: what is shown is the vessel before treatment
    assert "expected a point within" in aStent.ui.statusLabel.text
    assert "before treatment" in aStent.ui.lumenLabel.text
    assert line.GetOpacity() < 0.5  # of the stent before
    assert not isMarked(aStent)


@pytest.fixture
def twoStents(host, aStent):
    """The panel with two deployed stents of the same name, 8.5 and 7 mm wide, the second selected."""
    host.click(aStent.ui.copyStentButton)
    tree = aStent.logic.centerlineOf(aStent._parameterNode)
    far = tree.path_around(theThroat(), 28.0).points[-1]
    aStent._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *far)
    aStent.ui.diameterSlider.value = 7.0
    aStent.ui.nameEdit.text = "Stent 1"
    deploy(host, aStent)
    return aStent


def shownDiameter(panel):
    """The prescribed diameter in the table that the plot draws."""
    table = panel._parameterNode.outputTable
    prescribed = slicer.util.arrayFromTableColumn(table, "Prescribed (mm)")
    return float(np.unique(prescribed[np.isfinite(prescribed)]).item())


def test_plot_and_table_follow_a_stent_that_is_moved_in_the_list(host, twoStents):
    host.click(twoStents.ui.moveUpButton)
    assert twoStents._parameterNode.selected == 0
    assert shownDiameter(twoStents) == 7.0
    twoStents.ui.stentTable.selectRow(1)
    assert shownDiameter(twoStents) == 8.5


def test_the_panel_says_that_it_is_for_research_only(aPanel):
    line = aPanel.ui.researchLabel
    assert line.text == "Research use only, not a medical device."
    assert line.visible


def test_a_result_is_told_by_tiles_with_warnings_first(host, aStent):
    from SDFStentSlicer.Tiles import tilesOf

    parameters, ui = aStent._parameterNode, aStent.ui
    host.processUntil(lambda: not aStent.lesions.isBusy)
    assert not ui.tilesLabel.visible
    deploy(host, aStent)
    run = aStent.logic.lastRun(parameters)
    (stent,) = run.result.stents
    tiles = {one.name: one for one in tilesOf(parameters)}
    assert tiles["Narrowest lumen"].value == f"{stent.after.minimum:.1f} mm"
    assert tiles["Narrowest lumen"].beneath.startswith(f"before {stent.before.minimum:.1f}")
    assert tiles["Surface"].value == "certified for meshing"
    assert ui.tilesLabel.visible
    assert all(one.value in ui.tilesLabel.text for one in tiles.values())
    assert ui.detailsCollapsibleButton.collapsed  # sentences are a click away
    ui.diameterSlider.value = 2.0  # narrower than the vessel: nothing moves
    deploy(host, aStent)
    first, *others = tilesOf(parameters)
    assert (first.name, first.is_caution) == ("Warnings", True)
    assert "without effect" in first.beneath
    assert not any(one.is_caution for one in others)


def test_there_is_room_between_words_of_tiles_side_by_side(aLogic):
    from PySide6 import QtGui
    from SDFStentSlicer.Tiles import html

    from SDFStentLib.report import Tile

    document, gaps = QtGui.QTextDocument(), []
    for count in range(8, 40):
        beneath = "healthy " * (count // 8) + "m" * (count % 8)
        document.setHtml(html([Tile("Lumen", "6.8 mm", beneath, False)] * 6))
        document.setTextWidth(453.0)  # in a window of 1280 pixels
        table = document.rootFrame().childFrames()[0]
        for row in range(2):
            cells = [extentOf(document, table.cellAt(row, column)) for column in range(3)]
            gaps += [cells[number + 1][0] - cells[number][1] for number in range(2)]
    assert len(gaps) == 32 * 4
    assert min(gaps) >= 8.0


def extentOf(document, cell):
    """Where the words of a table's cell begin and end, pixels."""
    lines, block = [], cell.firstCursorPosition().block()
    left = document.documentLayout().blockBoundingRect(block).left()
    for number in range(block.layout().lineCount()):
        words = block.layout().lineAt(number).naturalTextRect()
        lines.append((left + words.left(), left + words.right()))
    return min(one for one, _ in lines), max(one for _, one in lines)
