"""The section Shape of the panel: waist, ends, profile and caps of the selected stent."""

from slicer.i18n import tr as _

from SDFStentLib.plan import read_profile
from SDFStentLib.stent import Shape, StentEnd, Waist

from . import Sizes
from .Desktop import desktop
from .ParameterNode import stentOf

FLAT = 0.35
"""Height of the caps called flat, relative to their radius."""

NARROWEST = -1.0
"""Position of a waist in percent that stands for the narrowest place of the vessel in the panel."""


class ShapeSection:
    """Shows the shape of the selected stent in `ui` and sets what the user changes.

    `attempt(action)` carries out an action, and says why if it fails.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode, self._updating, self._shown = None, False, None
        for text in (_("Round"), _("Flat")):
            ui.capsComboBox.addItem(text)
        for box in (
            ui.waistSpinBox,
            ui.waistPositionSpinBox,
            ui.waistLengthSpinBox,
            ui.proximalEndSpinBox,
            ui.proximalEndLengthSpinBox,
            ui.distalEndSpinBox,
            ui.distalEndLengthSpinBox,
        ):
            box.connect("valueChanged(double)", lambda _value: self._set(self._parts()))
        ui.capsComboBox.connect("activated(int)", self._onCaps)
        ui.loadProfileButton.connect("clicked()", self._onLoad)
        ui.removeProfileButton.connect("clicked()", lambda: self._set({"table": ()}))

    def show(self, parameterNode):
        """Show the shape of the stent that is selected now."""
        self._parameterNode = parameterNode
        stent = stentOf(parameterNode)
        if (stent.details, stent.diameter) == self._shown:
            return
        self._shown = stent.details, stent.diameter
        shape = Sizes.shapeOf(stent) or Shape()
        self._updating = True
        try:
            self._showWaist(shape.waist)
            self._showEnd(self.ui.proximalEndSpinBox, self.ui.proximalEndLengthSpinBox, shape.start)
            self._showEnd(self.ui.distalEndSpinBox, self.ui.distalEndLengthSpinBox, shape.end)
            self._showCaps(shape.cap_height)
            self._showTable(shape.table)
        finally:
            self._updating = False

    def _showWaist(self, waist):
        ui = self.ui
        ui.waistPositionSpinBox.enabled = ui.waistLengthSpinBox.enabled = waist is not None
        ui.waistSpinBox.value = 0.0 if waist is None else waist.diameter
        if waist is not None:
            isKnown = waist.position is not None
            ui.waistPositionSpinBox.value = 100 * waist.position if isKnown else NARROWEST
            ui.waistLengthSpinBox.value = waist.length or 0.0

    @staticmethod
    def _showEnd(diameterBox, lengthBox, end):
        lengthBox.enabled = end is not None
        diameterBox.value = 0.0 if end is None else end.diameter
        if end is not None:
            lengthBox.value = end.length

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

    def _parts(self):
        """The parts of the shape that the boxes show."""
        ui = self.ui
        return {
            "waist": self._waist(),
            "start": _end(ui.proximalEndSpinBox.value, ui.proximalEndLengthSpinBox.value),
            "end": _end(ui.distalEndSpinBox.value, ui.distalEndLengthSpinBox.value),
        }

    def _waist(self):
        diameter, position = self.ui.waistSpinBox.value, self.ui.waistPositionSpinBox.value
        if diameter == 0:
            return None
        length = self.ui.waistLengthSpinBox.value
        return Waist(diameter, None if position < 0 else position / 100, length or None)

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


def _end(diameter, length):
    return StentEnd(diameter, length) if diameter > 0 else None
