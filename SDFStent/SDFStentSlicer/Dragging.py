"""Handles that go along the vessel while the mouse moves them."""

from typing import NamedTuple

import numpy as np
import slicer

from SDFStentLib.geometry import distances_to_segments

from . import Conversion

VIEW_ATTRIBUTE = slicer.vtkMRMLMarkupsDisplayNode.GetMovingInSliceViewAttributeName()
INDEX_ATTRIBUTE = slicer.vtkMRMLMarkupsDisplayNode.GetMovingMarkupIndexAttributeName()
"""Attributes of a markups node: the layout name of the view in which the mouse moves one of its points, 3D views as well, and which."""

DETOUR = 0.1
"""By so much of the way along the tree a place counts as farther from the mouse: what only crosses the vessel is not meant."""

NEAREST = 1e-3
"""Of the depth of the point that is dragged: what lies nearer to the camera, or behind it, counts as there."""


class Ray(NamedTuple):
    """A line of sight, from the eye: `origin` (3,) in mm and `direction` (3,) of length 1."""

    origin: np.ndarray
    direction: np.ndarray


class Dragging:
    """Brings points of handles that the mouse moves onto the centerline, to the place that is seen nearest to the mouse."""

    def __init__(self):
        self._places, self._views = {}, {}

    def follow(self, handle, centerline):
        """Bring what the mouse has moved of a handle onto the centerline; what moves without it stays where it is.

        Has to hear of every change of a handle, before the first one as well.
        """
        key, view = handle.GetID(), handle.GetAttribute(VIEW_ATTRIBUTE)
        known, placedIn = self._places.get(key, {}), self._views.pop(key, None)
        if view and handle.GetNumberOfControlPoints() > handle.GetNumberOfDefinedControlPoints():
            self._views[key] = view  # of a point under the mouse that may be placed next
        dragged = int(handle.GetAttribute(INDEX_ATTRIBUTE)) if view else None
        for index, point in _placesOf(handle).items():
            former = known.get(index)
            isMoved = former != point and (placedIn if former is None else index == dragged)
            if isMoved and centerline is not None:
                place = nearestPlace(centerline, point, _cameraOf(view or placedIn), former)
                handle.SetNthControlPointPositionWorld(index, *place)
        self._places[key] = _placesOf(handle)


def _placesOf(handle):
    return dict(zip(Conversion.placedIndices(handle), Conversion.placedPoints(handle), strict=True))


def nearestPlace(centerline, point, camera=None, former=None):
    """The place (3,) of a centerline that a `vtkCamera` sees nearest to a point, or without one the nearest in space.

    A place farther from the `former` one, along the tree, counts as farther from the point by `DETOUR` of the way.
    """
    below = np.flatnonzero(centerline.parent >= 0)
    above = centerline.parent[below]
    seen = _seen(np.vstack([centerline.points, point]), camera)
    squares, fractions = distances_to_segments(seen[-1], seen[above], seen[below])
    cost = np.sqrt(squares)
    if former is not None:
        ways = _ways(centerline, former)
        cost += DETOUR * ((1.0 - fractions) * ways[above] + fractions * ways[below])
    best = np.argmin(cost)
    weight = fractions[best]
    return (1.0 - weight) * centerline.points[above[best]] + weight * centerline.points[below[best]]


def _seen(points, camera):
    """Points (n, 3) as a camera sees them, in mm at the depth of the last one; as they are without a camera."""
    if camera is None:
        return points
    matrix = camera.GetViewTransformMatrix()
    rows = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(3)])
    seen = points @ rows[:, :3].T + rows[:, 3]
    if not camera.GetParallelProjection():
        depth = -seen[:, 2:]
        seen *= depth[-1] / np.maximum(depth, NEAREST * depth[-1])
    seen[:, 2] = 0.0
    return seen


def _ways(centerline, point):
    """How far every point of a tree (n,) is from a place, along the tree."""
    place = centerline.project(point)
    at, chain = centerline.arc_length, centerline.ancestry(place.index)
    # Where the ways part: on the chain to the place, or where the next point above that is on it.
    parting = np.where(centerline.parent < 0, np.arange(len(at)), centerline.parent)
    parting[chain] = chain
    # Ends: every round doubles the steps upwards, to the chain or to a root.
    while (parting[parting] != parting).any():
        parting = parting[parting]
    return place.arc_length + at - 2 * np.minimum(at[parting], place.arc_length)


def _cameraOf(view):
    """The camera of a view by its layout name; None for a slice view."""
    cameras = slicer.util.getNodesByClass("vtkMRMLCameraNode")
    node = next((camera for camera in cameras if camera.GetLayoutName() == view), None)
    return None if node is None else node.GetCamera()


def rayThrough(view, point):
    """The `Ray` on which a view, by its layout name, shows a point; None in a slice view."""
    camera = _cameraOf(view)
    if camera is None:
        return None
    eye, point = np.array(camera.GetPosition()), np.array(point)
    if camera.GetParallelProjection():
        direction = np.array(camera.GetDirectionOfProjection())
        eye = point - ((point - eye) @ direction) * direction
    direction = point - eye
    return Ray(eye, direction / np.linalg.norm(direction))
