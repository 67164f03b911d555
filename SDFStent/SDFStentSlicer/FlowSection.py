"""Section Flow of the panel: inlets, and the flow at each. All else in it is bound to parameters."""

from slicer.i18n import tr as _

from . import Flow


class FlowSection:
    """Shows one end of the vessel at a time, whether it is an inlet and its flow, and sets what the user changes.

    `attempt(action)` does what is asked for and says why when it cannot be done.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode, self._updating = None, False
        self._ends, self._at = [], 0
        ui.flowCollapsibleButton.connect("contentsCollapsed(bool)", self._onOpened)
        ui.inletComboBox.connect("activated(int)", self._onChosen)
        ui.inletCheckBox.connect("toggled(bool)", lambda isIn: self._set(0.0 if isIn else None))
        ui.inletFlowSpinBox.connect("valueChanged(double)", self._set)
        ui.installSolverButton.connect("clicked()", lambda: attempt(self._onInstall))

    def show(self, parameterNode):
        """Show the flow of a parameter node; do nothing while the section is closed."""
        if parameterNode is not self._parameterNode:
            self._parameterNode, self._at = parameterNode, 0
        self._enable(parameterNode)
        if self.ui.flowCollapsibleButton.collapsed:
            return
        flows = Flow.flowsIn(parameterNode)
        self._ends = self._endsWith(flows)
        self._at = min(self._at, max(len(self._ends) - 1, 0))
        texts = [self._textOf(names, flows) for names in self._ends]
        own = Flow.inletOf(parameterNode, self._ends[self._at]) if self._ends else None
        isKnown = parameterNode.flowMean > 0 and len(self._ends) > 0
        self._updating = True
        try:
            box = self.ui.inletComboBox
            if texts != [box.itemText(index) for index in range(box.count)]:
                box.clear()
                for text in texts:
                    box.addItem(text)
            box.currentIndex = self._at if texts else -1
            self.ui.inletCheckBox.checked = own is not None
            self.ui.inletFlowSpinBox.value = flows.get(own, 0.0)
        finally:
            self._updating = False
        box.enabled = self.ui.inletCheckBox.enabled = isKnown
        self.ui.inletFlowSpinBox.enabled = isKnown and own is not None

    def _endsWith(self, flows):
        """The names of every end of the vessel, and of inlets of a plan that are none of them."""
        ends = []
        if self._parameterNode.flowMean > 0:
            ends = list(self._logic.endNames(self._parameterNode))
        known = {Flow.inletOf(self._parameterNode, names) for names in ends}
        return ends + [(name,) for name in flows if name not in known]

    def _textOf(self, names, flows):
        own = Flow.inletOf(self._parameterNode, names)
        if own is None:
            return names[0]
        return _("{name}: {flow:g} L/min").format(name=own, flow=round(flows[own], 2))

    def _enable(self, parameterNode):
        hasFlow, hasPressure = parameterNode.flowMean > 0, parameterNode.inletPressure > 0
        for name in ("flowPeak", "splitRight", "inletPressure", "bodySurface"):
            getattr(self.ui, f"{name}SpinBox").enabled = hasFlow
        self.ui.wedgePressureSpinBox.enabled = hasFlow and hasPressure
        self.ui.installSolverButton.visible = Flow.lacksSolver(parameterNode)

    def _onInstall(self):
        self._logic.installSolver(self._parameterNode)
        self._parameterNode.status = _("Installed svzerod for the wave.")

    def _onOpened(self, isClosed):
        if not isClosed and self._parameterNode is not None:
            self.show(self._parameterNode)

    def _onChosen(self, index):
        self._at = index
        self.show(self._parameterNode)

    def _set(self, flow):
        if not self._updating and self._parameterNode is not None:
            names = self._ends[self._at]
            self._attempt(lambda: self._logic.setInlet(self._parameterNode, names, flow))
            self.show(self._parameterNode)  # what was refused is shown as it is
