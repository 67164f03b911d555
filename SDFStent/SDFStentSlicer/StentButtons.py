"""What the buttons of the section Stents do."""

import qt
from slicer.i18n import tr as _

from . import Clock
from .ParameterNode import Placement, stentOf
from .Placing import Placing, endsNeeded

FINE_STEP = 0.2
"""By which an arrow key moves a stent along the centerline while Shift is held, mm; else by one."""


class StentButtons:
    """A part of `SDFStentWidget`: adds, copies, removes, moves and sizes stents, and loads and saves their plan."""

    def _connectStents(self):
        self._fitTimer = Clock.timer(self._fitHandle, 0)
        self.ui.addStentButton.connect("clicked()", self.onAddStent)
        self.ui.suggestButton.connect("clicked()", self.onSuggest)
        self.ui.copyStentButton.connect("clicked()", self.onCopyStent)
        self.ui.removeStentButton.connect("clicked()", self.onRemoveStent)
        self._onKey("Del", lambda: self.ui.removeStentButton.click())
        for key, direction in (("Left", -1.0), ("Right", 1.0)):
            self._onKey(key, lambda way=direction: self._moveStent(way))
            self._onKey(f"Shift+{key}", lambda way=direction: self._moveStent(FINE_STEP * way))
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

    def _onKey(self, key, action):
        """Do something at a key while the table of the stents has the focus."""
        shortcut = qt.QShortcut(qt.QKeySequence(key), self.ui.stentTable)
        shortcut.setContext(qt.Qt.WidgetWithChildrenShortcut)
        shortcut.connect("activated()", action)

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
        else:
            self._step(lambda: self.logic.addStentAt(self._parameterNode, lesion))
            self.lesions.clearSelection()

    def onSuggest(self):
        lesion = self.lesions.selected
        if lesion is not None:
            self._step(lambda: self.logic.suggestStent(self._parameterNode, lesion))

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
        path = qt.QFileDialog.getOpenFileName(self.parent, _("Load plan"), "", _("Plan (*.json)"))
        if path:
            self._attempt(lambda: self.logic.loadPlan(path, self._parameterNode))

    def onSavePlan(self):
        path = qt.QFileDialog.getSaveFileName(
            self.parent, _("Save plan"), "plan.json", _("Plan (*.json)")
        )
        if path:
            self._attempt(lambda: self.logic.savePlan(path, self._parameterNode))
