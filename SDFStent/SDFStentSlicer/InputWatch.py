"""Follows the nodes that a result depends on."""

import slicer
from slicer.util import VTKObservationMixin
from vtkmodules.vtkCommonCore import vtkCommand


class InputWatch(VTKObservationMixin):
    """Calls `onModified()` when one of the watched nodes changes, `onReleased(node)` when a dragged point is let go.

    Before that, and when it begins to watch it, `onMoved(node)` for markups; what that changes of them is a part of the change.
    """

    def __init__(self, onModified, onReleased, onMoved):
        VTKObservationMixin.__init__(self)
        self._onModified, self._onReleased, self._onMoved = onModified, onReleased, onMoved
        self._nodes, self._isMoving = [], False

    def watch(self, nodes):
        """Watch these nodes and no others; nothing is done when they are the same as before."""
        if nodes == self._nodes:
            return
        self.removeObservers()
        self._nodes = nodes
        for node in nodes:
            for event in _eventsOf(node):
                self.addObserver(node, event, self._modified)
            if node.IsA("vtkMRMLMarkupsNode"):
                self.addObserver(node, node.PointEndInteractionEvent, self._released)
                self._onMoved(node)

    def _modified(self, caller=None, event=None):
        if self._isMoving:
            return
        if caller.IsA("vtkMRMLMarkupsNode"):
            self._isMoving = True
            try:
                self._onMoved(caller)
            finally:
                self._isMoving = False
        self._onModified()

    def _released(self, caller, event=None):
        self._onReleased(caller)


def _eventsOf(node):
    events = [slicer.vtkMRMLTransformableNode.TransformModifiedEvent]
    if node.IsA("vtkMRMLMarkupsNode"):
        events += [node.PointModifiedEvent, node.PointPositionDefinedEvent, node.PointRemovedEvent]
    elif node.IsA("vtkMRMLModelNode"):
        events.append(slicer.vtkMRMLModelNode.MeshModifiedEvent)
    else:
        events.append(vtkCommand.ModifiedEvent)
    return events
