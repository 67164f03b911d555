"""The way to SlicerVMTK's Extract Centerline: its names are those of its source (module, selectors, June 2026)."""

from types import SimpleNamespace

import pytest
import slicer
from test_scenes import addSegmentation


@pytest.fixture
def theirModule(host, aScene):
    """A module that is called and has selectors as theirs; gone again afterward."""
    selector = slicer.qMRMLNodeComboBox()
    selector.nodeTypes = ["vtkMRMLModelNode", "vtkMRMLSegmentationNode"]
    selector.setMRMLScene(slicer.mrmlScene)
    segments = slicer.qMRMLSegmentSelectorWidget()
    segments.setMRMLScene(slicer.mrmlScene)
    selector.connect(
        "currentNodeChanged(vtkMRMLNode*)",
        lambda node: segments.setCurrentNode(
            node if node is not None and node.IsA("vtkMRMLSegmentationNode") else None
        ),
    )
    ui = SimpleNamespace(inputSurfaceSelector=selector, inputSegmentSelectorWidget=segments)
    module = SimpleNamespace(name="ExtractCenterline", widget=SimpleNamespace(ui=ui))
    slicer.modules.extractcenterline = module
    slicer.util.selectedModules.clear()
    yield ui
    del slicer.modules.extractcenterline


def test_the_module_is_opened_with_the_vessel_chosen(host, aPanel, aVessel, theirModule):
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.extractButton)
    assert slicer.util.selectedModules == ["ExtractCenterline"]
    assert theirModule.inputSurfaceSelector.currentNode() is aVessel[0]


def test_the_chosen_segment_is_chosen_there_too(host, aPanel, aScene, theirModule):
    node = addSegmentation(aScene, "A", 3)
    aPanel.ui.vesselSelector.setCurrentNode(node)
    aPanel.ui.segmentSelector.setCurrentSegmentID("A1")
    host.click(aPanel.ui.extractButton)
    assert theirModule.inputSurfaceSelector.currentNode() is node
    assert theirModule.inputSegmentSelectorWidget.currentSegmentID() == "A1"


def test_where_it_is_missing_the_panel_says_how_to_install_it(host, aPanel, aVessel):
    slicer.util.selectedModules.clear()
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    aPanel.ui.centerlineSelector.setCurrentNode(aVessel[1])
    host.click(aPanel.ui.addStentButton)
    host.click(aPanel.ui.extractButton)
    said = aPanel.ui.statusLabel.text
    assert "extension SlicerVMTK, which is not installed" in said
    assert "View / Extensions Manager" in said
    assert slicer.util.selectedModules == []


def test_a_vessel_under_a_transform_is_refused(host, aPanel, aVessel, aScene, theirModule):
    host.process()  # what was loaded is chosen
    matrix = aScene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    aVessel[0].SetAndObserveTransformNodeID(matrix.GetID())
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.extractButton)
    assert "expected one under no transform" in aPanel.ui.statusLabel.text
    assert slicer.util.selectedModules == []
