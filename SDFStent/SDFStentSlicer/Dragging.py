"""Handles that move along the vessel while the mouse drags them."""

from typing import NamedTuple

import numpy as np
import slicer

from SDFStentLib.geometry import distances_to_segments

from . import Conversion

VIEW_ATTRIBUTE = slicer.vtkMRMLMarkupsDisplayNode.GetMovingInSliceViewAttributeName()
INDEX_ATTRIBUTE = slicer.vtkMRMLMarkupsDisplayNode.GetMovingMarkupIndexAttributeName()
"""Attributes of a markups node: the layout name of the view, slice or 3D, in which the mouse moves one of its points,
and that point's index."""

DETOUR = 0.1
"""Cost of a path along the tree per mm. A mouse beside the path costs the square of its distance in mm, divided by
`HAND` in mm."""

HAND = 0.008
"""Typical distance of a hand from the path that it follows, relative to the height of the view."""

NEAREST = 1e-3
"""Smallest depth of a point, relative to that of the dragged point: points nearer to the camera or behind it are
treated as if at this depth."""


class Ray(NamedTuple):
    """A line of sight from the eye: `origin` (3,) in mm and `direction` (3,) of length 1."""

    origin: np.ndarray
    direction: np.ndarray


class Dragging:
    """Brings points of handles that the mouse moves onto the centerline, to the place that appears nearest to the
    mouse."""

    def __init__(self):
        self._places, self._views, self._paths = {}, {}, {}

    def follow(self, handle, centerline):
        """Bring a point of a handle that the mouse has moved onto the centerline; a point moved otherwise stays where
        it is.

        It has to be called at every change of a handle, and once before the first one.
        """
        key, view = handle.GetID(), handle.GetAttribute(VIEW_ATTRIBUTE)
        known, placedIn = self._places.get(key, {}), self._views.pop(key, None)
        if view and handle.GetNumberOfControlPoints() > handle.GetNumberOfDefinedControlPoints():
            self._views[key] = view  # the view of a point under the mouse that may be placed next
        dragged = int(handle.GetAttribute(INDEX_ATTRIBUTE)) if view else None
        if not view:
            self._paths.pop(key, None)
        for index, point in _placesOf(handle).items():
            former = known.get(index)
            isMoved = former != point and (placedIn if former is None else index == dragged)
            if isMoved and centerline is not None:
                camera = _cameraOf(view or placedIn)
                if former is None or camera is None:
                    place = nearestPlace(centerline, point, camera)
                else:
                    place = self._path(key, centerline, former).follow(point, camera)
                handle.SetNthControlPointPositionWorld(index, *place)
        self._places[key] = _placesOf(handle)

    def _path(self, key, centerline, former):
        path = self._paths.get(key)
        if path is None or not path.goesOnFrom(centerline, former):
            path = self._paths[key] = Path(centerline, former)
        return path


class Path:
    """The path along a tree, from a place (3,), that has fitted the mouse best so far.

    Where vessels cross in the view, or run one behind the other, one place of the mouse does not determine which of
    them is meant, but all places together do. For each point of the tree the least cost of a path that ends there is
    kept, and updated (Viterbi's algorithm).
    """

    def __init__(self, centerline, place):
        self._centerline, self._place = centerline, np.array(place)
        self._costs = DETOUR * _ways(centerline, place)
        self._below = np.flatnonzero(centerline.parent >= 0)
        self._above = centerline.parent[self._below]
        steps = centerline.points[self._below] - centerline.points[self._above]
        steps = DETOUR * np.linalg.norm(steps, axis=1)
        down = np.argsort(centerline.arc_length[self._below], kind="stable")
        columns = (self._above[down], self._below[down], steps[down])
        self._down = list(zip(*(column.tolist() for column in columns), strict=True))

    def goesOnFrom(self, centerline, place):
        """Whether this path ends at this place, on the same tree."""
        return centerline is self._centerline and np.allclose(self._place, place, atol=1e-4)

    def follow(self, point, camera):
        """The place (3,) at which the path ends now that the mouse of a view is at a point."""
        points, above, below = self._centerline.points, self._above, self._below
        seen = _seen(np.vstack([points, point]), camera)
        squares, fractions = distances_to_segments(seen[-1], seen[above], seen[below])
        nearest = np.full(len(points), np.inf)
        np.minimum.at(nearest, above, squares)
        np.minimum.at(nearest, below, squares)
        self._costs = self._spread() + nearest / (HAND * _height(point, camera))
        end = np.argmin(self._costs)
        self._costs -= self._costs[end]
        best = np.argmin(np.where((above == end) | (below == end), squares, np.inf))
        self._place = _between(self._centerline, above[best], below[best], fractions[best])
        return self._place

    def _spread(self):
        """The least cost of reaching each point after one more step along the tree."""
        costs = self._costs.tolist()
        for above, below, step in reversed(self._down):
            costs[above] = min(costs[above], costs[below] + step)
        for above, below, step in self._down:
            costs[below] = min(costs[below], costs[above] + step)
        return np.array(costs)


def _placesOf(handle):
    return dict(zip(Conversion.placedIndices(handle), Conversion.placedPoints(handle), strict=True))


def nearestPlace(centerline, point, camera=None):
    """The place (3,) of a centerline that a `vtkCamera` sees nearest to a point; without a camera the
    nearest in space."""
    below = np.flatnonzero(centerline.parent >= 0)
    above = centerline.parent[below]
    seen = _seen(np.vstack([centerline.points, point]), camera)
    squares, fractions = distances_to_segments(seen[-1], seen[above], seen[below])
    best = np.argmin(squares)
    return _between(centerline, above[best], below[best], fractions[best])


def _between(centerline, above, below, fraction):
    return (1.0 - fraction) * centerline.points[above] + fraction * centerline.points[below]


def _height(point, camera):
    """The height of the view of a camera at the depth of a point, in mm."""
    if camera.GetParallelProjection():
        return 2.0 * camera.GetParallelScale()
    depth = (np.array(point) - camera.GetPosition()) @ camera.GetDirectionOfProjection()
    return 2.0 * depth * np.tan(np.radians(camera.GetViewAngle()) / 2.0)


def _seen(points, camera):
    """Points (n, 3) as a camera sees them, in mm at the depth of the last one; unchanged without a camera."""
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
    """The distance of every point of a tree (n,) from a place, along the tree."""
    place = centerline.project(point)
    at, chain = centerline.arc_length, centerline.ancestry(place.index)
    # The point where the ways to both part: the point itself if it is on the chain to the place, else the next one
    # above that is.
    parting = np.where(centerline.parent < 0, np.arange(len(at)), centerline.parent)
    parting[chain] = chain
    # Ends, since every round doubles the steps upward, to the chain or to a root.
    while (parting[parting] != parting).any():
        parting = parting[parting]
    return place.arc_length + at - 2 * np.minimum(at[parting], place.arc_length)


def _cameraOf(view):
    """The camera of a view by its layout name; None for a slice view."""
    cameras = slicer.util.getNodesByClass("vtkMRMLCameraNode")
    node = next((camera for camera in cameras if camera.GetLayoutName() == view), None)
    return None if node is None else node.GetCamera()


def rayThrough(view, point):
    """The `Ray` on which a view, given by its layout name, shows a point; None in a slice view."""
    camera = _cameraOf(view)
    if camera is None:
        return None
    eye, point = np.array(camera.GetPosition()), np.array(point)
    if camera.GetParallelProjection():
        direction = np.array(camera.GetDirectionOfProjection())
        eye = point - ((point - eye) @ direction) * direction
    direction = point - eye
    return Ray(eye, direction / np.linalg.norm(direction))
