"""Place: clicks into the 3D view, with the real widgets of markups, on the real scene."""

import numpy as np
import pytest
import slicer
from panel_helpers import deploy
from test_panel_dragging import besideTree, placeOf, theView, treeOf, wayTo  # noqa: F401


@pytest.fixture
def click(host, theView):  # noqa: F811
    """A function: a click on what is seen before a point in space."""

    def clicked(point):
        pixel = theView.pixel(point)
        theView.drag([pixel, pixel])
        host.process()

    return clicked


def isPlacing():
    interaction = slicer.app.applicationLogic().GetInteractionNode()
    return interaction.GetCurrentInteractionMode() == interaction.Place


def place(host, widget):
    if not isPlacing():  # an axis without a centerline is placed at once
        host.click(widget._button)
    assert isPlacing()


@pytest.mark.parametrize(("hasPoint", "wasPersistent"), [(True, False), (False, True)])
def test_place_moves_the_stent_to_the_click_and_ends(host, aStent, click, hasPoint, wasPersistent):
    handle, tree = aStent._parameterNode.stent.handle, treeOf(aStent)
    interaction = slicer.app.applicationLogic().GetInteractionNode()
    interaction.SetPlaceModePersistence(wasPersistent)
    if not hasPoint:
        handle.RemoveAllControlPoints()
    place(host, aStent.ui.placeWidget)
    wanted = wayTo(tree, tree.leaves[0])[5]
    click(wanted)
    assert not isPlacing()
    assert bool(interaction.GetPlaceModePersistence()) == wasPersistent
    interaction.SetPlaceModePersistence(False)
    assert handle.GetNumberOfDefinedControlPoints() == handle.GetNumberOfControlPoints() == 1
    np.testing.assert_allclose(placeOf(aStent), wanted, atol=1.0)
    assert besideTree(tree, [placeOf(aStent)]).max() < 1e-3
    assert aStent.ui.deployButton.enabled


def placingBegun(host, panel, index, hasPoints):
    """The handle of a kind of placement, which waits for clicks, and a way to take them from."""
    host.choose(panel.ui.placementComboBox, index)
    handle, tree = panel._parameterNode.stent.handle, treeOf(panel)
    if not hasPoints:
        handle.RemoveAllControlPoints()
    place(host, panel.ui.placeWidget)
    return handle, wayTo(tree, tree.leaves[0])


@pytest.mark.parametrize(("before", "isQuick"), [("nothing", True), ("a stented vessel", False)])
def test_an_axis_drawn_in_3d_runs_in_the_middle_of_the_lumen(
    host,
    aStent,
    theView,  # noqa: F811
    before,
    isQuick,
):
    """Held against the phantom's own centerline, and against what the middle of the lumen is good for."""
    tree, parameters = treeOf(aStent), aStent._parameterNode
    first, way = parameters.stent.handle, wayTo(tree, tree.leaves[0])
    drawn, radius = way[::4], np.nanmax(tree.inscribed_radius)
    first.SetNthControlPointPositionWorld(0, *drawn[len(drawn) // 2])
    if before == "nothing":
        host.click(aStent.ui.removeStentButton)
    elif before == "a stented vessel":
        aStent.ui.diameterSlider.value = 2.6 * radius
        deploy(host, aStent)
        first.GetDisplayNode().SetVisibility(False)
    aStent.ui.centerlineSelector.setCurrentNode(None)
    host.click(aStent.ui.addStentButton)
    handle = parameters.stent.handle
    place(host, aStent.ui.placeWidget)
    aside = np.array([0.4 * radius, 0.0, 0.0])  # a hand does not meet the middle
    for number, point in enumerate(drawn):
        pixel = theView.pixel(point + (-1) ** number * 0.3 * aside)
        theView.drag([pixel, pixel])
        if not isQuick:  # else the panel is busy meanwhile
            host.process()
        assert isPlacing()  # until the user ends it
    host.process()
    aStent.ui.placeWidget.placeModeEnabled = False
    points = [
        handle.GetNthControlPointPositionWorld(index)
        for index in range(handle.GetNumberOfDefinedControlPoints())
    ]
    assert len(points) == len(drawn)
    assert besideTree(tree, points).max() < 0.15 * radius
    if before == "nothing":
        aStent.ui.diameterSlider.value = 8.5
        deploy(host, aStent)
        (treated,) = aStent.logic.lastRun(parameters).result.stents
        assert np.isfinite(treated.before.inscribed_diameter).all()
        assert "not known \N{RIGHTWARDS ARROW}" not in aStent.ui.lumenLabel.text


@pytest.mark.parametrize(
    ("index", "count", "hasPoints", "isQuick"),
    [(3, 2, True, False), (3, 2, False, False), (0, 1, True, True), (3, 2, False, True)],
)
def test_two_clicks_place_one_after_the_other_and_at_once(
    host,
    aStent,
    theView,  # noqa: F811
    index,
    count,
    hasPoints,
    isQuick,
):
    handle, way = placingBegun(host, aStent, index, hasPoints)
    for isLast, point in enumerate((way[3], way[-3])):
        theView.drag([theView.pixel(point)] * 2)
        if not isQuick:  # else the panel is busy meanwhile
            host.process()
            assert isPlacing() != isLast
    host.process()
    assert not isPlacing()
    assert handle.GetNumberOfDefinedControlPoints() == handle.GetNumberOfControlPoints() == count
    for number, wanted in enumerate([way[3], way[-3]][-count:]):
        np.testing.assert_allclose(placeOf(aStent, number), wanted, atol=1.0)


@pytest.mark.parametrize("isQuick", [False, True])
def test_the_ends_of_a_segment_take_two_clicks(host, aStent, theView, isQuick):  # noqa: F811
    ui = aStent.ui
    ui.segmentCollapsibleButton.collapsed = False
    ends = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsFiducialNode", "Ends")
    ui.segmentEndsSelector.setCurrentNode(ends)
    tree = treeOf(aStent)
    way = wayTo(tree, tree.leaves[0])
    for first, last in ((2, -2), (4, -4)):
        place(host, ui.segmentPlaceWidget)
        for point in (way[first], way[last]):
            theView.drag([theView.pixel(point)] * 2)
            if not isQuick:
                host.process()
        host.process()
        assert not isPlacing()
        assert ends.GetNumberOfControlPoints() == 2


def test_a_point_placed_beside_the_vessel_stays_there_and_the_panel_says_so(host, aStent, click):
    tree, parameters = treeOf(aStent), aStent._parameterNode
    way, bounds = wayTo(tree, tree.leaves[0]), parameters.vessel.GetPolyData().GetBounds()
    host.click(aStent.ui.removeStentButton)
    aStent.ui.centerlineSelector.setCurrentNode(None)
    host.click(aStent.ui.addStentButton)
    handle = parameters.stent.handle
    place(host, aStent.ui.placeWidget)
    told = (
        f"{parameters.stent.label}: no vessel is seen where point 2 was placed; drag it into one."
    )
    click(way[2])
    assert told not in aStent.ui.statusLabel.text
    click([bounds[1] + 3.0, *way[5][1:]])
    assert told in aStent.ui.statusLabel.text.splitlines()
    click(way[8])
    assert told in aStent.ui.statusLabel.text.splitlines()
    aStent.ui.placeWidget.placeModeEnabled = False
    assert handle.GetNthControlPointPositionWorld(1)[0] > bounds[1]
    handle.SetNthControlPointPositionWorld(1, *way[5])
    deploy(host, aStent)
    assert told not in aStent.ui.statusLabel.text


@pytest.mark.parametrize(("hasPoint", "isByButton"), [(True, False), (False, True)])
def test_place_that_is_given_up_leaves_everything_as_it_was(
    host,
    aStent,
    theView,  # noqa: F811
    hasPoint,
    isByButton,
):
    handle, tree = aStent._parameterNode.stent.handle, treeOf(aStent)
    if not hasPoint:
        handle.RemoveAllControlPoints()
    host.process()
    interaction = slicer.app.applicationLogic().GetInteractionNode()
    points = slicer.util.arrayFromMarkupsControlPoints(handle, world=True).tolist()
    told = aStent.ui.statusLabel.text
    place(host, aStent.ui.placeWidget)
    for point in wayTo(tree, tree.leaves[0])[3:9:2]:  # the point goes with the mouse
        theView.mouse("MouseMove", theView.pixel(point))
        host.process()
    if isByButton:
        host.click(aStent.ui.placeWidget._button)
    else:
        interaction.SwitchToViewTransformMode()
    host.process()
    assert not isPlacing()
    assert not interaction.GetPlaceModePersistence()
    assert not aStent.ui.placeWidget.placeModeEnabled
    assert slicer.util.arrayFromMarkupsControlPoints(handle, world=True).tolist() == points
    assert handle.GetNumberOfDefinedControlPoints() == handle.GetNumberOfControlPoints()
    assert aStent.ui.statusLabel.text == told


def test_escape_ends_place_wherever_the_focus_is(host, aStent, theView):  # noqa: F811
    from PySide6 import QtCore, QtTest

    handle, tree = aStent._parameterNode.stent.handle, treeOf(aStent)
    points = slicer.util.arrayFromMarkupsControlPoints(handle, world=True).tolist()
    aStent.parent.activateWindow()
    place(host, aStent.ui.placeWidget)
    theView.mouse("MouseMove", theView.pixel(wayTo(tree, tree.leaves[0])[3]))
    aStent.ui.placeCollapsibleButton.collapsed = False
    aStent.ui.nameEdit.setFocus()
    QtTest.QTest.keyClick(aStent.ui.nameEdit, QtCore.Qt.Key_Escape)
    host.process()
    assert not isPlacing()
    assert slicer.util.arrayFromMarkupsControlPoints(handle, world=True).tolist() == points


def axisOf(panel, row):
    """Where a stent of the list will lie."""
    panel.ui.stentTable.selectRow(row)
    return panel.logic.stentLying(panel._parameterNode).axis


@pytest.mark.parametrize("kind", [0, 1, 2, 3])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_a_copy_begins_where_the_original_ends(host, aStent, kind, part):
    parameters, tree = aStent._parameterNode, treeOf(aStent)
    way = wayTo(tree, tree.leaves[0])
    handle = parameters.stent.handle
    handle.SetNthControlPointPositionWorld(0, *way[round(part * (len(way) - 1))])
    host.choose(aStent.ui.placementComboBox, kind)
    host.click(aStent.ui.copyStentButton)
    first, second = (axisOf(aStent, row) for row in (0, 1))
    ends = first.points[[0, -1]][:, None] - second.points[[-1, 0]]
    assert min(np.linalg.norm(ends, axis=2).diagonal()) < 2.5
    assert second.deployed_length == pytest.approx(first.deployed_length, rel=0.2)
    assert not any(stent.handle.GetLocked() for stent in parameters.stents)


def test_the_selected_stents_handle_is_taken_where_others_lie_on_it(host, aStent):
    ui, parameters = aStent.ui, aStent._parameterNode
    host.click(ui.copyStentButton)
    first, second = (stent.handle for stent in parameters.stents)
    assert not first.GetLocked()
    assert not second.GetLocked()
    place = first.GetNthControlPointPositionWorld(0)
    second.SetNthControlPointPositionWorld(0, *place)
    host.process()
    assert first.GetLocked()
    assert not second.GetLocked()
    ui.stentTable.selectRow(0)
    host.process()
    assert second.GetLocked()
    assert not first.GetLocked()
    aStent._moveStent(10.0)
    host.process()
    assert not first.GetLocked()
    assert not second.GetLocked()
    second.SetLocked(True)  # by the user
    first.SetNthControlPointPositionWorld(0, *second.GetNthControlPointPositionWorld(0))
    aStent._moveStent(10.0)
    host.process()
    assert second.GetLocked()
