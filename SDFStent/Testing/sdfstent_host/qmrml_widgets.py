"""Look-alikes of the qMRML widgets that panels use most: their properties, slots and signals, real nodes inside.

A stand-in offers only what the real widget has. `check_panel.py` holds the panel against the real headers as well.
"""

import slicer
import vtk
from PySide6.QtCore import Property, Signal
from PySide6.QtWidgets import QWidget

from .place_widget import qSlicerMarkupsPlaceWidget
from .scene_observer import SceneSelector, neighbor
from .segment_selector import qMRMLSegmentSelectorWidget


def warn(text):
    """What Qt would write to the console, in the log that tests look at."""
    vtk.vtkOutputWindow.GetInstance().DisplayErrorText(text + "\n")


class qMRMLWidget(QWidget):
    mrmlSceneChanged = Signal(object)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._scene = None

    def mrmlScene(self):
        return self._scene

    def setMRMLScene(self, scene):
        if scene is not self._scene:
            self._scene = scene
            self.mrmlSceneChanged.emit(scene)


class SortFilterProxyModel:
    """What a node selector does not show, whatever its type."""

    def __init__(self, onChanged):
        self._onChanged, self._hidden = onChanged, []

    @property
    def hiddenNodeIDs(self):
        return list(self._hidden)

    @hiddenNodeIDs.setter
    def hiddenNodeIDs(self, nodeIDs):
        self._hidden = list(nodeIDs)
        self._onChanged()


class qMRMLNodeComboBox(SceneSelector):
    currentNodeChanged = Signal(object)
    nodeAddedByUser = Signal(object)

    def __init__(self, parent=None):
        super().__init__(parent)
        self._currentID, self._ids = None, []
        self._nodeTypes, self._flags, self._texts = [], {}, {}
        self._attributes = {}
        self._leaving = None
        self._filter = SortFilterProxyModel(self._dropHidden)
        self._box.activated.connect(self._onActivated)

    def setMRMLScene(self, scene):
        super().setMRMLScene(scene)
        self._refresh()

    def currentNode(self):
        return self._scene.GetNodeByID(self._currentID) if self._scene and self._currentID else None

    def setCurrentNode(self, node):
        self.setCurrentNodeID(node.GetID() if node else None)

    def setCurrentNodeID(self, nodeID):
        """Show a node that is offered; any other one is the same as none."""
        if nodeID is not None and nodeID == self._currentID and nodeID in self._ids:
            return
        self._refresh()
        nodeID = nodeID if nodeID in self._ids else None
        changed = nodeID != self._currentID
        self._currentID = nodeID
        self._refresh()
        if changed:
            self.currentNodeChanged.emit(self.currentNode())

    def addAttribute(self, nodeType, name, value=""):
        """Offer only nodes with this attribute, one per type that is offered, and give it to new ones."""
        if nodeType in self._nodeTypes:
            self._attributes[nodeType] = (name, value)
            self._refresh()

    def sortFilterProxyModel(self):
        return self._filter

    def addNode(self):
        node = self._scene.CreateNodeByClass(self._nodeTypes[0])
        node.UnRegister(None)
        node.SetName(self._scene.GenerateUniqueName(self.baseName or "Node"))
        for name, value in self._attributes.values():
            node.SetAttribute(name, value)
        node = self._scene.AddNode(node)
        self.setCurrentNode(node)
        self.nodeAddedByUser.emit(node)
        return node

    def _onActivated(self, index):
        if index < len(self._ids):
            self.setCurrentNodeID(self._ids[index])
        elif self._texts.get("createText") == self._box.itemText(index):
            self.addNode()

    def _onScene(self, event, node):
        if event in ("EndCloseEvent", "EndImportEvent"):  # all rows are taken out and made anew
            self.setCurrentNodeID(None)
        elif event == "NodeAboutToBeRemovedEvent" and node.GetID() == self._currentID:
            if not self._scene.IsClosing():
                self._moveOn(node)
        elif not self._scene.IsClosing():
            self._refresh()

    def _moveOn(self, node):
        """The node shown is about to go: show its neighbor."""
        self._leaving = node
        self._currentID = neighbor([i for i in self._ids if i is not None], node.GetID())
        self._refresh()
        self.currentNodeChanged.emit(self.currentNode())
        self._leaving = None

    def _dropHidden(self):
        """The filter has changed: a node that it hides is not the current one any more."""
        self._refresh()
        if self._currentID is not None and self._currentID not in self._ids:
            self.setCurrentNodeID(None)

    def _refresh(self):
        if self._scene is None or self._scene.IsImporting():  # what is imported is seen at the end
            return
        nodes = [
            n
            for t in self._nodeTypes
            for n in slicer.util.getNodesByClass(t)
            if self._accepts(n, t)
        ]
        ids = [n.GetID() for n in nodes]
        if self._currentID is not None and self._scene.GetNodeByID(self._currentID) is None:
            self._currentID = None
            self.currentNodeChanged.emit(None)
        if not self._flags.get("noneEnabled") and self._currentID is None and ids:
            self._currentID = ids[0]
            self.currentNodeChanged.emit(nodes[0])
        labels = [n.GetName() for n in nodes]
        if self._flags.get("noneEnabled") or not ids:
            ids, labels = [None, *ids], [self._texts.get("noneDisplay") or "None", *labels]
        self._ids = ids
        if self._flags.get("addEnabled"):
            self._texts["createText"] = f"Create new {self._texts.get('baseName') or 'node'}"
            labels = [*labels, self._texts["createText"]]
        self._show(labels, ids.index(self._currentID) if self._currentID in ids else 0)

    def _accepts(self, node, nodeType):
        if node.GetHideFromEditors() and not self._flags.get("showHidden"):
            return False
        if node is self._leaving or node.GetID() in self._filter.hiddenNodeIDs:
            return False
        name, value = self._attributes.get(nodeType, ("", None))
        if name and node.GetAttribute(name) != value:
            return False
        return self._flags.get("showChildNodeTypes", True) or node.GetClassName() == nodeType

    def _getNodeTypes(self):
        return self._nodeTypes

    def _setNodeTypes(self, nodeTypes):
        self._nodeTypes = list(nodeTypes)
        self._refresh()

    def _setBaseName(self, baseName):
        if not self._nodeTypes:
            warn("qMRMLNodeComboBox::setBaseName failed: no node types have been set yet")
            return
        self._texts["baseName"] = baseName
        self._refresh()

    def _flag(name):
        return Property(
            bool,
            lambda self: self._flags.get(name, False),
            lambda self, v: (self._flags.update({name: v}), self._refresh())[0],
        )

    def _string(name):
        return Property(
            str,
            lambda self: self._texts.get(name, ""),
            lambda self, v: (self._texts.update({name: v}), self._refresh())[0],
        )

    nodeTypes = Property("QStringList", _getNodeTypes, _setNodeTypes)
    noneEnabled = _flag("noneEnabled")
    addEnabled = _flag("addEnabled")
    removeEnabled = _flag("removeEnabled")
    renameEnabled = _flag("renameEnabled")
    editEnabled = _flag("editEnabled")
    showHidden = _flag("showHidden")
    showChildNodeTypes = _flag("showChildNodeTypes")
    selectNodeUponCreation = _flag("selectNodeUponCreation")
    baseName = Property(str, lambda self: self._texts.get("baseName", ""), _setBaseName)
    noneDisplay = _string("noneDisplay")


QMRML_WIDGETS = {
    c.__name__: c
    for c in (qMRMLWidget, qMRMLNodeComboBox, qMRMLSegmentSelectorWidget, qSlicerMarkupsPlaceWidget)
}
