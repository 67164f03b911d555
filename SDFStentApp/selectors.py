"""Widgets that choose a node or a segment in the scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from typing import Any

import slicer
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_OBJECT

from .widgets import Widget, shown

NEW = "+"
"""Value for a new node, in place of a node's ID."""

SCENE_EVENTS = {
    "NodeAddedEvent": 10.0,
    "NodeAboutToBeRemovedEvent": -10.0,
    "NodeRemovedEvent": 10.0,
    "EndCloseEvent": 0.0,
    "EndImportEvent": 0.0,
}
"""Events that Slicer's scene model observes, and their priorities."""

SEGMENT_EVENTS = ("SegmentAdded", "SegmentRemoved", "SegmentModified")


class SceneSelector(Widget):
    """A widget that knows the nodes of a scene; `_heard(event, node)` is called when
    they change."""

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._scene: Any = None
        self._leaving: Any = None
        self._tags: list[int] = []

    def mrmlScene(self) -> Any:
        return self._scene

    def setMRMLScene(self, scene: Any) -> None:
        """Offer the nodes of a scene; None: let go of it."""
        for tag in self._tags:
            self._scene.RemoveObserver(tag)
        self._scene = scene
        self._tags = [self._observed(name) for name in SCENE_EVENTS] if scene else []
        self._take(self.currentNode())

    def _observed(self, name: str) -> int:
        @calldata_type(VTK_OBJECT)
        def heard(_scene: Any, _event: str, node: Any = None) -> None:
            self._heard(name, node)

        event = getattr(self._scene, name)
        return int(self._scene.AddObserver(event, heard, SCENE_EVENTS[name]))

    def _heard(self, event: str, node: Any) -> None:
        """Follow a change of the scene as Slicer's selectors do: a closed or imported scene empties
        them, a removed node is replaced by its neighbor."""
        if event in ("EndCloseEvent", "EndImportEvent"):  # all rows are taken out and made anew
            self.setCurrentNode(None)
        elif self._scene.IsClosing() or self._scene.IsImporting():
            return
        elif event != "NodeAboutToBeRemovedEvent":
            self._take(self.currentNode())
        elif node is self.currentNode():
            following = neighbor(self.nodes(), node)
            self._leaving = node
            self._take(following)
            self._leaving = None

    def currentNode(self) -> Any:
        raise NotImplementedError

    def setCurrentNode(self, node: Any) -> None:
        """Choose a node, or None."""
        raise NotImplementedError

    def nodes(self) -> list[Any]:
        """The nodes that can be chosen."""
        raise NotImplementedError

    def _take(self, node: Any) -> None:
        raise NotImplementedError


def neighbor(items: list[Any], item: Any) -> Any:
    """Item of a selector after its present one is removed: the next one, or else the one before; None if it was the only one."""
    index = items.index(item)
    others = items[:index] + items[index + 1 :]
    return others[min(index, len(others) - 1)] if others else None


class NodeComboBox(SceneSelector):
    """A choice of one of the scene's nodes, as `qMRMLNodeComboBox` offers it."""

    edited = "nodeID"
    nodeTypes, noneEnabled, noneDisplay = shown(()), shown(False), shown("None")
    showHidden, showChildNodeTypes = shown(False), shown(True)
    addEnabled, baseName = shown(False), shown("")
    nodeID = shown("")

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._attributes: dict[str, tuple[str, str]] = {}
        self._hidden: tuple[str, ...] = ()

    def checked_value(self, name: str, value: Any) -> Any:
        if name == "baseName" and not self.nodeTypes:
            logging.error("qMRMLNodeComboBox::setBaseName failed: no node types have been set yet")
            return ""
        return value

    def addAttribute(self, className: str, name: str, value: str = "") -> None:
        """Offer only nodes of this type that have this attribute, and give it to new ones; each
        offered type has at most one."""
        if className in self.nodeTypes:
            self._attributes[className] = (name, value)

    def sortFilterProxyModel(self) -> NodeComboBox:
        """The object that knows which nodes are hidden: here the widget itself."""
        return self

    @property
    def hiddenNodeIDs(self) -> tuple[str, ...]:
        return self._hidden

    @hiddenNodeIDs.setter
    def hiddenNodeIDs(self, ids: Iterable[str]) -> None:
        self._hidden = tuple(ids)
        self.setCurrentNode(self.currentNode())

    def currentNode(self) -> Any:
        return self._scene.GetNodeByID(self.nodeID) if self._scene and self.nodeID else None

    def setCurrentNode(self, node: Any) -> None:
        """Choose one of the offered nodes; any other node counts as none."""
        isThere = node is not None and node.GetScene() is self._scene and not self._isImporting()
        self._take(node if isThere and self._is_offered(node) else None)

    def _take(self, node: Any) -> None:
        """Choose a node; if it is None and there has to be one, the first."""
        if node is None and not self.noneEnabled:
            node = next(iter(self.nodes()), None)
        nodeID, before = node.GetID() if node is not None else "", self.nodeID
        self.nodeID = nodeID
        self.tell()
        if nodeID != before:
            self.emit("currentNodeChanged", node)

    def nodes(self) -> list[Any]:
        if self._isImporting():
            return []
        offered = {node for node in self._of_types() if self._is_offered(node)}
        return [node for node in self._scene.GetNodes() if node in offered]

    def _of_types(self) -> Iterator[Any]:
        """The nodes of the offered types, found by the scene: to ask every node takes four times as
        long."""
        for name in self.nodeTypes:
            found = self._scene.GetNodesByClass(name)
            found.UnRegister(None)
            yield from found

    def _isImporting(self) -> bool:
        """Whether no scene is set, or it is importing: imported nodes are seen only at the end."""
        return self._scene is None or bool(self._scene.IsImporting())

    def _is_offered(self, node: Any) -> bool:
        of = next((name for name in self.nodeTypes if self._is_of(node, name)), None)
        isHidden = node.GetHideFromEditors() and not self.showHidden
        isHidden |= node is self._leaving or node.GetID() in self._hidden
        if of is None or isHidden:
            return False
        name, value = self._attributes.get(of, ("", None))
        return not name or node.GetAttribute(name) == value

    def _is_of(self, node: Any, name: str) -> bool:
        return bool(node.IsA(name) if self.showChildNodeTypes else node.GetClassName() == name)

    def addNode(self) -> Any:
        """Make a node of the first type, and choose it."""
        node = self._scene.CreateNodeByClass(self.nodeTypes[0])
        node.UnRegister(None)
        node.SetName(self._scene.GenerateUniqueName(self.baseName or "Node"))
        for name, value in self._attributes.values():
            node.SetAttribute(name, value)
        node = self._scene.AddNode(node)
        if isinstance(node, slicer.vtkMRMLDisplayableNode):
            node.CreateDefaultDisplayNodes()
        self.setCurrentNode(node)
        self.emit("nodeAddedByUser", node)
        return node

    def state(self) -> dict[str, Any]:
        offered = [{"id": node.GetID(), "name": node.GetName()} for node in self.nodes()]
        none = self.noneDisplay if self.noneEnabled else None
        return {**super().state(), "items": offered, "none": none, "add": self.addEnabled}

    def edit(self, value: Any) -> None:
        by_id = {node.GetID(): node for node in self.nodes()}
        if not isinstance(value, str):
            return
        if value == NEW and self.addEnabled:
            self.addNode()
        elif value in by_id or (value == "" and self.noneEnabled):
            self.setCurrentNode(by_id.get(value))


class SegmentSelector(SceneSelector):
    """A choice of one of a segmentation's segments, as `qMRMLSegmentSelectorWidget` offers it;
    without a node it keeps its segment."""

    edited = "segment"
    segment = shown("", "currentSegmentChanged")

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._node: Any = None
        self._watched: list[int] = []

    def currentNode(self) -> Any:
        return self._node

    def setCurrentNode(self, node: Any) -> None:
        if node is not self._node:
            self._take(node)

    def _take(self, node: Any) -> None:
        """Offer the segments of a node. If the present segment is not among them, the first one is
        chosen, which is emitted at once."""
        for tag in self._watched:
            self._node.GetSegmentation().RemoveObserver(tag)
        self._node, self._watched = node, []
        if node is not None:
            segmentation = node.GetSegmentation()
            self._watched = [
                segmentation.AddObserver(getattr(segmentation, event), lambda *_: self._populate())
                for event in SEGMENT_EVENTS
            ]
        self._populate()

    def _populate(self) -> None:
        self.tell()
        ids = self._ids()
        if ids and self.segment not in ids:
            self.segment = ids[0]

    def _ids(self) -> list[str]:
        return [] if self._node is None else list(self._node.GetSegmentation().GetSegmentIDs())

    def _name(self, segmentID: str) -> str:
        return str(self._node.GetSegmentation().GetSegment(segmentID).GetName())

    def nodes(self) -> list[Any]:
        return list(slicer.util.getNodesByClass("vtkMRMLSegmentationNode"))

    def currentSegmentID(self) -> str:
        return self.segment

    def setCurrentSegmentID(self, segmentID: str) -> None:
        if segmentID in self._ids():
            self.segment = segmentID

    def state(self) -> dict[str, Any]:
        items = [{"id": one, "name": self._name(one)} for one in self._ids()]
        return {**super().state(), "items": items}

    def edit(self, value: Any) -> None:
        if isinstance(value, str) and value in self._ids():
            self.segment = value


class PlaceWidget(Widget):
    """A switch for placing a point with the next click into the view, as
    `qSlicerMarkupsPlaceWidget` is used."""

    edited = "placeModeEnabled"
    placeModeEnabled = shown(False, "activeMarkupsPlaceModeChanged")
    placeModePersistency = shown(False)

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._node: Any = None

    def checked_value(self, name: str, value: Any) -> Any:
        return value is True and self._node is not None if name == self.edited else value

    def currentNode(self) -> Any:
        return self._node

    def setCurrentNode(self, node: Any) -> None:
        """Place the points of this markups node, or with None of no node."""
        if node is not self._node:
            self._node, self.placeModeEnabled = node, False
        self.enabled = node is not None

    def edit(self, value: Any) -> None:
        self.placeModeEnabled = value
