"""What a user reads when something is missing, empty, broken or deleted: one sentence, and a clean log."""

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import settle

from SDFStentLib.validation import InputError


def emptyModel(scene, name="Empty"):
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", name)
    node.SetAndObservePolyData(vtk.vtkPolyData())
    return node


def changeStent(parameters, **values):
    from SDFStentSlicer.StentList import StentList

    stents = StentList(parameters)
    stents.replace([{**stents.values()[0], **values}], 0)


def noStentOn(parameters, scene):
    changeStent(parameters, enabled=False)


def noHandle(parameters, scene):
    changeStent(parameters, handle=None)


def handleWithoutPoints(parameters, scene):
    parameters.stent.handle.RemoveAllControlPoints()


def vesselDeleted(parameters, scene):
    scene.RemoveNode(parameters.vessel)


def handleDeleted(parameters, scene):
    scene.RemoveNode(parameters.stent.handle)


def vesselEmpty(parameters, scene):
    parameters.vessel = emptyModel(scene)


def vesselWithoutMesh(parameters, scene):
    parameters.vessel = scene.AddNewNodeByClass("vtkMRMLModelNode", "Nothing")


def vesselOfLines(parameters, scene):
    parameters.vessel = parameters.centerline


def vesselWithNaN(parameters, scene):
    slicer.util.arrayFromModelPoints(parameters.vessel)[3] = np.nan
    parameters.vessel.GetPolyData().Modified()


def vesselOfLooseTriangles(parameters, scene):
    split = vtk.vtkShrinkPolyData()
    split.SetShrinkFactor(0.9)
    split.SetInputData(parameters.vessel.GetPolyData())
    split.Update()
    parameters.vessel.SetAndObservePolyData(split.GetOutput())


def vesselUnderFlattening(parameters, scene):
    transform = scene.AddNewNodeByClass("vtkMRMLLinearTransformNode", "Flat")
    matrix = vtk.vtkMatrix4x4()
    matrix.SetElement(2, 2, 0)
    transform.SetMatrixTransformToParent(matrix)
    parameters.vessel.SetAndObserveTransformNodeID(transform.GetID())


def centerlineOfTriangles(parameters, scene):
    parameters.centerline = parameters.vessel


def centerlineEmpty(parameters, scene):
    parameters.centerline = emptyModel(scene)


def curveWithOnePoint(parameters, scene):
    curve = scene.AddNewNodeByClass("vtkMRMLMarkupsCurveNode", "Short")
    curve.AddControlPointWorld(1, 2, 3)
    parameters.centerline = curve


def segmentationWithoutSegment(parameters, scene):
    parameters.vessel = scene.AddNewNodeByClass("vtkMRMLSegmentationNode", "Blank")


def segmentNotChosen(parameters, scene):
    segmentation = scene.AddNewNodeByClass("vtkMRMLSegmentationNode", "Vessels")
    segmentation.SetSourceRepresentationToClosedSurface()
    segmentation.AddSegmentFromClosedSurfaceRepresentation(parameters.vessel.GetPolyData(), "lumen")
    parameters.vessel = segmentation


def pointFarAway(parameters, scene):
    parameters.stent.handle.SetNthControlPointPositionWorld(0, 500, 500, 500)


def longerThanTwiceTheVessel(parameters, scene):
    changeStent(parameters, length=400.0)


CASES = {
    noStentOn: "Add a stent, or switch one on",
    noHandle: "choose a handle",
    handleWithoutPoints: r"place 1 point\(s\)",
    vesselDeleted: "Select a vessel",
    handleDeleted: "choose a handle",
    vesselEmpty: "Vessel Empty: expected a surface",
    vesselWithoutMesh: "Vessel Nothing: expected a surface",
    vesselOfLines: "expected a surface of triangles",
    vesselWithNaN: "expected finite coordinates",
    vesselOfLooseTriangles: "expected triangles that share their points, got [0-9]+ that share none",
    vesselUnderFlattening: "expected a transform that can be inverted, got Flat",
    centerlineOfTriangles: "expected a model of lines",
    centerlineEmpty: "Centerline Empty: expected a model of lines",
    curveWithOnePoint: "Curve Short: expected at least two points, got 1",
    segmentationWithoutSegment: "the segmentation has none",
    segmentNotChosen: "Vessel Vessels: expected a segment, got none",
    pointFarAway: "expected a point within",
    longerThanTwiceTheVessel: r"at least half of its 360\.0 mm can lie on the vessel",
}


# The panel picks the first segment by itself, so it is never left without one.
@pytest.mark.parametrize(
    "spoil", [case for case in CASES if case is not segmentNotChosen], ids=lambda f: f.__name__
)
def test_the_panel_shows_the_sentence(spoil, host, aPanel, aLogic, theParameters, aScene):
    import re

    spoil(aPanel._parameterNode, aScene)
    host.process()
    if aPanel.ui.deployButton.enabled:
        host.click(aPanel.ui.deployButton)
        settle(host, aPanel)
    assert re.search(CASES[spoil], aPanel.ui.statusLabel.text)
    assert aPanel.ui.lumenLabel.text == ""


def test_deleting_a_node_while_deploying_ends_with_a_sentence_or_a_result(
    host, aPanel, aLogic, theParameters, aScene
):
    host.process()
    aPanel.session.start()
    aScene.RemoveNode(theParameters.outputVessel) if theParameters.outputVessel else None
    aScene.RemoveNode(theParameters.vessel)
    settle(host, aPanel)
    assert "Select a vessel" in aPanel.ui.statusLabel.text


def test_unknown_values_of_a_stent_are_named(aLogic, theParameters):
    with pytest.raises(InputError, match="got breadth"):
        aLogic.addStent(theParameters, breadth=3)


def test_what_was_said_of_other_inputs_is_gone(host, aStent, aScene):
    from SDFStentSlicer import Conversion

    from SDFStentLib.files import polydata_from_lines

    parameters, ui = aStent._parameterNode, aStent.ui
    right = parameters.centerline
    points, lines, _radii = Conversion.centerlineLines(right)
    wrong = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Of another patient")
    wrong.SetAndObservePolyData(polydata_from_lines(points + 500.0, lines))
    ui.centerlineSelector.setCurrentNode(wrong)
    settle(host, aStent)
    host.click(ui.deployButton)
    settle(host, aStent)
    assert parameters.status
    ui.centerlineSelector.setCurrentNode(right)
    settle(host, aStent)
    assert parameters.status == ""
    assert not ui.statusLabel.visible
