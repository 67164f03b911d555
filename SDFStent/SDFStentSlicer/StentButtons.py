"""Buttons of the section Stents, and points that the user places by clicking into a view."""

from typing import Any, NamedTuple

from slicer.i18n import tr as _
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_INT

from . import Clock, Conversion
from .Desktop import desktop
from .Dragging import VIEW_ATTRIBUTE, rayThrough
from .Handles import CURVE
from .ParameterNode import stentOf, stentsOf
from .PlanFields import Placement
from .Portions import SteppedRun, working


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
        # Everywhere: the mouse is in a view meanwhile.
        self._escape = desktop().onKey("Esc", widget, self._giveUp, isEverywhere=True)
        self._escape.setEnabled(False)
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
        """Give the place of a surplus point to the one that it is meant for; returns the index of that one."""
        node, placed = self._node, Conversion.placedIndices(self._node)
        if not 0 < needed <= placed.index(index):
            return index
        point, meant = node.GetNthControlPointPositionWorld(index), placed[self._placed % needed]
        node.RemoveNthControlPoint(index)
        node.SetNthControlPointPositionWorld(meant, *point)
        return meant


def endsNeeded(node, former):
    """Number of points that a markups needs whose first and last one are wanted."""
    return 0 if node.IsA(CURVE) or former > 2 else 2


FINE_STEP = 0.2
"""The length by which an arrow key moves a stent along the centerline while Shift is held, mm; else by one."""


class StentButtons:
    """A part of `SDFStentWidget`: adds, copies, removes, moves and sizes stents, and loads and saves their plan."""

    def _connectStents(self):
        self._fitTimer = Clock.timer(self._fitHandle, 0)
        self._suggesting = SteppedRun(lambda _value: None, self._suggested)
        self.ui.addStentButton.connect("clicked()", self.onAddStent)
        self.ui.suggestButton.connect("clicked()", self.onSuggest)
        self.ui.copyStentButton.connect("clicked()", self.onCopyStent)
        self.ui.removeStentButton.connect("clicked()", self.onRemoveStent)
        keys = {"Del": lambda: self.ui.removeStentButton.click()}
        for key, direction in (("Left", -1.0), ("Right", 1.0)):
            keys[key] = lambda way=direction: self._moveStent(way)
            keys[f"Shift+{key}"] = lambda way=FINE_STEP * direction: self._moveStent(way)
        for key, action in keys.items():
            desktop().onKey(key, self.ui.stentTable, action)
        for button, way in ((self.ui.moveUpButton, -1), (self.ui.moveDownButton, 1)):
            button.connect("clicked()", lambda way=way: self._step(lambda: self.stents.move(way)))
        self.ui.zoomButton.connect("clicked()", lambda: self.logic.showStent(self._parameterNode))
        self.ui.loadPlanButton.connect("clicked()", self.onLoadPlan)
        self.ui.savePlanButton.connect("clicked()", self.onSavePlan)
        self.ui.placementComboBox.connect("activated(int)", self.onPlacementActivated)
        self._placings = [
            Placing(self.ui.placeWidget, self._neededPoints, self._onPlaced),
            Placing(self.ui.segmentPlaceWidget, endsNeeded, lambda *_: None),
        ]

    def onHandleMoved(self, handle):
        if self._parameterNode is not None:
            self.logic.leadHandle(self._parameterNode, handle)

    def onHandleGrabbed(self, handle):
        """Edit the stent that the mouse takes; keys move it on, and remove it, not the point in the view."""
        handles = [stent.handle for stent in stentsOf(self._parameterNode)]
        if handle in handles and handle is not handles[self._parameterNode.selected]:
            self.stents.select(handles.index(handle))
        if handle in handles:
            self._attempt(lambda: self.logic.freePlace(self._parameterNode))
        self.ui.stentTable.setFocus()

    def onHandleReleased(self, handle):
        if self._parameterNode is not None:
            self._attempt(lambda: self.logic.snapHandle(self._parameterNode, handle))
            self.session.letGo()

    def _onSelectStent(self, row):
        self.stents.select(row)

    def _onEnableStent(self, row, enabled):
        self.stents.enable(row, enabled)

    def _moveStent(self, distance):
        if len(self.stents):
            self._attempt(lambda: self.logic.moveStent(self._parameterNode, distance))

    def _step(self, action):
        """Do what a button asks for as a step of its own, to be taken back."""
        self.sections[0].keep()
        self._attempt(action)

    def onAddStent(self):
        lesion = self.lesions.selected
        if lesion is None:
            self._step(lambda: self.logic.addStent(self._parameterNode))
            self._letDraw()
        else:
            self._step(lambda: self.logic.addStentAt(self._parameterNode, lesion))
            self.lesions.clearSelection()

    def _letDraw(self):
        """Let the next clicks draw the axis of a new stent, where it has no other place."""
        if len(self.stents) and self._parameterNode.centerline is None:
            self.ui.placeWidget.placeModeEnabled = True

    def onSuggest(self):
        lesion = self.lesions.selected
        if lesion is None or self._suggesting.isRunning:
            return
        self.sections[0].keep()
        portions = self.logic.suggestionInPortions(self._parameterNode, lesion)
        self._parameterNode.status = _("Sizing a stent for the lesion...")
        self._state.enable(self._parameterNode)
        self._suggesting.start(working(portions))

    def _suggested(self, error):
        if error is not None:
            self._showError(error)
        else:
            self.lesions.hideLine()

    def onCopyStent(self):
        self._step(lambda: self.logic.copyStent(self._parameterNode))

    def onRemoveStent(self):
        if len(self.stents) == 1:
            self.onCancel()  # else what it comes to would be shown of a stent that is gone
        self._step(lambda: self.logic.removeStent(self._parameterNode))

    def onPlacementActivated(self, index):
        # The parameter hears of the new index after this slot, so the handle is fitted a moment later.
        self._fitTimer.start()

    def _fitHandle(self):
        if self._parameterNode is not None and len(self.stents):
            self._attempt(lambda: self.logic.fitHandle(self._parameterNode))

    def _neededPoints(self, _handle, _former):
        placement = stentOf(self._parameterNode).placement
        return 0 if placement == Placement.ALONG_CURVE else placement.pointCount

    def _onPlaced(self, handle, index, ray):
        self._attempt(lambda: self.logic.takePlaced(self._parameterNode, handle, index, ray))

    def onLoadPlan(self):
        path = desktop().openFile(self.parent, _("Load plan"), _("Plan (*.json)"))
        if path:
            self._attempt(lambda: self.logic.loadPlan(path, self._parameterNode))

    def onSavePlan(self):
        kinds = _("Plan (*.json)")
        path = desktop().saveFile(self.parent, _("Save plan"), "plan.json", kinds)
        if path:
            self._attempt(lambda: self.logic.savePlan(path, self._parameterNode))
