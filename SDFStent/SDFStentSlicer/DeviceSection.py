"""Section Device of the panel: the device of the selected stent, and its known sizes. All else in it is bound to the plan."""

from slicer.i18n import tr as _

from SDFStentLib.plan import device_table, value_in_use
from SDFStentLib.report import balloon_sentences, device_sentences, ratio_sentence
from SDFStentLib.validation import InputError, printable

from .Desktop import desktop
from .ParameterNode import stentOf
from .PlanFields import Placement


class DeviceSection:
    """Shows the details of the selected stent in `ui` and sets what the user changes.

    `attempt(action)` does what is asked for and says why when it cannot be done.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode, self._updating, self._shown = None, False, None
        self._table, self._rows = None, ()
        ui.deviceCollapsibleButton.connect("contentsCollapsed(bool)", self._onOpened)
        ui.deviceComboBox.connect("activated(int)", self._onDevice)
        ui.deviceTableButton.connect("clicked()", self._onTable)
        ui.removeTableButton.connect("clicked()", self._onRemoveTable)

    def show(self, parameterNode):
        """Show the selected stent of a parameter node."""
        self._parameterNode = parameterNode
        stent = stentOf(parameterNode)
        if not self.ui.deviceCollapsibleButton.collapsed:
            self._tell(stent)
        values = stent.draft.text, parameterNode.deviceTable
        if values == self._shown:
            return
        self._shown = values
        self._updating = True
        try:
            self._showDevice(stent.draft.device)
        finally:
            self._updating = False
        isUsed, isByRule = (
            value_in_use(stent.draft, name) for name in ("balloon", "balloon.by_rule")
        )
        self.ui.balloonSlider.enabled = self.ui.recoilRuleCheckBox.enabled = isUsed
        self.ui.recoilSpinBox.enabled = isUsed and not isByRule

    def _showDevice(self, device):
        box, table = self.ui.deviceComboBox, self._parameterNode.deviceTable
        if table != self._table:
            self._table, self._rows = table, self._read(table)
        names = [row.name for row in self._rows]
        if device is not None and device.name not in names:
            names.append(device.name)  # of a plan, or of a table that is gone
        if names != [box.itemText(index) for index in range(box.count)]:
            box.clear()
            for name in names:
                box.addItem(name)
        box.currentIndex = 0 if device is None else names.index(device.name)
        isAgain = self._parameterNode.stent.placement == Placement.AGAIN
        self.ui.deviceShorteningCheckBox.enabled = isAgain or device is not None

    def _read(self, table):
        """The rows of the device table, and in the button's tooltip where those of the user's own are from."""
        tip, rows = table or _("Add the devices of a table of your own (.json)."), ()
        try:
            rows = self._logic.devices(self._parameterNode)
        except InputError as error:  # of a table that is gone since the scene was saved
            tip, rows = str(error), device_table()
        self.ui.deviceTableButton.toolTip = tip
        self.ui.removeTableButton.enabled = bool(table)
        return rows

    def _tell(self, stent):
        """Show the sentences on device and balloon, in the words of the report."""
        try:
            planned = stent.draft.unplaced
        except InputError:
            sentences = []  # the line below Deploy says why
        else:
            sentences = [*device_sentences(planned), *self._compared(planned)]
        self.ui.deviceLabel.text = printable("\n".join(sentences))
        self.ui.deviceLabel.visible = bool(sentences)

    def _compared(self, planned):
        """Balloon, lumen and vessel, and how they compare where the stent covers a lesion."""
        known = self._logic.ratios(self._parameterNode)
        if known is None:
            return balloon_sentences(planned, None)
        lesion, ratios = known
        cautions = [caution.sentence() for caution in ratios.cautions()]
        diameters = balloon_sentences(planned, lesion.reference_diameter)
        return [*diameters, ratio_sentence(ratios), *cautions]

    def _change(self, action):
        if not self._updating and self._parameterNode is not None:
            self._attempt(lambda: action(self._parameterNode))

    def _onOpened(self, isClosed):
        if not isClosed and self._parameterNode is not None:
            self._tell(self._parameterNode.stent)

    def _onDevice(self, index):
        if index < len(self._rows):  # behind them is that of a plan, which the stent has already
            self._change(lambda node: self._logic.setDevice(node, self._rows[index]))

    def _onTable(self):
        kinds = _("Device table (*.json)")
        path = desktop().openFile(self.ui.deviceTableButton, _("Device table"), kinds)
        if path:
            self._change(lambda node: self._logic.setDeviceTable(node, path))

    def _onRemoveTable(self):
        self._change(lambda node: self._logic.setDeviceTable(node, ""))
