"""Handles that the mouse drags and places in a view: the real widgets of markups, on the real scene."""

import time

import numpy as np
import pytest
import slicer
from panel_helpers import deploy, planned, settle, theThroat

from SDFStentLib.stent import stent_axis


@pytest.fixture
def theView(host, aStent):
    """The 3D view, from the front, with the vessel before everything else in it."""
    view = host.application.view
    view.render(aStent._parameterNode.vessel.GetPolyData().GetBounds())
    return view


def treeOf(panel):
    return panel.logic.centerlineOf(panel._parameterNode)


def placeOf(panel, index=0):
    return np.array(panel._parameterNode.stent.handle.GetNthControlPointPositionWorld(index))


def wayTo(tree, leaf):
    """Points of the tree from 10 mm below its root to 10 mm above a leaf."""
    chain = tree.ancestry(leaf)
    at = tree.arc_length[chain]
    return tree.points[chain[(at > 10.0) & (at < at[-1] - 10.0)]]


def dragged(panel, view, way, wobble=4.0):
    """Drag the handle over places of the tree, with a hand that wobbles by some pixels; the places that it had."""
    steps = way[np.linspace(0, len(way) - 1, 40).astype(int)]
    beside = wobble * np.column_stack([np.sin(np.arange(40)), np.cos(np.arange(40))])
    beside[0] = 0.0
    panel._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *way[0])
    found = []
    pixels = [view.pixel(step) + shift for step, shift in zip(steps, beside, strict=True)]
    view.drag(pixels, lambda: found.append(placeOf(panel)))
    return np.array(found), np.array(pixels[1:])


def besideTree(tree, places):
    return np.array([tree.project(place).distance for place in places])


def test_a_handle_is_dragged_along_the_vessel_and_across_its_junctions(host, aStent, theView):
    tree, refused = treeOf(aStent), []
    aStent.session._onDone = lambda error, standing: refused.append(error) if error else None
    aStent.ui.autoUpdateCheckBox.checked = True
    settle(host, aStent)
    for leaf in tree.leaves:
        way = wayTo(tree, leaf)
        found, pixels = dragged(aStent, theView, way)
        host.process()
        assert besideTree(tree, found).max() < 1e-3
        seen = np.array([theView.pixel(place) for place in found])
        assert np.linalg.norm(seen - pixels, axis=1).max() < 12.0
        np.testing.assert_allclose(placeOf(aStent), way[-1], atol=2.0)
        back = dragged(aStent, theView, way[::-1])[0]
        assert besideTree(tree, back).max() < 1e-3
    settle(host, aStent)
    assert refused == []


def test_a_handle_stays_in_its_vessel_where_another_lies_before_it(host, aStent, theView):
    tree = treeOf(aStent)
    bounds = aStent._parameterNode.vessel.GetPolyData().GetBounds()
    theView.look(bounds, direction=(1.0, 0.0, 0.0))  # the branches lie one behind the other
    for leaf in tree.leaves:
        vessel = tree.points[tree.ancestry(leaf)]
        way = wayTo(tree, leaf)[::-1]
        found, _pixels = dragged(aStent, theView, way)
        assert np.linalg.norm(found[:, None] - vessel, axis=2).min(axis=1).max() < 0.5
        np.testing.assert_allclose(found[-1], way[-1], atol=1.0)


def test_one_end_of_a_stent_between_two_points_is_dragged_alone(host, aStent, theView):
    host.choose(aStent.ui.placementComboBox, 3)
    tree, (start, end) = treeOf(aStent), (placeOf(aStent, 0), placeOf(aStent, 1))
    pixel = theView.pixel(end)
    theView.drag([pixel, pixel + np.array([3.0, 30.0]), pixel + np.array([3.0, 60.0])])
    np.testing.assert_allclose(placeOf(aStent, 0), start, atol=1e-5)
    assert np.linalg.norm(placeOf(aStent, 1) - end) > 1.5
    assert besideTree(tree, [placeOf(aStent, 1)]).max() < 1e-3


def endsOf(host, panel):
    host.processUntil(lambda: not panel.ends.isBusy)
    node = slicer.util.getNode("Ends of the stent")
    return np.array([node.GetNthControlPointPositionWorld(index) for index in range(2)])


@pytest.mark.parametrize(("placement", "kept"), [(0, 0), (0, 1), (0, 2), (1, 0), (2, 0)])
def test_a_dot_at_an_end_is_dragged_for_the_length(host, aStent, theView, placement, kept):
    """The other end stays; the stent reaches from one dot to the other once it has shortened."""
    ui, tree = aStent.ui, treeOf(aStent)
    host.choose(ui.placementComboBox, placement)
    host.choose(ui.keptComboBox, kept)
    ui.foreshorteningSlider.value = 20.0
    for end in {0: (0, 1), 1: (0,), 2: (1,)}[placement]:  # at the other end is the handle
        before, length = endsOf(host, aStent), ui.lengthSlider.value
        pixels = [theView.pixel(point) for point in before]
        away = (pixels[end] - pixels[1 - end]) / np.linalg.norm(pixels[end] - pixels[1 - end])
        theView.drag([pixels[end] + step * away for step in (0.0, 10.0, 20.0, 30.0)])
        after = endsOf(host, aStent)
        assert ui.lengthSlider.value > length + 1.0
        np.testing.assert_allclose(after[1 - end], before[1 - end], atol=0.02)
        assert besideTree(tree, after).max() < 1e-3
        (stent,) = planned(aStent)
        lying = stent_axis(stent, tree)
        np.testing.assert_allclose(lying.points[[0, -1]], after, atol=1e-3)
        assert lying.line.length == pytest.approx(0.8 * ui.lengthSlider.value, abs=0.02)
    host.click(ui.removeStentButton)
    host.processUntil(lambda: not aStent.ends.isBusy)
    assert slicer.mrmlScene.GetFirstNodeByName("Ends of the stent") is None


def test_where_a_stent_will_lie_is_seen_until_it_is_deployed(host, aStent):
    """Nothing but the dots told it, which lie inside of the vessel."""

    def tube():
        host.processUntil(lambda: not aStent.ends.isBusy)
        return slicer.mrmlScene.GetFirstNodeByName("Planned stent")

    ui, ends = aStent.ui, endsOf(host, aStent)
    wall = slicer.util.arrayFromModelPoints(tube())
    for end in ends:
        away = np.linalg.norm(wall - end, axis=1).min()
        assert away == pytest.approx(ui.diameterSlider.value / 2, rel=0.05)
    deploy(host, aStent)
    assert tube() is None
    ui.diameterSlider.value += 1.0
    assert tube() is not None
    host.choose(ui.placementComboBox, 3)  # it has no dots at its ends, but handles
    assert tube() is not None
    host.click(ui.removeStentButton)
    assert tube() is None


@pytest.mark.parametrize("end", [None, 1])
def test_where_a_stent_will_lie_follows_the_hand(host, aStent, theView, end):
    tree, found = treeOf(aStent), []
    ends = endsOf(host, aStent)

    def look():
        time.sleep(0.03)  # as a hand does
        host.process()
        tube = slicer.mrmlScene.GetFirstNodeByName("Planned stent")
        found.append(None if tube is None else slicer.util.arrayFromModelPoints(tube).mean(axis=0))

    way = wayTo(tree, tree.leaves[0])
    if end is None:  # the handle
        aStent._parameterNode.stent.handle.SetNthControlPointPositionWorld(0, *way[0])
        steps = way[np.linspace(0, len(way) - 1, 40).astype(int)]
        theView.drag([theView.pixel(step) for step in steps], look)
    else:
        begin, other = theView.pixel(ends[end]), theView.pixel(ends[1 - end])
        steps = np.linspace(0, 40, 40)[:, None] * (begin - other) / np.linalg.norm(begin - other)
        theView.drag([begin + step for step in steps], look)
    assert not any(place is None for place in found)
    assert len(np.unique(np.round(found, 3), axis=0)) > 4
    (stent,) = planned(aStent)
    host.processUntil(lambda: not aStent.ends.isBusy)
    look()
    lying = stent_axis(stent, tree).line.resampled(0.5).points
    np.testing.assert_allclose(found[-1], lying.mean(axis=0), atol=0.2)


def test_a_handle_dragged_in_a_slice_view_goes_to_the_nearest_place_in_space(host, aStent):
    handle, tree = aStent._parameterNode.stent.handle, treeOf(aStent)
    handle.SetAttribute("Markups.MovingInSliceView", "Red")  # as the widget of the view does
    handle.SetAttribute("Markups.MovingMarkupIndex", "0")
    point = np.array(theThroat()) + np.array([2.0, 3.0, 1.0])
    handle.SetNthControlPointPositionWorld(0, *point)
    handle.SetAttribute("Markups.MovingInSliceView", "")
    np.testing.assert_allclose(placeOf(aStent), tree.project(point).point, atol=0.3)
    assert besideTree(tree, [placeOf(aStent)]).max() < 1e-3
    handle.SetAttribute("Markups.MovingMarkupIndex", "")
    handle.SetNthControlPointPositionWorld(0, *point)  # without the mouse
    np.testing.assert_allclose(placeOf(aStent), point)


def test_points_of_a_drawn_axis_keep_their_depth(host, aStent, theView):
    from SDFStentSlicer import Handles

    place = placeOf(aStent)
    points = [place, place + np.array([0.0, 0.0, 8.0])]
    curve = Handles.createHandle(slicer.mrmlScene, "Axis", points, Handles.CURVE)
    aStent._parameterNode.stent.handle.GetDisplayNode().SetVisibility(False)
    pixel = theView.pixel(points[1])
    theView.drag([pixel, pixel + np.array([10.0, 0.0])])
    moved = np.array(curve.GetNthControlPointPositionWorld(1)) - points[1]
    toCamera = theView.renderer.GetActiveCamera().GetDirectionOfProjection()
    assert np.linalg.norm(moved) > 0.3
    assert abs(np.dot(moved, toCamera)) < 1e-3


def press(host, widget, key, isShifted=False):
    from PySide6 import QtCore, QtTest

    held = QtCore.Qt.ShiftModifier if isShifted else QtCore.Qt.NoModifier
    widget.window().activateWindow()
    widget.setFocus()
    QtTest.QTest.keyClick(widget, getattr(QtCore.Qt, f"Key_{key}"), held)
    host.process()


def test_the_stent_whose_handle_is_taken_is_edited_and_moved_by_keys(host, aStent, theView):
    first = aStent._parameterNode.stent.handle
    host.click(aStent.ui.addStentButton)
    assert aStent._parameterNode.selected == 1
    first.SetNthControlPointPositionWorld(0, *wayTo(treeOf(aStent), treeOf(aStent).leaves[0])[0])
    aStent.ui.nameEdit.setFocus()
    pixel = theView.pixel(np.array(first.GetNthControlPointPositionWorld(0)))
    theView.drag([pixel, pixel + np.array([0.0, -5.0])])
    assert aStent.ui.stentTable.currentRow() == aStent._parameterNode.selected == 0
    assert aStent.ui.stentTable.hasFocus()


def test_arrow_keys_in_the_table_move_the_stent_along_the_vessel(host, aStent):
    tree, table = treeOf(aStent), aStent.ui.stentTable
    for key, isShifted, way in (
        ("Right", False, 1.0),
        ("Right", True, 0.2),
        ("Left", False, -1.0),
        ("Left", True, -0.2),
    ):
        before = tree.project(placeOf(aStent)).arc_length
        press(host, table, key, isShifted)
        moved = tree.project(placeOf(aStent))
        assert moved.arc_length - before == pytest.approx(way, abs=1e-4)
        assert moved.distance < 1e-4
