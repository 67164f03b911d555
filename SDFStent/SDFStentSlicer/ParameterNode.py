"""The module's parameters: node references, switches, and one document with the plan, stored in the scene.

A value of the plan is got and set by its path in the document, as `parameterNode.get("stents.selected.diameter")`, in the units of the
library. Python code may use names in its place, as `parameterNode.stent.diameter`, in the units of the panel.
"""

import enum
import json
import weakref
from types import SimpleNamespace
from typing import Annotated, Optional, Union

import slicer
from slicer import (
    vtkMRMLMarkupsCurveNode,
    vtkMRMLMarkupsFiducialNode,
    vtkMRMLMarkupsLineNode,
    vtkMRMLModelNode,
    vtkMRMLPlotChartNode,
    vtkMRMLSegmentationNode,
    vtkMRMLTableNode,
)
from slicer.i18n import tr as _
from slicer.parameterNodeWrapper import WithinRange, parameterNodeWrapper

from SDFStentLib.plan import NEW_STENT, Draft, set_value, value_at, value_in_use, with_value

from .PlanFields import DEFAULTS, FLOW, METHOD, RANGES, SIZING, STENT, check
from .PlanFields import Placement as Placement


class SurfaceMap(enum.Enum):
    """Array that colors the stented vessel."""

    NONE = ""
    DISPLACEMENT = "Displacement"
    AREA_STRETCH = "AreaStretch"

    def label(self):
        """The text in the panel."""
        return {
            SurfaceMap.NONE: _("None"),
            SurfaceMap.DISPLACEMENT: _("Displacement (mm)"),
            SurfaceMap.AREA_STRETCH: _("Area, new / old"),
        }[self]


def _within(name):
    return WithinRange(RANGES[name].low, RANGES[name].high)


class Named:
    """A part of the plan by the names that Python code has for its values; `fields` are those."""

    def __init__(self, parameterNode, fields, prefix=""):
        for name, value in (("_node", parameterNode), ("_fields", fields), ("_prefix", prefix)):
            object.__setattr__(self, name, value)

    def __getattr__(self, name):
        if name == "handle":
            return self._node.get(f"{self._prefix}handle")
        if name == "draft":
            return Draft(self._node.get(self._prefix[:-1]) or {})
        if name not in self._fields:
            raise AttributeError(f"There is no {name}; expected one of {', '.join(self._fields)}.")
        field = self._fields[name]
        return field.shown(self._node.get(self._prefix + field.path))

    def __setattr__(self, name, value):
        if name == "handle":
            self._node.change({f"{self._prefix}handle": value})
        elif name not in self._fields:
            raise AttributeError(f"There is no {name}; expected one of {', '.join(self._fields)}.")
        else:
            check(name, value)
            field = self._fields[name]
            self._node.change({self._prefix + field.path: field.planned(value)})

    def values(self):
        """Values by name, free of the node."""
        return {name: getattr(self, name) for name in self._fields}


def handleRole(number):
    """The role of the node reference to the handle of a stent."""
    return f"stents.{number}.handle"


SELECTED = "stents.selected."

# Node types are written Optional[X], not X | None: Python before 3.11.7 takes one for the other inside of Annotated, and Slicer
# then finds no connector for the selector.


@parameterNodeWrapper
class SDFStentParameterNode:
    """Inputs, plan, display switches, and the nodes of the results.

    `plan` is the document of stents, method, flow and what is known of the vessel, places in mm in RAS; where stents are is said by their
    handles, which are node references. `tiles` is the result at a glance, as JSON: the library's `Tile` as lists.
    """

    vessel: Union[vtkMRMLModelNode, vtkMRMLSegmentationNode, None]
    segmentID: str = ""
    centerline: Union[vtkMRMLModelNode, vtkMRMLMarkupsCurveNode, None]

    plan: str = ""
    selected: int = -1
    deviceTable: str = ""
    suggestRatio: Annotated[float, _within("suggestRatio")] = SIZING["ratio"][1]
    suggestMargin: Annotated[float, _within("suggestMargin")] = SIZING["margin"][1]

    autoUpdate: bool = True
    expansion: Annotated[float, WithinRange(0.0, 100.0)] = 100.0
    map: SurfaceMap = SurfaceMap.NONE
    rightBranch: str = ""
    """A place in it, mm in RAS, as JSON, once the flow was found."""
    showStents: bool = True
    showDevice: bool = False
    deviceMesh: Optional[vtkMRMLModelNode]
    segmentEnds: Union[
        vtkMRMLMarkupsFiducialNode, vtkMRMLMarkupsLineNode, vtkMRMLMarkupsCurveNode, None
    ]
    closeBranches: bool = False
    showXray: bool = False

    outputVessel: Optional[vtkMRMLModelNode]
    outputCenterline: Optional[vtkMRMLModelNode]
    outputStents: Optional[vtkMRMLModelNode]
    outputTable: Optional[vtkMRMLTableNode]
    outputTexts: Optional[vtkMRMLTableNode]
    """Table for reading: a table view has "nan" for an unknown number."""
    outputChart: Optional[vtkMRMLPlotChartNode]

    status: str = ""
    """Message of the last click."""
    lumenSummary: str = ""
    certificateSummary: str = ""
    warningSummary: str = ""
    tiles: str = ""
    atHand: str = ""
    """Lines on the selected stent in the 3D view."""

    def get(self, path):
        """The value at a path of the plan's document, as by default where nothing is set; that of a handle is a node, or None."""
        path = self._resolved(path)
        if path.endswith(".handle"):
            return self.parameterNode.GetNodeReference(path)
        found = value_at(documentOf(self), path, documentOf)
        if found is not documentOf:
            return found
        part, _number, inside = (*path.split(".", 2), "", "")[:3]
        return (
            value_at(NEW_STENT, inside) if part == "stents" and inside else value_at(DEFAULTS, path)
        )

    def change(self, values):
        """Set values of the plan by their paths, in one modification; what belongs to a stent where none is selected is left."""
        document, handles = documentOf(self), {}
        for path, value in values.items():
            path = self._resolved(path)
            if path.startswith("stents.-"):
                continue
            if path.endswith(".handle"):
                handles[path] = value
            else:
                document = with_value(document, path, value)
        with slicer.util.NodeModify(self.parameterNode):
            self.plan = json.dumps(document, ensure_ascii=False)
            for role, node in handles.items():
                self._refer(role, node)

    def put(self, path, value):
        """Set a value of the plan with its consequences for the selected stent; or another parameter."""
        if hasattr(self, path):
            setattr(self, path, value)
            return
        values = {path: value}
        if path.startswith(SELECTED) and path != f"{SELECTED}handle":
            changes = set_value(self.stent.draft, path.removeprefix(SELECTED), value)
            values = {SELECTED + name: one for name, one in changes.items()}
        self.change(values)

    def shown(self, path):
        """Value in use at a path, as of a length that a device has; or of another parameter."""
        if hasattr(self, path):
            return getattr(self, path)
        if path.startswith(SELECTED) and path != f"{SELECTED}handle":
            return value_in_use(stentOf(self).draft, path.removeprefix(SELECTED))
        return self.get(path)

    def replaceStents(self, entries, handles, selected):
        """Set all stents, their handles and which of them is selected."""
        count = len(self.get("stents"))
        with slicer.util.NodeModify(self.parameterNode):
            self.change({"stents": entries})
            for number in range(max(count, len(entries))):
                self._refer(handleRole(number), handles[number] if number < len(entries) else None)
            self.selected = selected

    def _refer(self, role, node):
        if self.parameterNode.GetNodeReference(role) is not node:
            self.parameterNode.SetNodeReferenceID(role, node.GetID() if node is not None else None)
            self.parameterNode.Modified()

    def _resolved(self, path):
        return path.replace("stents.selected.", f"stents.{self.selected}.").replace(
            "stents.selected", f"stents.{self.selected}"
        )

    @property
    def stents(self):
        """The plan's stents in order; what is set of them is set in the plan."""
        count = len(self.get("stents"))
        return [Named(self, STENT, f"stents.{number}.") for number in range(count)]

    @property
    def stent(self):
        """Selected stent; where none is, one as by default that keeps nothing."""
        return Named(self, STENT, "stents.selected.")

    @property
    def method(self):
        """The settings of the method, by which the wall follows the stent."""
        return Named(self, METHOD)


def _named(name, field):
    def write(self, value):
        check(name, value)
        self.change({field.path: field.planned(value)})

    return property(lambda self: field.shown(self.get(field.path)), write)


for _name, _field in FLOW.items():
    setattr(SDFStentParameterNode, _name, _named(_name, _field))

_documents = weakref.WeakKeyDictionary()
"""Text and parsed document of each parameter node."""


def documentOf(parameterNode):
    """The document of the plan; nobody may change it."""
    text = parameterNode.plan
    known, document = _documents.get(parameterNode, (None, None))
    if known != text:
        document = json.loads(text) if text else {}
        _documents[parameterNode] = text, document
    return document


# What follows is read once and kept until the node is modified; it is free of the node, and nobody may change it.


def stentsOf(parameterNode):
    """The plan's stents."""
    return _once(parameterNode, "stents", lambda: [_free(stent) for stent in parameterNode.stents])


def stentOf(parameterNode):
    """Edited stent of a parameter node."""
    return _once(parameterNode, "stent", lambda: _free(parameterNode.stent))


def methodOf(parameterNode):
    """The settings of the method, by which the wall follows the stent."""
    return _once(parameterNode, "method", lambda: SimpleNamespace(**parameterNode.method.values()))


def _free(stent):
    return SimpleNamespace(**stent.values(), draft=stent.draft, handle=stent.handle)


_known = weakref.WeakKeyDictionary()
"""Time of modification of each parameter node, and the values read since."""


def _once(parameterNode, name, read):
    node = parameterNode.parameterNode
    if node.GetModifiedEventPending():  # its time does not tell what was set meanwhile
        return read()
    time, values = _known.get(parameterNode, (None, None))
    if time != node.GetMTime():
        time, values = _known[parameterNode] = (node.GetMTime(), {})
    if name not in values:
        values[name] = read()
    return values[name]
