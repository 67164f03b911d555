"""*Make* beside the choice of a centerline: of a model, of a segment as it was segmented, and with what else happens meanwhile."""

import threading

import numpy as np
import pytest
import slicer
import vtk
from panel_helpers import settle, theThroat
from scipy.spatial import cKDTree
from vtkmodules.util.numpy_support import numpy_to_vtk

from benchmarks.voxels import voxel_tube

TUBE = voxel_tube(7.0, np.full(3, 0.7), 0.0, 3)
"""Narrowed by half in its middle, and as wide as this elsewhere, mm."""


def addTube(scene, name="Scan"):
    """A segmentation of one segment, as the Segment Editor leaves it: of voxels."""
    label, image = TUBE.labelmap, slicer.vtkOrientedImageData()
    image.SetDimensions(*label.mask.shape)
    image.SetSpacing(*label.spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(label.mask.T.astype(np.uint8).ravel(), deep=True))
    node = scene.AddNewNodeByClass("vtkMRMLSegmentationNode", name)
    node.CreateDefaultDisplayNodes()
    node.AddSegmentFromBinaryLabelmapRepresentation(image, "Artery", [1, 0, 0], "")
    return node


def made(host, panel):
    """Click Make and wait; the centerline that is chosen then."""
    host.click(panel.ui.extractButton)
    host.processUntil(lambda: not panel.vessel.making.isRunning)
    return panel._parameterNode.centerline


def test_a_vessel_gets_its_centerline_without_another_extension(host, aPanel, aVessel):
    vessel, theirs = aVessel
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    aPanel.ui.centerlineSelector.setCurrentNode(theirs)
    line = made(host, aPanel)
    assert line not in (None, theirs)
    assert line.GetName() == f"{vessel.GetName()} centerline_1"  # beside theirs
    assert aPanel.ui.centerlineSelector.currentNode() is line
    settle(host, aPanel)
    found = aPanel.logic.centerlineOf(aPanel._parameterNode)
    from SDFStentSlicer import Conversion

    expected = Conversion.centerlineOf(theirs)
    assert len(found.leaves) == len(expected.leaves)
    off, _ = cKDTree(found.points).query(expected.points[expected.leaves])
    assert off.max() < expected.inscribed_radius.max()
    first = aPanel.logic.lesionSearch(aPanel._parameterNode).found[0]
    assert np.linalg.norm(first.point - theThroat()) < 1


def test_a_segment_comes_to_its_first_stent_by_three_clicks(host, aPanel, aScene):
    node = addTube(aScene)
    host.process()
    assert aPanel._parameterNode.vessel is node  # there is nothing to ask
    assert aPanel.ui.statusLabel.text.startswith("Select a centerline, or make one")
    line = made(host, aPanel)
    assert line.GetName() == "Artery centerline"
    tree = aPanel.logic.centerlineOf(aPanel._parameterNode)
    ends = tree.points[[*tree.roots, *tree.leaves]]
    assert len(ends) == 2
    off, _ = cKDTree(tree.points).query(TUBE.axis[200:1000:50])
    assert np.median(off) < TUBE.labelmap.voxel / 2
    settle(host, aPanel)
    assert aPanel.ui.lesionTable.rowCount == 1
    host.click(aPanel.ui.addStentButton)
    host.click(aPanel.ui.deployButton)
    settle(host, aPanel)
    assert "certified for meshing" in aPanel._parameterNode.certificateSummary


@pytest.mark.parametrize("kind", ["segment", "model of voxels", "model"])
def test_lesions_of_voxels_are_told_as_ranges(host, aPanel, aScene, kind):
    from SDFStentSlicer import Conversion

    from SDFStentLib.files import VOXEL_ARRAY
    from SDFStentLib.scan import voxel_range

    node = addTube(aScene)
    host.process()
    if kind != "segment":
        (segmentID,) = node.GetSegmentation().GetSegmentIDs()
        wall, node = Conversion.vesselPolyData(node, segmentID), None
        if kind == "model of voxels":
            sides = numpy_to_vtk(np.full(3, 0.7), deep=True)
            sides.SetName(VOXEL_ARRAY)
            wall.GetFieldData().AddArray(sides)
        node = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Wall")
        node.SetAndObservePolyData(wall)
        node.CreateDefaultDisplayNodes()
        aPanel.ui.vesselSelector.setCurrentNode(node)
    made(host, aPanel)
    settle(host, aPanel)
    cells = [aPanel.ui.lesionTable.item(0, column) for column in range(4)]
    search = aPanel.logic.lesionSearch(aPanel._parameterNode)
    (lesion,) = search.found
    assert cells[3].text() == f"{lesion.length:.0f} mm"
    told = [f"{lesion.percent_diameter:.0f} %", f"{lesion.minimum_diameter:.1f} mm"]
    if kind == "model":
        assert [cell.text() for cell in cells[1:3]] == told
        return
    found = voxel_range(search.vessel, 0.35)
    (low, high), (least, most) = found.stenoses[0].before, found.minima[0].before
    assert low < lesion.percent_diameter < high
    told = [f"{told[0]} ({low:.0f}-{high:.0f})", f"{told[1]} ({least:.1f}-{most:.1f})"]
    assert [cell.text() for cell in cells[1:3]] == told
    assert all("half a voxel (0.35 mm) in or out" in cell.toolTip() for cell in cells)


@pytest.mark.parametrize("sides", [(0.0, 0.7, 0.7), (0.7,), (0.7, 0.7, 0.7, 2.0)])
def test_sizes_that_are_none_of_a_voxel_make_no_ranges(host, aScene, sides):
    """Ranges came of any number of sizes, and of a voxel without size, which the shell refuses."""
    from SDFStentSlicer import Conversion

    from SDFStentLib.files import VOXEL_ARRAY

    node = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Wall")
    wall, array = vtk.vtkPolyData(), numpy_to_vtk(np.array(sides), deep=True)
    array.SetName(VOXEL_ARRAY)
    wall.GetFieldData().AddArray(array)
    node.SetAndObservePolyData(wall)
    assert Conversion.halfVoxel(node) is None


def test_a_segmentation_of_several_is_asked_about(host, aPanel, aScene):
    node = addTube(aScene)
    node.GetSegmentation().AddEmptySegment("other")
    host.process()
    assert aPanel._parameterNode.vessel is None


def test_meanwhile_the_button_stops_and_nothing_is_left(host, aPanel, aVessel):
    host.process()  # what was loaded is chosen
    aPanel.ui.centerlineSelector.setCurrentNode(None)
    count = aVessel[0].GetScene().GetNumberOfNodesByClass("vtkMRMLModelNode")
    host.click(aPanel.ui.extractButton)
    assert aPanel.ui.extractButton.text == "Stop, 0 %"
    assert aPanel.vessel.making.isRunning
    host.click(aPanel.ui.extractButton)
    assert not aPanel.vessel.making.isRunning
    assert aPanel.ui.extractButton.text == "Make"
    assert aVessel[0].GetScene().GetNumberOfNodesByClass("vtkMRMLModelNode") == count
    assert aPanel._parameterNode.centerline is None


def test_the_button_tells_the_share_that_is_done(host, aPanel, aVessel):
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    shares = list(aPanel.logic.centerlineInPortions(aPanel._parameterNode))
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert shares[-1] > 0.5


def test_nothing_goes_on_for_a_centerline_that_is_stopped(host, aPanel, aVessel, monkeypatch):
    """A thread went on to the end, and whatever else was to be done shared the processor with it."""
    from SDFStentSlicer import MadeCenterline

    heard, mayGoOn = [], threading.Event()

    class Vessel:
        def extracted(self, show):
            show(0.25)
            heard.append(threading.current_thread())
            mayGoOn.wait()
            show(0.5)
            heard.append("went on")

    monkeypatch.setattr(MadeCenterline, "vessel_of", lambda _surface: (Vessel(), ""))
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.extractButton)
    host.processUntil(lambda: heard)
    host.processUntil(lambda: aPanel.ui.extractButton.text == "Stop, 25 %")
    host.click(aPanel.ui.extractButton)
    mayGoOn.set()
    heard[0].join()
    assert "went on" not in heard


def test_of_a_vessel_that_is_left_none_is_made(host, aPanel, aVessel):
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.extractButton)
    aPanel.ui.vesselSelector.setCurrentNode(None)
    assert not aPanel.vessel.making.isRunning
    assert aPanel.ui.extractButton.text == "Make"
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    host.click(aPanel.ui.extractButton)
    aVessel[0].GetMesh().Modified()
    host.processUntil(lambda: not aPanel.vessel.making.isRunning)
    assert "it has changed; make it again" in aPanel.ui.statusLabel.text


def test_without_two_ends_the_panel_says_what_to_do(host, aPanel, aScene):
    ball = vtk.vtkSphereSource()
    ball.SetRadius(5.0)
    ball.SetThetaResolution(24)
    ball.SetPhiResolution(24)
    ball.Update()
    node = aScene.AddNewNodeByClass("vtkMRMLModelNode", "Ball")
    node.SetAndObservePolyData(ball.GetOutput())
    node.CreateDefaultDisplayNodes()
    aPanel.ui.vesselSelector.setCurrentNode(node)
    assert made(host, aPanel) is None
    assert "expected two ends or more" in aPanel.ui.statusLabel.text
    assert aPanel.ui.extractButton.text == "Make"


@pytest.mark.parametrize("had", [True, False])
def test_undo_leads_back_to_the_former_centerline_and_redo_to_this_one(host, aPanel, aVessel, had):
    vessel, former = aVessel
    host.process()  # what was loaded is chosen
    aPanel.ui.centerlineSelector.setCurrentNode(former if had else None)
    settle(host, aPanel)
    line = made(host, aPanel)
    host.click(aPanel.ui.undoButton)
    assert aPanel._parameterNode.centerline is (former if had else None)
    host.click(aPanel.ui.redoButton)
    assert aPanel._parameterNode.centerline is line
    host.click(aPanel.ui.undoButton)
    vessel.GetScene().RemoveNode(line)
    host.click(aPanel.ui.redoButton)
    assert aPanel._parameterNode.centerline is (former if had else None)


def test_it_lies_in_a_vessel_that_a_transform_has_moved(host, aLogic, aVessel, aScene):
    matrix = aScene.AddNewNodeByClass("vtkMRMLLinearTransformNode")
    where = vtk.vtkMatrix4x4()
    for k, value in enumerate((5.0, -20.0, 90.0)):
        where.SetElement(k, 3, value)
    matrix.SetMatrixTransformToParent(where)
    aVessel[0].SetAndObserveTransformNodeID(matrix.GetID())
    parameters = aLogic.getParameterNode()
    parameters.vessel = aVessel[0]
    aLogic.makeCenterline(parameters)
    wall = aLogic._inputs.vessel(parameters).surface
    assert wall.contains(aLogic.centerlineOf(parameters).points[5:-5]).mean() > 0.9
