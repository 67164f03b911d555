"""The section Flow solver of the panel: a segment of the vessel for a solver."""

from slicer.i18n import tr as _

from .FolderButton import FolderButton


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
        """The parameter node that is shown now."""
        self._parameterNode = parameterNode
        isReady = None not in (parameterNode.vessel, parameterNode.centerline)
        self.ui.writeSegmentButton.enabled = isReady or self.writing.isRunning
        self.ui.segmentPlaceWidget.setCurrentNode(parameterNode.segmentEnds)

    def _stepsInto(self, folder):
        return self._logic.segmentSteps(self._parameterNode, folder)
