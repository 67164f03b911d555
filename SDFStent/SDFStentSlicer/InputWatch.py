"""Follows the nodes that a result depends on."""

import slicer
from slicer.util import VTKObservationMixin
from vtkmodules.vtkCommonCore import vtkCommand


class InputWatch(VTKObservationMixin):
    """Calls `onModified()` when one of the watched nodes changes, `onReleased(node)` when a dragged point is let go."""

    def __init__(self, onModified, onReleased):
        VTKObservationMixin.__init__(self)
        self._onModified, self._onReleased = onModified, onReleased
        self._nodes = []

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

    def _modified(self, caller=None, event=None):
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
