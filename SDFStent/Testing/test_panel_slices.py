"""The slice views show the vessel's wall at any moment, before or after."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, pointsOf, settle, theThroat


def outlined(vessel):
    """Models of the vessel's mesh that the slice views cut."""
    count = vessel.GetPolyData().GetNumberOfPoints()
    return [
        node
        for node in slicer.util.getNodesByClass("vtkMRMLModelNode")
        if node.GetPolyData() is not None
        and node.GetPolyData().GetNumberOfPoints() == count
        and node.GetDisplayNode() is not None
        and node.GetDisplayNode().GetVisibility()
        and node.GetDisplayNode().GetVisibility2D()
    ]


def addFile(vessel):
    """The same wall as a model that comes from a file: its outline is not shown."""
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode", "From a file")
    node.SetAndObservePolyData(vessel.GetPolyData())
    node.CreateDefaultDisplayNodes()
    assert not node.GetDisplayNode().GetVisibility2D()
    vessel.GetDisplayNode().SetVisibility(False)
    return node


@pytest.fixture
def watched(host, aStent):
    """The panel, and after each turn of the event loop how many outlines there are."""
    vessel = addFile(aStent._parameterNode.vessel)
    aStent.ui.vesselSelector.setCurrentNode(vessel)
    settle(host, aStent)
    counts, views = [], slicer.app.applicationLogic()
    # As a frame could be drawn: whenever nothing keeps the views from it.
    tag = views.AddObserver(
        views.ResumeRenderEvent, lambda *_: counts.append(len(outlined(vessel)))
    )
    yield aStent, vessel, counts
    views.RemoveObserver(tag)


def drag(host, panel):
    for x in (0.5, 1.0, 1.5):
        panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(
            0, *np.add(theThroat(), [0, 0, x])
        )
        host.process(0.05)


def slide(host, panel):
    for diameter in (7.0, 7.5, 8.0):
        panel.ui.diameterSlider.value = diameter
        host.process(0.05)


@pytest.mark.parametrize("isLive", [True, False])
@pytest.mark.parametrize("change", [drag, slide, None])
def test_one_outline_is_seen_whatever_changes(host, watched, change, isLive):
    panel, vessel, counts = watched
    assert outlined(vessel) == [vessel]
    panel.ui.autoUpdateCheckBox.checked = isLive
    if change is not None:
        change(host, panel)
    deploy(host, panel)
    assert counts
    assert set(counts) == {1}
    output = panel._parameterNode.outputVessel
    assert outlined(vessel) == [output]
    assert np.abs(pointsOf(output) - pointsOf(vessel)).max() > 0.5
    panel.ui.cancelButton.click()
    assert outlined(vessel) == [output]


def test_who_has_hidden_the_outline_is_shown_none(host, watched):
    panel, _vessel, counts = watched
    deploy(host, panel)
    panel._parameterNode.outputVessel.GetDisplayNode().SetVisibility2D(False)
    counts.clear()
    panel.ui.autoUpdateCheckBox.checked = True
    slide(host, panel)
    settle(host, panel)
    assert set(counts) == {0}
    names = [node.GetName() for node in slicer.util.getNodesByClass("vtkMRMLModelNode")]
    assert "Vessel before treatment" not in names
