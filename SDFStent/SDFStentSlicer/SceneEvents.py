"""Events of the scene for the panel: changes of nodes that a result depends on, and that it is closed or imported into."""

import slicer
from slicer.util import VTKObservationMixin
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_OBJECT
from vtkmodules.vtkCommonCore import vtkCommand

from . import Clock


class InputWatch(VTKObservationMixin):
    """Calls `onModified()` when one of the watched nodes changes, `onGrabbed(node)` and `onReleased(node)` when the mouse takes a point
    and lets it go.

    Before that, and when it begins to watch it, `onMoved(node)` for markups; what that changes of them is a part of the change.
    """

    def __init__(self, onModified, onGrabbed, onReleased, onMoved):
        VTKObservationMixin.__init__(self)
        self._onModified, self._onGrabbed = onModified, onGrabbed
        self._onReleased, self._onMoved = onReleased, onMoved
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
                self.addObserver(node, node.PointStartInteractionEvent, self._grabbed)
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

    def _grabbed(self, caller, event=None):
        self._onGrabbed(caller)

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


class SceneEvents:
    """A part of `SDFStentWidget`: lets go of a scene in time, and shows the plan that it comes back with."""

    def _observeScene(self, scene):
        self._added = Clock.timer(self._offer, 0)
        for event, method in (
            (scene.StartCloseEvent, self.onSceneStartClose),
            (scene.EndCloseEvent, self.onSceneReady),
            (scene.StartImportEvent, self.onSceneStartImport),
            (scene.EndImportEvent, self.onSceneEndImport),
            (scene.NodeAddedEvent, self.onNodeAdded),
            (scene.NodeAboutToBeRemovedEvent, self.onNodeAboutToBeRemoved),
            (scene.NodeRemovedEvent, self.onNodeRemoved),
        ):
            # After selectors and logic have heard of it; of a deleted node a selector hears later (-10).
            self.addObserver(scene, event, method, priority=-1.0)
        layout = scene.GetFirstNodeByClass("vtkMRMLLayoutNode")
        if layout is not None:  # without a window there is none
            self.addObserver(layout, vtkCommand.ModifiedEvent, self.onLayoutChanged, priority=-1.0)

    def onLayoutChanged(self, caller=None, event=None):
        self._state.atHand.write()
        self.lesions.followLayout()
        self.views.onLayoutChanged(caller)

    def onSceneStartClose(self, caller=None, event=None):
        self.setParameterNode(None)
        self.logic.forget()

    def onSceneStartImport(self, caller=None, event=None):
        # Selectors are emptied by an import, and references are not resolved while it lasts.
        self.setParameterNode(None)
        self._present = self.logic.getAllParameterNodes()
        self.logic.markShown(None)  # so that what is marked afterward was saved so

    def onSceneEndImport(self, caller=None, event=None):
        shown, self._lastSet = self._lastSet, None
        self._lastSet = self.logic.planAfterImport(shown, self._present)
        self.logic.nameApart(self._present)
        self.onSceneReady()

    def onSceneReady(self, caller=None, event=None):
        if self.parent.isEntered:
            self.initializeParameterNode()
            self.logic.showPlan(self._parameterNode)
        elif self._lastSet is not None:
            self.logic.showPlan(self.logic.parameterSet(self._lastSet))

    def onNodeAdded(self, caller=None, event=None):
        self._added.start()  # who adds a model may fill it afterward

    def _offer(self):
        if self._parameterNode is not None:
            self.vessel.chooseOnly(self._parameterNode, hasNew=True)
            self.vessel.show(self._parameterNode)

    @calldata_type(VTK_OBJECT)
    def onNodeAboutToBeRemoved(self, caller, event, node):
        if self._parameterNode is None:
            return
        if node is self._parameterNode.parameterNode:
            self._leavings = self.logic.leavings(self._parameterNode)
            self.setParameterNode(None)
        else:
            self.logic.leave(self._parameterNode, node)

    @calldata_type(VTK_OBJECT)
    def onNodeRemoved(self, caller, event, node):
        if node is not self._lastSet:  # such as a mark of a lesion, which goes with the plan shown
            return
        leavings, self._leavings = self._leavings, None
        if not (caller.IsClosing() or caller.IsImporting()):
            if leavings is not None:
                self.logic.removeLeavings(leavings)
            self.onSceneReady()
