"""A segment that has no surface yet is seen in 3D as soon as it is chosen, until a result stands in its place."""

import numpy as np
import slicer
from panel_helpers import settle
from test_made_centerline import addTube, made


def walls():
    """The walls of segments in the 3D views."""
    models = slicer.util.getNodesByClass("vtkMRMLModelNode")
    return [one for one in models if one.GetName() == "Wall of the segment"]


def shown(host):
    host.processUntil(lambda: walls())
    (wall,) = walls()
    return wall


def gone(host):
    host.processUntil(lambda: not walls())


def test_a_segment_of_voxels_is_seen_at_once_and_stays_as_it_is(host, aPanel, aScene):
    node = addTube(aScene)
    (segmentID,) = node.GetSegmentation().GetSegmentIDs()
    wall = shown(host)
    assert aPanel._parameterNode.vessel is node
    display = wall.GetDisplayNode()
    assert (display.GetVisibility3D(), display.GetVisibility2D()) == (1, 0)
    assert 0 < display.GetOpacity() < 1
    assert wall.GetHideFromEditors()
    assert not wall.GetSaveWithScene()
    low, high = np.reshape(wall.GetPolyData().GetBounds(), (3, 2)).T
    assert (high - low).max() > 20
    names = slicer.vtkSegmentationConverter
    surface = names.GetSegmentationClosedSurfaceRepresentationName()
    assert node.GetSegmentation().GetSegment(segmentID).GetRepresentation(surface) is None


def test_it_is_seen_where_the_segment_is_and_where_no_result_is(host, aPanel, aScene):
    node = addTube(aScene)
    (segmentID,) = node.GetSegmentation().GetSegmentIDs()
    shown(host)
    display = node.GetDisplayNode()
    for hide in (display.SetVisibility, lambda to: display.SetSegmentVisibility(segmentID, to)):
        hide(False)
        gone(host)
        hide(True)
        shown(host)
    made(host, aPanel)
    settle(host, aPanel)
    assert len(walls()) == 1
    host.click(aPanel.ui.addStentButton)
    host.click(aPanel.ui.deployButton)
    settle(host, aPanel)
    assert aPanel._parameterNode.outputVessel is not None
    assert walls() == []


def test_it_follows_the_choice_and_leaves_with_the_panel(host, aPanel, aScene, aVessel):
    node = addTube(aScene)
    aPanel.ui.vesselSelector.setCurrentNode(node)
    first = shown(host)
    aPanel.ui.vesselSelector.setCurrentNode(aVessel[0])
    gone(host)
    aPanel.ui.vesselSelector.setCurrentNode(node)
    assert shown(host) is not first
    aPanel.exit()
    gone(host)
    aPanel.enter()
    shown(host)


def test_where_the_segment_has_a_surface_the_application_shows_it(host, aPanel, aScene):
    node = addTube(aScene)
    shown(host)
    node.CreateClosedSurfaceRepresentation()
    gone(host)


def test_views_that_do_not_have_it_look_at_it(host, aPanel, aScene):
    camera = aScene.GetFirstNodeByClass("vtkMRMLCameraNode")
    camera = camera or aScene.AddNewNodeByClass("vtkMRMLCameraNode")
    camera.SetPosition(0, 500, 0)
    camera.SetFocalPoint(0, 1000, 0)
    addTube(aScene)
    wall = shown(host)
    low, high = np.reshape(wall.GetPolyData().GetBounds(), (3, 2)).T
    host.process()
    np.testing.assert_allclose(camera.GetFocalPoint(), (low + high) / 2, atol=1e-6)
