"""The section Plans of the panel: the alternatives for one vessel, side by side."""

from slicer.i18n import tr as _

from SDFStentLib.report import COMPARED
from SDFStentLib.validation import one_line

from . import Tiles
from .Desktop import desktop
from .PanelParts import FolderButton


class PlanTable:
    """Shows the plans for the vessel in `ui.planTable`, and carries out the buttons below it.

    `attempt(action)` carries out an action, and says why if it fails; `switchTo(parameterNode)` shows another plan.
    """

    def __init__(self, ui, logic, attempt, switchTo):
        self.ui, self._logic, self._attempt, self._switchTo = ui, logic, attempt, switchTo
        self._parameterNode, self._plans, self._shown = None, [], None
        self._updating = False
        self._compared = None
        self.comparing = FolderButton(
            ui.comparePlansButton,
            _("A new folder with the comparison is made in"),
            self._stepsInto,
            attempt,
            self._onCompared,
        )
        desktop().fitColumns(ui.planTable)
        ui.plansCollapsibleButton.connect("contentsCollapsed(bool)", self._onOpened)
        ui.planTable.connect("itemSelectionChanged()", self._onSelected)
        ui.planTable.connect("itemChanged(QTableWidgetItem*)", self._onChanged)
        ui.duplicatePlanButton.connect("clicked()", self._onDuplicate)
        ui.removePlanButton.connect("clicked()", self._onRemove)
        ui.loadPlansButton.connect("clicked()", self._onLoad)

    def show(self, parameterNode):
        """Show the plans for the vessel of a parameter node, with its own selected; does nothing while the section is
        closed."""
        self._parameterNode = parameterNode
        if parameterNode is None:
            self._plans, self._shown = [], None
        if parameterNode is None or self.ui.plansCollapsibleButton.collapsed:
            return
        self._plans = self._logic.alternatives(parameterNode)
        rows = [self._row(plan) for plan in self._plans]
        current = self._plans.index(parameterNode)
        self._enable()
        if self._shown == (rows, current):
            return
        self._shown = (rows, current)
        self._updating = True
        try:
            self.ui.planTable.setRowCount(len(rows))
            for row, texts in enumerate(rows):
                for column, text in enumerate(texts[:-1]):
                    self._fill(row, column, text, texts[-1])
            self.ui.planTable.selectRow(current)
        finally:
            self._updating = False

    def _row(self, plan):
        """The texts of a plan's row, and the tip for all of them."""
        name = one_line(plan.parameterNode.GetName())
        values = {one.name: one.value for one in Tiles.tilesOf(plan)}
        if not values.keys() >= set(COMPARED):
            return (name, *len(COMPARED) * ("",), _("Not deployed yet."))
        isOld = self._logic.hasChanged(plan)
        tip = _("Changed since this deployment.") if isOld else ""
        return (name, *(values[one] for one in COMPARED), tip)

    def _fill(self, row, column, text, tip):
        """Set a cell in place, so that an edit in it goes on."""
        item = self.ui.planTable.item(row, column)
        if item is None:
            item = desktop().cell(isEditable=column == 0)
            self.ui.planTable.setItem(row, column, item)
        item.setText(text)
        item.setToolTip("\n".join(filter(None, (text, tip))))

    def _enable(self):
        hasVessel, isAlone = self._parameterNode.vessel is not None, len(self._plans) < 2
        self.ui.duplicatePlanButton.enabled = self.ui.loadPlansButton.enabled = hasVessel
        self.ui.removePlanButton.enabled = not isAlone
        self.ui.comparePlansButton.enabled = not isAlone or self.comparing.isRunning

    def _onOpened(self, isClosed):
        if not isClosed:
            self.show(self._parameterNode)

    def _onSelected(self):
        row = self.ui.planTable.currentRow()
        if not self._updating and 0 <= row < len(self._plans):
            self._switchTo(self._plans[row])

    def _onChanged(self, item):
        if self._updating or item.column() != 0:
            return
        plan, self._shown = self._plans[item.row()], None  # what is written there is no name yet
        self._attempt(lambda: self._logic.renamePlan(plan, item.text()))
        self.show(self._parameterNode)

    def _onDuplicate(self):
        self._attempt(lambda: self._switchTo(self._logic.duplicatePlan(self._parameterNode)))

    def _onRemove(self):
        plan = self._parameterNode
        row = self._plans.index(plan)
        beside = [*self._plans[row + 1 :], *reversed(self._plans[:row])]
        self._switchTo(beside[0])
        self._logic.removePlan(plan)
        self.show(self._parameterNode)

    def _onLoad(self):
        paths = desktop().openFiles(self.ui.planTable, _("Load plans"), _("Plan (*.json)"))
        if paths:
            self._attempt(
                lambda: self._switchTo(self._logic.loadPlans(list(paths), self._parameterNode))
            )
            self.show(self._parameterNode)

    # Comparing

    def _stepsInto(self, folder):
        self._compared = self._parameterNode
        return self._logic.comparisonSteps(self._parameterNode, folder)

    def _onCompared(self, page):
        if self._compared is self._parameterNode:
            self._parameterNode.status = _("Wrote {path}.").format(path=page)
        desktop().show(page)
