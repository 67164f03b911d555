"""The markups that place a stent: made on the centerline, snapped to it, fitted to the kind of placement."""

import re

import numpy as np
import slicer
from slicer.i18n import tr as _

from . import Conversion
from .PlanFields import Placement

HANDLE_ATTRIBUTE = "SDFStent.Handle"
AWAY_ATTRIBUTE = "SDFStent.GivesWay"
POINTS, CURVE = "vtkMRMLMarkupsFiducialNode", "vtkMRMLMarkupsCurveNode"
COLOR = (0.1, 0.55, 0.95)
USUAL_LENGTH = 20.0
"""The length of a new stent, mm."""
PALE = 0.3
"""Opacity of a handle whose stent is switched off."""
ON_ANOTHER = 1.0
"""Distance, mm, below which a point of a handle is seen on that of another one."""


def freeName(scene, name):
    """A name that no node of the scene has: this one, or with another number in parentheses behind it."""
    stem = re.sub(r" \(\d+\)$", "", name)
    free, number = name, 1
    # Ends: there are finitely many nodes.
    while scene.GetFirstNodeByName(free) is not None:
        number += 1
        free = f"{stem} ({number})"
    return free


def createHandle(scene, label, points, className=POINTS):
    """A markups point list or curve of ours, one control point per row of `points`."""
    node = scene.AddNewNodeByClass(className, freeName(scene, label))
    node.SetAttribute(HANDLE_ATTRIBUTE, "1")
    node.CreateDefaultDisplayNodes()
    display = node.GetDisplayNode()
    if display is not None:
        display.SetSelectedColor(*COLOR)
        display.SetPointLabelsVisibility(False)
        display.SetPropertiesLabelVisibility(False)
        display.SetSnapMode(display.SnapModeUnconstrained)  # not onto the wall in front of it
        display.SetOccludedVisibility(True)
        display.SetOccludedOpacity(0.7)
    if className != POINTS:
        node.SetCurveTypeToLinear()  # the curve is the polyline of the plan, point by point
    for point in points:
        node.AddControlPointWorld(*point)
    return node


def newHandle(centerline, values):
    """The handle of a new stent at the middle of a centerline, or without one a curve that the user has to draw."""
    if centerline is None:
        return createHandle(slicer.mrmlScene, values["label"], [], CURVE)
    handle = createHandle(slicer.mrmlScene, values["label"], [middlePoint(centerline)])
    placement = values.get("placement", Placement.CENTER)
    fitHandle(handle, placement, centerline, values.get("length", USUAL_LENGTH))
    return handle


def bringTo(node, className, points):
    """Move the placed points of a handle; false, and nothing is done, where it is of another kind or has more or fewer."""
    if not node.IsA(className) or len(Conversion.placedIndices(node)) != len(points):
        return False
    placeAt(node, points)
    return True


def bring(node, point):
    """Put the only point of a handle to a place, where it is not there yet."""
    placed = Conversion.placedIndices(node)
    if not placed:
        node.AddControlPointWorld(*point)
    elif not np.allclose(Conversion.placedPoints(node)[0], point, rtol=0, atol=1e-9):
        node.SetNthControlPointPositionWorld(placed[0], *point)


def placeAt(node, points):
    """Move the placed points of a markups node, as many as there are."""
    with slicer.util.NodeModify(node):
        for index, point in zip(Conversion.placedIndices(node), points, strict=True):
            node.SetNthControlPointPositionWorld(index, *point)


def copyHandle(node, label):
    """Handle of ours with the placed points of another one; a curve runs as the other one does."""
    points = [] if node is None else Conversion.placedPoints(node)
    if node is None or not node.IsA(CURVE):
        return createHandle(slicer.mrmlScene, label, points)
    copy = createHandle(slicer.mrmlScene, label, points, className=node.GetClassName())
    copy.SetCurveType(node.GetCurveType())
    copy.SetNumberOfPointsPerInterpolatingSegment(node.GetNumberOfPointsPerInterpolatingSegment())
    return copy


def giveWay(chosen, handles):
    """Lock those of our handles that lie on a chosen one, and let the mouse have all others again: of two it takes any."""
    points = _rows([] if chosen is None else Conversion.placedPoints(chosen))
    for node in handles:
        if node is None or not node.GetAttribute(HANDLE_ATTRIBUTE):
            continue
        apart = np.linalg.norm(_rows(Conversion.placedPoints(node))[:, None] - points, axis=2)
        isOn = node is not chosen and bool((apart < ON_ANOTHER).any())
        isAway = node.GetAttribute(AWAY_ATTRIBUTE) is not None
        if isOn != isAway and (isAway or not node.GetLocked()):  # a user may lock one himself
            node.SetAttribute(AWAY_ATTRIBUTE, "1" if isOn else None)
            node.SetLocked(isOn)


def fade(handles, strong):
    """Show our handles pale but for the `strong` ones."""
    for node in handles:
        display = node and node.GetAttribute(HANDLE_ATTRIBUTE) and node.GetDisplayNode()
        wanted = 1.0 if node in strong else PALE
        if display and display.GetOpacity() != wanted:
            display.SetOpacity(wanted)


def _rows(points):
    return np.reshape(points, (-1, 3))


def removeHandle(node):
    """Take a handle out of the scene if this module made it; a user's own markups stays."""
    if node is not None and node.GetAttribute(HANDLE_ATTRIBUTE):
        removeWhole(node)


def removeWhole(node):
    """Remove a node with its display and storage nodes."""
    scene, helpers = node.GetScene(), []
    if node.IsA("vtkMRMLStorableNode"):
        helpers.append(node.GetStorageNode())
    if node.IsA("vtkMRMLDisplayableNode"):
        helpers += [node.GetNthDisplayNode(n) for n in range(node.GetNumberOfDisplayNodes())]
    for one in (node, *helpers):
        if one is not None and one.GetScene() is scene:  # the module Data takes some with the node
            scene.RemoveNode(one)


def middlePoint(centerline):
    """The middle of the longest way down the centerline, (3,)."""
    leaf = centerline.leaves[np.argmax(centerline.arc_length[centerline.leaves])]
    chain = centerline.ancestry(leaf)
    at = centerline.arc_length[chain]
    return centerline.points[chain[np.argmin(abs(at - at[-1] / 2))]]


def endsAround(centerline, point, length):
    """Two points on the centerline, about half of `length` up and down from `point`, (2, 3)."""
    path = centerline.path_around(point, length)
    return path.points[[0, -1]]


def isOwn(node):
    """Whether a handle is a point list that this module has made."""
    return node is not None and bool(node.GetAttribute(HANDLE_ATTRIBUTE)) and not node.IsA(CURVE)


def fitHandle(node, placement, centerline, length):
    """Give a point list of ours the points that a placement needs; the user's own markups stay as they are."""
    if not isOwn(node) or placement == Placement.AGAIN:
        return
    placed, points = Conversion.placedIndices(node), Conversion.placedPoints(node)
    with slicer.util.NodeModify(node):
        if placement == Placement.BETWEEN_POINTS and len(placed) == 1:
            ends = endsAround(centerline, points[0], length)
            node.SetNthControlPointPositionWorld(placed[0], *ends[0])
            node.AddControlPointWorld(*ends[1])
        elif placement.pointCount == 1 and len(placed) > 1:
            middle = centerline.project(np.mean(points, axis=0)).point
            for index in reversed(placed[1:]):
                node.RemoveNthControlPoint(index)
            node.SetNthControlPointPositionWorld(placed[0], *middle)


def along(centerline, point, distance):
    """Place (3,) at a distance, mm, along the centerline from a point, down where positive; none beyond its end."""
    place = centerline.project(point)
    if distance > 0:
        return centerline.path_from_proximal(place, distance).points[-1]
    return centerline.path_from_distal(place, -distance).points[0] if distance else place.point


def moveHandle(node, centerline, distance):
    """Move the placed points of a handle along the centerline, in mm, down where positive; none beyond its end."""
    with slicer.util.NodeModify(node):
        for index, point in zip(
            Conversion.placedIndices(node), Conversion.placedPoints(node), strict=True
        ):
            moved = along(centerline, point, distance)
            node.SetNthControlPointPositionWorld(index, *moved)


def snapHandle(node, placement, centerline):
    """Move the placed points of a handle onto the centerline; returns whether one was beside it."""
    points = Conversion.handlePoints(node, placement.pointCount, _("Stent"))
    isMoved = False
    with slicer.util.NodeModify(node):
        for index, point in zip(Conversion.placedIndices(node), points, strict=False):
            snapped = centerline.project(point).point
            if np.linalg.norm(snapped - point) > 1e-6:
                node.SetNthControlPointPositionWorld(index, *snapped)
                isMoved = True
    return isMoved
