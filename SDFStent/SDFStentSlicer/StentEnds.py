"""Dots at both ends of the selected stent, which the mouse drags to change its length, and a tube where the stent will
lie until it is deployed."""

import numpy as np
import slicer
from slicer.i18n import tr as _
from slicer.util import VTKObservationMixin

from . import Clock, Conversion, Showing
from .Dragging import VIEW_ATTRIBUTE
from .Handles import COLOR, POINTS
from .Marks import createMark, createTube, removeMark, showTube
from .ParameterNode import stentOf
from .PlanFields import Placement

SETTLE_MS = 100
"""Time between two updates while a hand drags, or until the first one after a live stent rests, which waits for its
end: to place a stent takes some 15 ms in a tree of 92 outlets."""

GLYPH = 2.0
"""Size of the dots, smaller than the handle's; percent of a view."""

AT_HANDLE = {Placement.PROXIMAL_END: 0, Placement.DISTAL_END: 1}
"""The end of a stent at which its handle is, which moves the whole stent."""


class StentEnds(VTKObservationMixin):
    """Shows where the stent of the shown parameter node lies, and lets the user drag its ends."""

    def __init__(self, logic, isAwaited=lambda: False, letGo=lambda: None):
        """`isAwaited()` tells whether the deployed stent is shown in a moment: then what rests is shown with it, in one frame.
        `letGo()` is called when the mouse lets an end go."""
        VTKObservationMixin.__init__(self)
        self._logic, self._node, self._isFollowing = logic, None, False
        self._isAwaited, self._letGo, self._tube = isAwaited, letGo, None
        self._parameterNode = self._standing = None
        self._timer = Clock.timer(self._onRested, SETTLE_MS)

    @property
    def isBusy(self):
        """Whether the dots are about to be shown."""
        return self._timer.isActive()

    def show(self, parameterNode):
        """Show the stent that is selected now. A stent deployed live is seen itself; its tube and dots appear once it
        rests."""
        standing = self._standingOf(parameterNode)
        if standing == self._standing:
            if self._timer.isActive() and self._logic.showsEnd(parameterNode):
                self._update()
            return
        self._parameterNode, self._standing = parameterNode, standing
        if not parameterNode.autoUpdate:
            if not self._timer.isActive():
                self._timer.start()
            return
        with Showing.inOneFrame():
            removeMark(self._tube)
            if not self._isDragged and self._isThere:
                self._node.SetDisplayVisibility(False)
        self._timer.start()

    @property
    def _isThere(self):
        return self._node is not None and self._node.GetScene() is not None

    @property
    def _isDragged(self):
        """Whether the mouse has one of the dots."""
        return self._isThere and bool(self._node.GetAttribute(VIEW_ATTRIBUTE))

    def leave(self):
        """Remove dots and tube, as no stent is shown any more."""
        self._timer.stop()
        self._parameterNode = self._standing = None
        removeMark(self._tube)
        self._remove()

    def _standingOf(self, parameterNode):
        """Values on which the ends of the stent depend."""
        stent = stentOf(parameterNode)
        return (
            parameterNode.parameterNode.GetID(),
            parameterNode.selected,
            stent.draft.text,
            Conversion.changeStamp(stent.handle),
            Conversion.inputStamp(parameterNode),
            self._logic.knowsCenterline(parameterNode),
            self._logic.showsPlan(parameterNode),
        )

    def _onRested(self):
        if self._parameterNode.autoUpdate and self._isAwaited():
            self._timer.start()
        else:
            self._update()

    def _update(self, isReleased=False):
        self._timer.stop()
        with Showing.inOneFrame():
            self._showTube()
            if isReleased or not self._isDragged:
                self._showDots()

    def _showDots(self):
        ends = self._logic.stentEnds(self._parameterNode)
        if ends is None:
            self._remove()
            return
        if not self._isThere:
            self._create(ends)
        handle = AT_HANDLE.get(self._parameterNode.stent.placement)
        self._isFollowing = True
        with slicer.util.NodeModify(self._node):
            for index, point in enumerate(ends):
                self._node.SetNthControlPointPositionWorld(index, *point)
                self._node.SetNthControlPointVisibility(index, index != handle)
        self._isFollowing = False
        self._node.SetDisplayVisibility(True)
        self._logic.leadEnds(self._parameterNode, self._node)

    def _showTube(self):
        lying = self._logic.stentLying(self._parameterNode)
        if lying is None or self._logic.showsPlan(self._parameterNode):
            removeMark(self._tube)
            return
        if self._tube is None or self._tube.GetScene() is None:
            self._tube = createTube(_("Planned stent"))
        showTube(self._tube, lying.axis, lying.stent.widest_diameter / 2)

    def _create(self, ends):
        self._node = createMark(POINTS, _("Ends of the stent"), ends)
        display = self._node.GetDisplayNode()
        display.SetColor(*COLOR)
        display.SetSelectedColor(*COLOR)
        display.SetGlyphTypeFromString("Circle2D")
        display.SetGlyphScale(GLYPH)
        display.SetSnapMode(display.SnapModeUnconstrained)
        self.addObserver(self._node, self._node.PointModifiedEvent, self._onMoved)
        self.addObserver(self._node, self._node.PointEndInteractionEvent, self._onReleased)

    def _remove(self):
        self.removeObservers()
        removeMark(self._node)
        self._node = None

    def _onMoved(self, caller=None, event=None):
        if self._isFollowing or self._parameterNode is None:
            return
        self._isFollowing = True
        try:
            self._logic.leadEnds(self._parameterNode, self._node)
            points = [self._node.GetNthControlPointPositionWorld(index) for index in range(2)]
            self._logic.stretchStent(self._parameterNode, np.array(points))
        finally:
            self._isFollowing = False

    def _onReleased(self, caller=None, event=None):
        if self._parameterNode is not None:
            self._update(isReleased=True)
            self._letGo()
