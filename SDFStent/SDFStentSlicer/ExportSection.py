"""What the panel writes of the last deployment, and the stent mesh of the user's own."""

import qt
from slicer.i18n import tr as _


class ExportSection:
    """The buttons behind `SDFStentLogic.writeDevice`, `write0D` and `loadDeviceMesh`.

    `attempt(action)` does what is asked for and says why when it cannot be done.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode = None
        ui.loadMeshButton.connect("clicked()", self._onLoad)
        ui.saveDeviceButton.connect("clicked()", self._onSave)
        ui.write0DButton.connect("clicked()", self._onWrite0D)

    def show(self, parameterNode):
        """The parameter node that is shown now."""
        self._parameterNode = parameterNode
        isDeployed = self._logic.isDeployed(parameterNode)
        self.ui.saveDeviceButton.enabled = self.ui.write0DButton.enabled = isDeployed

    def _onLoad(self):
        kinds = _("Surface (*.stl *.vtp *.vtk *.ply *.obj)")
        self._ask(qt.QFileDialog.getOpenFileName, _("Stent mesh"), "", kinds, "loadDeviceMesh")

    def _onSave(self):
        asked = qt.QFileDialog.getSaveFileName
        self._ask(asked, _("Save device"), "stents.vtp", _("Device (*.vtp)"), "writeDevice")

    def _onWrite0D(self):
        asked = qt.QFileDialog.getSaveFileName
        self._ask(
            asked, _("Network for a 0D solver"), "network.json", _("Network (*.json)"), "write0D"
        )

    def _ask(self, asked, title, name, kinds, action):
        path = asked(self.ui.saveDeviceButton, title, name, kinds)
        if path:
            self._attempt(lambda: getattr(self._logic, action)(path, self._parameterNode))
