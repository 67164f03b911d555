"""The section Shape of the panel: the profile of the selected stent. All else in it is bound to the plan."""

from slicer.i18n import tr as _

from SDFStentLib.plan import read_profile

from .Desktop import desktop
from .ParameterNode import stentOf

TABLE = "stents.selected.shape.table"


class ShapeSection:
    """Shows the shape of the selected stent in `ui` and sets what the user changes.

    `attempt(action)` carries out an action, and says why if it fails.
    """

    def __init__(self, ui, _logic, attempt):
        self.ui, self._attempt = ui, attempt
        self._parameterNode = self._shown = None
        ui.loadProfileButton.connect("clicked()", self._onLoad)
        ui.removeProfileButton.connect("clicked()", lambda: self._set(()))

    def show(self, parameterNode):
        """Show the shape of the stent that is selected now."""
        self._parameterNode = parameterNode
        stent = stentOf(parameterNode)
        if stent.draft.text == self._shown:
            return
        self._shown = stent.draft.text
        shape, ui = stent.draft.shape, self.ui
        ui.waistPositionSpinBox.enabled = ui.waistLengthSpinBox.enabled = bool(
            shape and shape.waist
        )
        ui.proximalEndLengthSpinBox.enabled = bool(shape and shape.start)
        ui.distalEndLengthSpinBox.enabled = bool(shape and shape.end)
        self._showTable(shape.table if shape else ())

    def _showTable(self, table):
        ui, hasTable = self.ui, len(table) > 0
        for box in (ui.waistSpinBox, ui.proximalEndSpinBox, ui.distalEndSpinBox):
            box.enabled = not hasTable
        ui.removeProfileButton.enabled = hasTable
        diameters = [row[1] for row in table] or [0.0]
        text = _("{count} rows, {low:.1f} to {high:.1f} mm")
        ui.profileLabel.text = (
            text.format(count=len(table), low=min(diameters), high=max(diameters))
            if hasTable
            else _("none")
        )

    def _set(self, rows):
        if self._parameterNode is not None:
            self._attempt(lambda: self._parameterNode.put(TABLE, rows))

    def _onLoad(self):
        kinds = _("Rows of fraction,diameter (*.csv)")
        path = desktop().openFile(self.ui.loadProfileButton, _("Profile"), kinds)
        if path:
            self._attempt(lambda: self._set(read_profile(path)))
