"""Sections of the panel that write: files of the last deployment, and a segment of the vessel for a flow solver."""

from slicer.i18n import tr as _

from SDFStentLib.surface_formats import READ_SUFFIXES

from .Desktop import desktop
from .PanelParts import FolderButton


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
        """Show a parameter node."""
        self._parameterNode = parameterNode
        isDeployed = self._logic.isDeployed(parameterNode)
        self.ui.saveDeviceButton.enabled = self.ui.write0DButton.enabled = isDeployed

    def _onLoad(self):
        kinds = _("Surface") + f" ({' '.join('*' + suffix for suffix in READ_SUFFIXES)})"
        path = desktop().openFile(self.ui.loadMeshButton, _("Stent mesh"), kinds)
        self._do("loadDeviceMesh", path)

    def _onSave(self):
        self._save("writeDevice", _("Save device"), "stents.vtp", _("Device (*.vtp)"))

    def _onWrite0D(self):
        title, kinds = _("Network for a 0D solver"), _("Network (*.json)")
        self._save("write0D", title, "network.json", kinds)

    def _save(self, action, title, name, kinds):
        self._do(action, desktop().saveFile(self.ui.saveDeviceButton, title, name, kinds))

    def _do(self, action, path):
        if path:
            self._attempt(lambda: getattr(self._logic, action)(path, self._parameterNode))


class SegmentSection:
    """Shows between which places a segment is cut out, and writes it."""

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic = ui, logic
        self._parameterNode = None
        self.writing = FolderButton(
            ui.writeSegmentButton,
            _("A new folder with the segment is made in"),
            self._stepsInto,
            attempt,
            lambda _folder: None,  # what there is to say is in the status
        )

    def show(self, parameterNode):
        """Show a parameter node."""
        self._parameterNode = parameterNode
        isReady = None not in (parameterNode.vessel, parameterNode.centerline)
        self.ui.writeSegmentButton.enabled = isReady or self.writing.isRunning
        self.ui.segmentPlaceWidget.setCurrentNode(parameterNode.segmentEnds)

    def _stepsInto(self, folder):
        return self._logic.segmentSteps(self._parameterNode, folder)
