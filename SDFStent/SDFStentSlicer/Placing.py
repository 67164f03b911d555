"""Points that the user places by clicking into a view, in place of those that there are."""

from typing import Any, NamedTuple

import qt
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_INT

from . import Clock, Conversion
from .Dragging import VIEW_ATTRIBUTE, rayThrough
from .Handles import CURVE


class Click(NamedTuple):
    """A point that was placed, by its ID, and the `Ray` on which it was seen; None in a slice view."""

    point: str
    ray: Any


class Placing:
    """Lets a `qSlicerMarkupsPlaceWidget` place as many points as are needed, and ends that then.

    By itself it adds points to a point list that has them all, and stops after the first of two. `needed(node, former)` says how many
    points are wanted of a node that had `former` ones, 0 for as many as the user likes; `onPlaced(node, index, ray)` is called after each.
    """

    def __init__(self, widget, needed, onPlaced):
        self._widget, self._needed, self._onPlaced = widget, needed, onPlaced
        self._node, self._tags, self._view = None, [], ""
        self._clicks, self._placed, self._wasPersistent = [], 0, False
        # The view that has placed a point goes on with it once it has told everybody; there may be more clicks until then.
        self._timer = Clock.timer(self._take, 0)
        self._escape = qt.QShortcut(qt.QKeySequence("Esc"), widget)
        self._escape.setContext(qt.Qt.ApplicationShortcut)  # the mouse is in a view meanwhile
        self._escape.setEnabled(False)
        self._escape.connect("activated()", self._giveUp)
        widget.connect("activeMarkupsPlaceModeChanged(bool)", self._onMode)

    def _giveUp(self):
        self._widget.placeModeEnabled = False

    def _onMode(self, isPlacing):
        widget, node = self._widget, self._widget.currentNode()
        self._escape.setEnabled(isPlacing)
        if isPlacing:
            self._node, self._view, self._clicks, self._placed = node, "", [], 0
            self._tags = [
                node.AddObserver(node.PointModifiedEvent, self._onMoved),
                node.AddObserver(node.PointPositionDefinedEvent, self._onDefined),
            ]
            self._wasPersistent, widget.placeModePersistency = widget.placeModePersistency, True
        elif self._node is not None:
            self._timer.stop()
            for tag in self._tags:
                self._node.RemoveObserver(tag)
            self._node, widget.placeModePersistency = None, self._wasPersistent

    def _onMoved(self, node, _event):
        # Only while the point is under the mouse, no longer when it is placed.
        self._view = node.GetAttribute(VIEW_ATTRIBUTE) or self._view

    @calldata_type(VTK_INT)
    def _onDefined(self, node, _event, index=None):
        if index is None:  # points of a program that adds several at once
            return
        ray = rayThrough(self._view, node.GetNthControlPointPositionWorld(index))
        self._clicks.append(Click(node.GetNthControlPointID(index), ray))
        self._timer.start()

    def _take(self):
        node, clicks, self._clicks = self._node, self._clicks, []
        former = len(Conversion.placedIndices(node)) - len(clicks)
        needed = self._needed(node, former)
        for click in clicks:
            index = self._bring(node.GetNthControlPointIndexByID(click.point), needed)
            self._placed += 1
            self._onPlaced(node, index, click.ray)
        if 0 < needed <= self._placed:
            self._widget.placeModeEnabled = False

    def _bring(self, index, needed):
        """Give the place of a point that is too many to the one that it is meant for; returns the index of that."""
        node, placed = self._node, Conversion.placedIndices(self._node)
        if not 0 < needed <= placed.index(index):
            return index
        point, meant = node.GetNthControlPointPositionWorld(index), placed[self._placed % needed]
        node.RemoveNthControlPoint(index)
        node.SetNthControlPointPositionWorld(meant, *point)
        return meant


def endsNeeded(node, former):
    """How many points a markups needs whose first and last one are wanted."""
    return 0 if node.IsA(CURVE) or former > 2 else 2
