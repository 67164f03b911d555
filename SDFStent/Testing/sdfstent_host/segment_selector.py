"""A look-alike of the segment selector, inner node selector included."""

import slicer
from PySide6.QtCore import Property, Signal

from .scene_observer import SceneSelector, neighbor

SEGMENT_EVENTS = ("SegmentAdded", "SegmentRemoved", "SegmentModified")


class qMRMLSegmentSelectorWidget(SceneSelector):
    currentSegmentChanged = Signal(str)
    LABEL = "Segment: "

    def __init__(self, parent=None):
        super().__init__(parent)
        self._node, self._flags = None, {}
        self._ids, self._currentID, self._tags = [], "", []
        self._box.currentIndexChanged.connect(self._onCurrentIndex)

    def currentNode(self):
        return self._node

    def setCurrentNode(self, node):
        if node is self._node:
            return
        for tag in self._tags:
            self._node.GetSegmentation().RemoveObserver(tag)
        self._node, self._tags = node, []
        if node is not None:
            segmentation = node.GetSegmentation()
            self._tags = [
                segmentation.AddObserver(
                    getattr(slicer.vtkSegmentation, e), lambda *_: self._populate()
                )
                for e in SEGMENT_EVENTS
            ]
        self._populate()

    def currentSegmentID(self):
        """Stays what it was when there is no node."""
        return self._currentID

    def setCurrentSegmentID(self, segmentID):
        if segmentID in self._ids:
            self._box.setCurrentIndex(self._ids.index(segmentID))

    def _onScene(self, event, node):
        if event in ("EndCloseEvent", "EndImportEvent"):
            self.setCurrentNode(None)
        elif event == "NodeAboutToBeRemovedEvent" and node is self._node:
            nodes = slicer.util.getNodesByClass("vtkMRMLSegmentationNode")
            self.setCurrentNode(neighbor(nodes, node))

    def _populate(self):
        """The segments of the node; the present one where it has it, else its first, which is emitted at once."""
        segmentation = self._node.GetSegmentation() if self._node is not None else None
        self._ids = list(segmentation.GetSegmentIDs()) if segmentation is not None else []
        isThere = self._currentID in self._ids
        names = [segmentation.GetSegment(i).GetName() for i in self._ids]
        self._show(names, self._ids.index(self._currentID) if isThere else -1)
        if self._ids and not isThere:
            self._box.setCurrentIndex(0)

    def _onCurrentIndex(self, index):
        self._currentID = self._ids[index]
        self.currentSegmentChanged.emit(self._currentID)

    def _flag(name):
        return Property(
            bool,
            lambda self: self._flags.get(name, False),
            lambda self, v: self._flags.update({name: v}),
        )

    noneEnabled = _flag("noneEnabled")
    multiSelection = _flag("multiSelection")
    segmentationNodeSelectorVisible = _flag("segmentationNodeSelectorVisible")
