"""Nodes that only show something: nobody chooses or saves them. Markups are seen through what lies before them."""

import numpy as np
import slicer
from slicer.i18n import tr as _

from . import Display
from .Handles import removeWhole

TUBE_COLOR = (0.15, 0.65, 0.5)
"""Neither that of lines and handles nor that of lesions."""


def createMark(className, name, points, texts=None):
    """A markups node with a control point per row of `points`, which is in nobody's way.

    `texts` stand beside the points; then one without a text is not seen.
    """
    node = _newNode(className, name)
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


def createTube(name, axis, radius):
    """A model node of the tube that a stent will be."""
    node = _newNode("vtkMRMLModelNode", name)
    slicer.mrmlScene.AddNode(node)
    display = _newDisplay(node)
    display.SetVisibility2D(True)
    display.SetColor(*TUBE_COLOR)
    Display.showTubes(node, [(axis, radius)])
    display.SetEdgeVisibility(False)
    return node


def createChart(title, position, series):
    """A plot chart, and before it in the list all that it is made of.

    `position` is (label, values), `series` maps a label to (values, color); the last of them is dashed.
    """
    names, dashed = [position[0], *series], [*series][-1]
    columns = [position[1], *(values for values, _color in series.values())]
    table = slicer.mrmlScene.AddNode(_newNode("vtkMRMLTableNode", title))
    slicer.util.updateTableFromArray(table, columns, names)
    chart = _newNode("vtkMRMLPlotChartNode", title)
    chart.SetTitle(title)
    chart.SetXAxisTitle(position[0])
    chart.SetYAxisTitle(_("Diameter (mm)"))
    Display.showFromZero(chart, 1.1 * np.nanmax(columns[1:]))
    lines = []
    for name, (_values, color) in series.items():
        line = slicer.mrmlScene.AddNode(_newNode("vtkMRMLPlotSeriesNode", name))
        Display.styleSeries(line, color, name == dashed)
        Display.drawColumns(line, table, position[0], name)
        chart.AddAndObservePlotSeriesNodeID(line.GetID())
        lines.append(line)
    return [table, *lines, slicer.mrmlScene.AddNode(chart)]


def _newNode(className, name):
    """One that is not in the scene yet."""
    node = slicer.mrmlScene.CreateNodeByClass(className)
    node.UnRegister(None)
    node.SetName(name)
    node.SetHideFromEditors(True)
    node.SetSaveWithScene(False)
    return node


def _newDisplay(node):
    """The display node of one that is."""
    node.CreateDefaultDisplayNodes()
    display = node.GetDisplayNode()
    display.SetSaveWithScene(False)
    return display


def removeMark(node):
    """Take it away again, if there is one."""
    if node is not None and node.GetScene() is not None:
        removeWhole(node)
