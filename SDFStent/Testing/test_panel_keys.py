"""The panel by keyboard alone."""

import pytest
from panel_helpers import settle
from PySide6 import QtCore, QtTest, QtWidgets


def focused():
    return QtWidgets.QApplication.focusWidget()


def press(host, key):
    QtTest.QTest.keyClick(focused(), key)
    host.process()


@pytest.fixture
def theTables(host, aStent):
    """The panel with rows in every table, in the window that has the keyboard."""
    settle(host, aStent)
    for name in ("stents", "plans", "inputs"):
        getattr(aStent.ui, f"{name}CollapsibleButton").collapsed = False
    host.click(aStent.ui.copyStentButton)
    host.click(aStent.ui.duplicatePlanButton)
    settle(host, aStent)
    aStent.parent.activateWindow()
    host.process()
    return aStent


@pytest.mark.parametrize("name", ["lesionTable", "stentTable", "planTable"])
@pytest.mark.parametrize("key", [QtCore.Qt.Key_Tab, QtCore.Qt.Key_Backtab])
def test_tab_goes_on_from_a_table_and_changes_nothing(host, theTables, aScene, name, key):
    table = getattr(theTables.ui, name)
    table.setFocus()
    host.process()
    assert focused() is table
    camera = aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    before = camera.GetFocalPoint(), theTables._parameterNode, table.currentRow()
    press(host, key)
    assert focused() is not table
    assert (camera.GetFocalPoint(), theTables._parameterNode, table.currentRow()) == before


def test_tab_comes_round_through_all_that_can_be_set(host, theTables):
    start, seen = theTables.ui.lesionTable, []
    start.setFocus()
    # Ends: with the first one that is seen again.
    while focused() not in seen:
        seen.append(focused())
        press(host, QtCore.Qt.Key_Tab)
    assert focused() is start
    assert {theTables.ui.stentTable, theTables.ui.planTable, theTables.ui.deployButton} <= set(seen)


def test_enter_chooses_a_lesion_and_goes_there_again(host, theTables, aScene):
    table = theTables.ui.lesionTable
    table.setFocus()
    camera = aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    press(host, QtCore.Qt.Key_Return)
    lesion = theTables.lesions.selected
    assert lesion is not None
    assert camera.GetFocalPoint() == pytest.approx(tuple(lesion.point), abs=1e-3)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    press(host, QtCore.Qt.Key_Return)
    assert camera.GetFocalPoint() == pytest.approx(tuple(lesion.point), abs=1e-3)
