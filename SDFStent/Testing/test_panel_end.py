"""The application may be quit at any moment: nothing that the panel had still to do comes afterward."""

import pytest
from panel_helpers import theThroat
from PySide6 import QtCore
from sdfstent_host.event_loop import QTimer


def addOne(panel):
    panel.ui.addStentButton.click()


def resize(panel):
    addOne(panel)
    panel.ui.diameterSlider.value = 7.0


def followABalloon(panel):
    addOne(panel)
    panel.ui.balloonCheckBox.checked = True
    panel.ui.balloonSlider.value = 7.5


def deploy(panel):
    resize(panel)
    panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    panel.ui.deployButton.click()


def place(panel):
    panel.ui.centerlineSelector.setCurrentNode(None)
    addOne(panel)
    panel.ui.placeWidget.placeModeEnabled = True


def addAModel(_panel):
    import slicer

    slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode")


def changePlacement(panel):
    addOne(panel)
    panel.ui.placementComboBox.activated.emit(1)


DONE = [addOne, resize, followABalloon, deploy, place, addAModel, changePlacement]


@pytest.mark.parametrize("isLive", [False, True])
@pytest.mark.parametrize("done", DONE, ids=lambda one: one.__name__)
def test_nothing_is_to_come_once_the_panel_is_closed(
    host, aScene, theModule, aVessel, done, isLive
):
    panel = host.openPanel(theModule)
    panel.ui.autoUpdateCheckBox.checked = isLive
    panel.ui.vesselSelector.setCurrentNode(aVessel[0])
    panel.ui.centerlineSelector.setCurrentNode(aVessel[1])
    before = {timer for timer in QTimer.known if QtCore.QTimer.isActive(timer)}
    done(panel)
    assert {timer for timer in QTimer.known if QtCore.QTimer.isActive(timer)} - before or isLive
    host.closePanel(panel)
    assert not [timer for timer in QTimer.known if QtCore.QTimer.isActive(timer)]
    host.process(0.5)  # as long as the slowest of them would have waited
    assert host.errors() == []
