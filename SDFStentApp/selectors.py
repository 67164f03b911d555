"""Widgets that choose something in the scene."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .widgets import Widget, shown

NEW = "+"
"""Chosen in place of a node's ID: one that is made now."""


class OfNode(Widget):
    """Knows a node of the scene, or None."""

    def __init__(self, name: str, parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._node: Any = None

    def currentNode(self) -> Any:
        return self._node


class Filter:
    """Which nodes a selector does not offer, as `qMRMLSortFilterProxyModel` is used."""

    def __init__(self, widget: Widget) -> None:
        self._widget = widget
        self._hidden: tuple[str, ...] = ()

    @property
    def hiddenNodeIDs(self) -> tuple[str, ...]:
        """IDs of nodes."""
        return self._hidden

    @hiddenNodeIDs.setter
    def hiddenNodeIDs(self, ids: Iterable[str]) -> None:
        self._hidden = tuple(ids)
        self._widget.tell()


class NodeComboBox(OfNode):
    """One of the scene's nodes, as `qMRMLNodeComboBox` is used."""

    edited = "nodeID"
    nodeTypes, noneEnabled, noneDisplay = shown(()), shown(True), shown("")
    showHidden, addEnabled, baseName = shown(False), shown(False), shown("")

    def __init__(self, name: str, parameter: str = "") -> None:
        super().__init__(name, parameter)
        self._scene: Any = None
        self._attributes: list[tuple[str, str, str]] = []
        self._filter = Filter(self)

    def setMRMLScene(self, scene: Any) -> None:
        """Offer the nodes of a scene, whichever it has."""
        self._scene = scene
        for event in (scene.NodeAddedEvent, scene.NodeRemovedEvent, scene.EndCloseEvent):
            scene.AddObserver(event, lambda *_: self._scene_changed(), 10.0)

    def addAttribute(self, className: str, name: str, value: str) -> None:
        """Offer only nodes of a class that have an attribute."""
        self._attributes.append((className, name, value))

    def sortFilterProxyModel(self) -> Filter:
        return self._filter

    def setCurrentNode(self, node: Any) -> None:
        """Choose a node, or None."""
        if node is not self._node:
            self._node = node
            self.tell()
            self.emit("currentNodeChanged", node)

    @property
    def nodeID(self) -> str:
        return self._node.GetID() if self._node is not None else ""

    def nodes(self) -> list[Any]:
        """Those that can be chosen."""
        found = [] if self._scene is None else list(self._scene.GetNodes())
        return [node for node in found if self._is_offered(node)]

    def _is_offered(self, node: Any) -> bool:
        if not any(node.IsA(name) for name in self.nodeTypes):
            return False
        isHidden = node.GetHideFromEditors() and not self.showHidden
        if isHidden or node.GetID() in self._filter.hiddenNodeIDs:
            return False
        return all(
            node.GetAttribute(name) == value
            for className, name, value in self._attributes
            if node.IsA(className)
        )

    def _new(self) -> Any:
        name = self._scene.GenerateUniqueName(self.baseName)
        node = self._scene.AddNewNodeByClass(self.nodeTypes[0], name)
        node.CreateDefaultDisplayNodes()
        return node

    def _scene_changed(self) -> None:
        if self._node is not None and self._node.GetScene() is None:
            self.setCurrentNode(None)
        self.tell()

    def state(self) -> dict[str, Any]:
        offered = [{"id": node.GetID(), "name": node.GetName()} for node in self.nodes()]
        none = self.noneDisplay if self.noneEnabled else None
        return {**super().state(), "items": offered, "none": none, "add": self.addEnabled}

    def edit(self, value: Any) -> None:
        by_id = {node.GetID(): node for node in self.nodes()}
        if not isinstance(value, str):
            return
        if value == NEW and self.addEnabled:
            self.setCurrentNode(self._new())
        elif value in by_id or (value == "" and self.noneEnabled):
            self.setCurrentNode(by_id.get(value))


class SegmentSelector(OfNode):
    """One of a segmentation's segments, as `qMRMLSegmentSelectorWidget` is used."""

    edited = "segment"
    segment = shown("", "currentSegmentChanged")

    def setCurrentNode(self, node: Any) -> None:
        if node is not self._node:
            self._node = node
            self.tell()

    def currentSegmentID(self) -> str:
        return self.segment

    def setCurrentSegmentID(self, segmentID: str) -> None:
        self.segment = segmentID

    def state(self) -> dict[str, Any]:
        segments = () if self._node is None else self._node.GetSegmentation().GetSegmentIDs()
        return {**super().state(), "items": list(segments)}

    def edit(self, value: Any) -> None:
        if isinstance(value, str) and value in self.state()["items"]:
            self.segment = value


class PlaceWidget(OfNode):
    """Whether the next click into the view places a handle, as `qSlicerMarkupsPlaceWidget` is used."""

    edited = "isPlacing"
    isPlacing = shown(False, "placing")

    def setCurrentNode(self, node: Any) -> None:
        """Place the points of this markups, or of none."""
        if node is not self._node:
            self._node, self.isPlacing = node, False
        self.enabled = node is not None

    def edit(self, value: Any) -> None:
        self.isPlacing = value is True and self._node is not None
