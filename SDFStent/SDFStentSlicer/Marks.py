"""Marks: nodes to look at, which nobody chooses or saves. Markups are seen through what lies before them."""

import slicer

from . import Display, Showing
from .Handles import removeWhole

TUBE_COLOR = (0.15, 0.65, 0.5)
"""Neither that of lines and handles nor that of lesions."""


def createMark(className, name, points, texts=None):
    """Markups node with a control point per row of `points`, which is in nobody's way.

    `texts` stand beside the points; then one without a text is not seen.
    """
    node = newNode(className, name)
    for number, point in enumerate(points):
        node.AddControlPointWorld(point, texts[number] if texts else "")
        node.SetNthControlPointVisibility(number, not texts or bool(texts[number]))
    selection = slicer.app.applicationLogic().GetSelectionNode()
    placed, className = selection.GetActivePlaceNodeID(), selection.GetActivePlaceNodeClassName()
    with slicer.util.NodeModify(selection):  # else it would be the one to which clicks add points
        slicer.mrmlScene.AddNode(node)
        selection.SetReferenceActivePlaceNodeClassName(className)
        selection.SetActivePlaceNodeID(placed)
    display = _newDisplay(node)
    display.SetPropertiesLabelVisibility(False)
    display.SetPointLabelsVisibility(texts is not None)
    display.SetOccludedVisibility(True)
    display.SetOccludedOpacity(1.0)
    return node


def createTube(name):
    """A model node for the tube that a stent will be."""
    node = slicer.mrmlScene.AddNode(newNode("vtkMRMLModelNode", name))
    display = _newDisplay(node)
    display.SetVisibility2D(True)
    display.SetColor(*TUBE_COLOR)
    return node


def createOutline(name, polyData):
    """Model node in the slice views only; the polydata stays the caller's, and is not changed."""
    node, display = _createSurface(name, polyData, Showing.VESSEL_COLOR)
    display.SetVisibility3D(False)
    display.SetVisibility2D(True)
    return node


def createWall(name, polyData, color):
    """Model node in the 3D views only, that can be seen through; the polydata stays the caller's, and is not changed."""
    node, display = _createSurface(name, polyData, color)
    display.SetVisibility2D(False)
    display.SetScalarVisibility(False)
    Showing.seeThrough(display)
    return node


def _createSurface(name, polyData, color):
    node = newNode("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(polyData)
    slicer.mrmlScene.AddNode(node)
    display = _newDisplay(node)
    display.SetColor(*color)
    return node, display


def showTube(node, axis, radius):
    """The tube along an axis, in place."""
    Display.showTubes(node, [(axis, radius)])
    node.GetDisplayNode().SetEdgeVisibility(False)


def newNode(className, name):
    """Markups node outside of the scene."""
    node = slicer.mrmlScene.CreateNodeByClass(className)
    node.UnRegister(None)
    node.SetName(name)
    node.SetHideFromEditors(True)
    node.SetSaveWithScene(False)
    return node


def _newDisplay(node):
    """Display node of a markups node outside of the scene."""
    node.CreateDefaultDisplayNodes()
    display = node.GetDisplayNode()
    display.SetSaveWithScene(False)
    return display


def removeMark(node):
    """Remove the mark, if any."""
    if node is not None and node.GetScene() is not None:
        removeWhole(node)
