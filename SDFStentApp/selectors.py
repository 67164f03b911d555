"""Widgets that choose something in the scene."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from typing import Any

import slicer
from vtkmodules.util.misc import calldata_type
from vtkmodules.util.vtkConstants import VTK_OBJECT

from .widgets import Widget, shown

NEW = "+"
"""Chosen in place of a node's ID: one that is made now."""

SCENE_EVENTS = {
    "NodeAddedEvent": 10.0,
    "NodeAboutToBeRemovedEvent": -10.0,
    "NodeRemovedEvent": 10.0,
    "EndCloseEvent": 0.0,
    "EndImportEvent": 0.0,
}
"""What Slicer's scene model hears of, and how early."""

SEGMENT_EVENTS = ("SegmentAdded", "SegmentRemoved", "SegmentModified")


class Selector(Widget):
    """Knows the nodes of a scene; `_heard(event, node)` is called when they change."""

    def __init__(self, name: str = "", parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._scene: Any = None
        self._leaving: Any = None
        self._tags: list[int] = []

    def mrmlScene(self) -> Any:
        return self._scene

    def setMRMLScene(self, scene: Any) -> None:
        """Offer what is in a scene; None: let go of it."""
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
        """As Slicer's selectors: a closed or imported scene empties them, a node that goes is followed by its neighbor."""
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
        """Those that can be chosen."""
        raise NotImplementedError

    def _take(self, node: Any) -> None:
        raise NotImplementedError


def neighbor(items: list[Any], item: Any) -> Any:
    """What a selector shows when the row that it shows is taken out: the next row, or else the one before; None when alone."""
    index = items.index(item)
    others = items[:index] + items[index + 1 :]
    return others[min(index, len(others) - 1)] if others else None


class NodeComboBox(Selector):
    """One of the scene's nodes, as `qMRMLNodeComboBox` is used."""

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
        """Offer only nodes with this attribute, one per type that is offered, and give it to new ones."""
        if className in self.nodeTypes:
            self._attributes[className] = (name, value)

    def sortFilterProxyModel(self) -> NodeComboBox:
        """What knows which nodes are not offered: here the widget itself."""
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
        """Choose a node that is offered; any other one is the same as none."""
        isThere = node is not None and node.GetScene() is self._scene and not self._isImporting()
        self._take(node if isThere and self._is_offered(node) else None)

    def _take(self, node: Any) -> None:
        """Choose what is offered still; where there has to be one, the first."""
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
        """The scene finds them; to ask every node of it takes four times as long."""
        for name in self.nodeTypes:
            found = self._scene.GetNodesByClass(name)
            found.UnRegister(None)
            yield from found

    def _isImporting(self) -> bool:
        """Whether there is no scene, or one in which what is imported is seen at the end only."""
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


class SegmentSelector(Selector):
    """One of a segmentation's segments, as `qMRMLSegmentSelectorWidget` is used; without a node it stays what it was."""

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
        """Offer the segments of a node; the present one where it has it, else its first, which is emitted at once."""
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
    """Whether the next click into the view places a point, as `qSlicerMarkupsPlaceWidget` is used."""

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
        """Place the points of this markups, or of none."""
        if node is not self._node:
            self._node, self.placeModeEnabled = node, False
        self.enabled = node is not None

    def edit(self, value: Any) -> None:
        self.placeModeEnabled = value
