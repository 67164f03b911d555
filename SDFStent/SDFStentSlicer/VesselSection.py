"""Section Vessel of the panel: walls, segments and lines to choose from. The choice is bound to parameters."""

import slicer

from . import Conversion, Outputs
from .PanelParts import RunButton, stopWords
from .SegmentWall import SegmentWall


class VesselSection:
    """Offers in `ui` what may be an input, and sets the segment that the user chooses.

    `attempt(action)` does what is asked for and says why when it cannot be done.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._parameterNode = ui, None
        self.making = CenterlineButton(ui.extractButton, logic, attempt)
        self._wall = SegmentWall(logic.vesselInPortions)
        ui.segmentSelector.connect("currentSegmentChanged(QString)", self._onSegment)

    def show(self, parameterNode):
        """Show a parameter node, or None."""
        self._parameterNode = parameterNode
        self.making.show(parameterNode)
        self._wall.show(parameterNode)
        if parameterNode is not None:
            self._showSegments(parameterNode)
            self._offer(parameterNode)

    def _showSegments(self, parameterNode):
        vessel, selector = parameterNode.vessel, self.ui.segmentSelector
        isSegmentation = vessel is not None and vessel.IsA("vtkMRMLSegmentationNode")
        selector.visible = isSegmentation  # with a label of its own
        wasBlocked = selector.blockSignals(True)  # it says that the first segment was chosen
        selector.setCurrentNode(vessel if isSegmentation else None)
        selector.setCurrentSegmentID(parameterNode.segmentID)
        selector.blockSignals(wasBlocked)

    def _offer(self, parameterNode):
        """Offer no results, lines or walls where they are no inputs, unless one is chosen already. An empty model may become either."""
        models = slicer.util.getNodesByClass("vtkMRMLModelNode")
        results = [one for one in models if one.GetAttribute(Outputs.ATTRIBUTE) is not None]
        isWall, isLine = Conversion.hasWall, Conversion.hasLines
        for name, isIt, isOther in (
            ("vessel", isWall, isLine),
            ("centerline", isLine, isWall),
            ("deviceMesh", isWall, isLine),
        ):
            others = [one for one in models if isOther(one) and not isIt(one)]
            selector = getattr(self.ui, name + "Selector")
            chosen = getattr(parameterNode, name), selector.currentNode()  # which may follow yet
            hidden = [one.GetID() for one in {*results, *others}.difference(chosen)]
            offered = selector.sortFilterProxyModel()
            if set(offered.hiddenNodeIDs) != set(hidden):
                offered.hiddenNodeIDs = hidden

    @staticmethod
    def chooseOnly(parameterNode, hasNew=False):
        """Choose the only wall and the only lines of a scene, where nothing is chosen.

        Where there is something new, either for itself; a segmentation of one segment is such a wall.
        """
        models = slicer.util.getNodesByClass("vtkMRMLModelNode")
        inputs = [
            one
            for one in models
            if not one.GetHideFromEditors() and one.GetAttribute(Outputs.ATTRIBUTE) is None
        ]
        walls, lines = (
            [one for one in inputs if isIt(one)]
            for isIt in (Conversion.hasWall, Conversion.hasLines)
        )
        others = slicer.util.getNodesByClass("vtkMRMLSegmentationNode")
        if not walls and [one.GetSegmentation().GetNumberOfSegments() for one in others] == [1]:
            walls, others = others, []
        isChosen = parameterNode.vessel is not None or parameterNode.centerline is not None
        isClear = len(walls) == len(lines) == 1 and not isChosen
        if others or walls == lines or not (hasNew or isClear):
            return
        with slicer.util.NodeModify(parameterNode):
            if parameterNode.vessel is None and len(walls) == 1:
                parameterNode.vessel = walls[0]
            if parameterNode.centerline is None and len(lines) == 1:
                parameterNode.centerline = lines[0]

    def _onSegment(self, segmentID):
        """Take the user's choice; what the selector says of another node, which it went to by itself, is none."""
        vessel = self._parameterNode.vessel if self._parameterNode is not None else None
        if vessel is not None and segmentID and self.ui.segmentSelector.currentNode() is vessel:
            self._parameterNode.segmentID = segmentID


class CenterlineButton:
    """Makes a centerline of the vessel that is shown; while it does so, another click stops it.

    `attempt(action)` does what is asked for and says why when it cannot be done; `onMade(former)` is called with the centerline that was
    chosen before, or None.
    """

    def __init__(self, button, logic, attempt):
        self._logic, self.onMade = logic, lambda _former: None
        self._parameterNode = self._vessel = None
        self._button = RunButton(
            button, self._begin, stopWords, attempt, lambda former: self.onMade(former)
        )

    @property
    def isRunning(self):
        """Whether a centerline is being made."""
        return self._button.isRunning

    def show(self, parameterNode):
        """Show a parameter node, or None; drop the centerline that is being made for another vessel."""
        self._parameterNode = parameterNode
        if self.isRunning and self._vessel != _vesselOf(parameterNode):
            self.stop()

    def stop(self):
        """Make no centerline."""
        self._button.stop()

    def _begin(self):
        self._vessel = _vesselOf(self._parameterNode)
        return self._logic.centerlineInPortions(self._parameterNode)


def _vesselOf(parameterNode):
    """The node, and the vessel and the segment that it has."""
    if parameterNode is None:
        return None
    return parameterNode.parameterNode, parameterNode.vessel, Conversion.segmentOf(parameterNode)
