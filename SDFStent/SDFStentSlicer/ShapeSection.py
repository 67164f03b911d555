"""The section Shape of the panel: profile and caps of the selected stent. Waist and ends are bound to the plan."""

from slicer.i18n import tr as _

from SDFStentLib.plan import read_profile
from SDFStentLib.stent import Shape

from . import Sizes
from .Desktop import desktop
from .ParameterNode import stentOf

FLAT = 0.35
"""Height of the caps called flat, relative to their radius."""


class ShapeSection:
    """Shows the shape of the selected stent in `ui` and sets what the user changes.

    `attempt(action)` carries out an action, and says why if it fails.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode, self._updating, self._shown = None, False, None
        for text in (_("Round"), _("Flat")):
            ui.capsComboBox.addItem(text)
        ui.capsComboBox.connect("activated(int)", self._onCaps)
        ui.loadProfileButton.connect("clicked()", self._onLoad)
        ui.removeProfileButton.connect("clicked()", lambda: self._set({"table": ()}))

    def show(self, parameterNode):
        """Show the shape of the stent that is selected now."""
        self._parameterNode = parameterNode
        stent = stentOf(parameterNode)
        if (stent.shape, stent.diameter) == self._shown:
            return
        self._shown = stent.shape, stent.diameter
        shape, ui = Sizes.shapeOf(stent) or Shape(), self.ui
        ui.waistPositionSpinBox.enabled = ui.waistLengthSpinBox.enabled = shape.waist is not None
        ui.proximalEndLengthSpinBox.enabled = shape.start is not None
        ui.distalEndLengthSpinBox.enabled = shape.end is not None
        self._updating = True
        try:
            self._showCaps(shape.cap_height)
            self._showTable(shape.table)
        finally:
            self._updating = False

    def _showCaps(self, height):
        box = self.ui.capsComboBox
        if box.count > 2:  # the height of another plan's caps
            box.removeItem(2)
        if height not in (1.0, FLAT):
            box.addItem(_("{height:g} of the radius high").format(height=height))
        box.currentIndex = {1.0: 0, FLAT: 1}.get(height, 2)

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

    def _set(self, parts):
        if not self._updating and self._parameterNode is not None:
            self._attempt(lambda: self._logic.changeShape(self._parameterNode, **parts))

    def _onCaps(self, index):
        if index < 2:
            self._set({"cap_height": (1.0, FLAT)[index]})

    def _onLoad(self):
        kinds = _("Rows of fraction,diameter (*.csv)")
        path = desktop().openFile(self.ui.loadProfileButton, _("Profile"), kinds)
        if path:
            none = {"waist": None, "start": None, "end": None}
            self._attempt(
                lambda: self._logic.changeShape(
                    self._parameterNode, **none, table=read_profile(path)
                )
            )
