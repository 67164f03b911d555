"""What the buttons of the section Stents do."""

import qt
from slicer.i18n import tr as _

from . import Clock


class StentButtons:
    """A part of `SDFStentWidget`: adds, copies, removes, moves and sizes stents, and loads and saves their plan."""

    def _connectStents(self):
        self._fitTimer = Clock.timer(self._fitHandle, 0)
        self.ui.addStentButton.connect("clicked()", self.onAddStent)
        self.ui.suggestButton.connect("clicked()", self.onSuggest)
        self.ui.copyStentButton.connect("clicked()", self.onCopyStent)
        self.ui.removeStentButton.connect(
            "clicked()", lambda: self.logic.removeStent(self._parameterNode)
        )
        delete = qt.QShortcut(qt.QKeySequence(qt.Qt.Key_Delete), self.ui.stentTable)
        delete.setContext(qt.Qt.WidgetWithChildrenShortcut)
        delete.connect("activated()", lambda: self.ui.removeStentButton.click())
        self.ui.moveUpButton.connect("clicked()", lambda: self.stents.move(-1))
        self.ui.moveDownButton.connect("clicked()", lambda: self.stents.move(1))
        self.ui.loadPlanButton.connect("clicked()", self.onLoadPlan)
        self.ui.savePlanButton.connect("clicked()", self.onSavePlan)
        self.ui.placementComboBox.connect("activated(int)", self.onPlacementActivated)

    def onAddStent(self):
        lesion = self.lesions.selected
        if lesion is None:
            self._attempt(lambda: self.logic.addStent(self._parameterNode))
        else:
            self._attempt(lambda: self.logic.addStentAt(self._parameterNode, lesion))
            self.lesions.clearSelection()

    def onSuggest(self):
        lesion = self.lesions.selected
        if lesion is not None:
            self._attempt(lambda: self.logic.suggestStent(self._parameterNode, lesion))

    def onCopyStent(self):
        self._attempt(lambda: self.logic.copyStent(self._parameterNode))

    def onPlacementActivated(self, index):
        # The parameter hears of the new index after this slot, so the handle is fitted a moment later.
        self._fitTimer.start()

    def _fitHandle(self):
        if self._parameterNode is not None and len(self.stents):
            self._attempt(lambda: self.logic.fitHandle(self._parameterNode))

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
