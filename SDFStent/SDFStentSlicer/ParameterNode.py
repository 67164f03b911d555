"""The module's typed parameters: everything a user chooses, stored in the scene."""

import enum
import weakref
from types import SimpleNamespace
from typing import Annotated, NamedTuple, Optional, Union

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
from slicer.parameterNodeWrapper import Choice, WithinRange, parameterNodeWrapper, parameterPack

from SDFStentLib.flow import Known
from SDFStentLib.parameter import parameters_of
from SDFStentLib.plan import Plan, method_parameters
from SDFStentLib.stent import Stent
from SDFStentLib.treatment import LONGEST_MARGIN, RATIOS, SizingWishes


class Placement(enum.Enum):
    """What the points of a stent's handle mean."""

    CENTER = "center"
    DISTAL_END = "distal"
    PROXIMAL_END = "proximal"
    BETWEEN_POINTS = "between"
    ALONG_CURVE = "axis"
    AGAIN = "again"
    AT_LESION = "lesion"
    ON_BRANCH = "branch"

    def label(self):
        """The text in the panel."""
        return {
            Placement.CENTER: _("Middle at a point"),
            Placement.DISTAL_END: _("Distal end at a point"),
            Placement.PROXIMAL_END: _("Proximal end at a point"),
            Placement.BETWEEN_POINTS: _("Between two points"),
            Placement.ALONG_CURVE: _("Along a curve"),
            Placement.AGAIN: _("Dilates a stent again"),
            Placement.AT_LESION: _("At a lesion"),
            Placement.ON_BRANCH: _("On a branch"),
        }[self]

    @property
    def usesHandleLength(self):
        """Whether the handle alone says how long the stent is."""
        return self in (Placement.BETWEEN_POINTS, Placement.ALONG_CURVE, Placement.AGAIN)

    @property
    def isOfVessel(self):
        """Whether what the vessel has says where the stent is, and the handle follows."""
        return self in (Placement.AT_LESION, Placement.ON_BRANCH)

    @property
    def needsCenterline(self):
        """Whether the axis is that of the centerline."""
        return self not in (Placement.ALONG_CURVE, Placement.AGAIN)

    @property
    def pointCount(self):
        """How many placed points the handle needs."""
        return 2 if self in (Placement.BETWEEN_POINTS, Placement.ALONG_CURVE) else 1


class SurfaceMap(enum.Enum):
    """What colors the stented vessel."""

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


def _fieldOf(name):
    first, *others = name.split("_")
    return first + "".join(map(str.capitalize, others))


def _inWords(name):
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name.replace('_', ' ')}"


class Range(NamedTuple):
    """What a number may be, in the library as in the panel, and how it is called."""

    low: float
    high: float
    words: str
    unit: str = " mm"


METHOD_PARAMETERS = {
    _fieldOf(name): (name, one)
    for name, one in method_parameters().items()
    if one.option and (one.names or one.unit)
}
"""By field of `MethodParameters`: name and `Parameter` of what the panel shows of the method as the library has it."""

_OF_STENT = parameters_of(Stent)
_SHORTENING = _OF_STENT["foreshortening_fraction"]

RANGES = {
    "diameter": Range(0.1, _OF_STENT["diameter"].most, "a diameter"),
    "length": Range(0.1, _OF_STENT["length"].most, "a length"),
    "foreshortening": Range(
        100 * _SHORTENING.least, 100 * _SHORTENING.most, "a foreshortening", " %"
    ),
    "redilation": Range(0.0, _OF_STENT["diameter"].most, "a redilation"),
    **{
        field: Range(0.0 if one.is_optional else one.lowest, one.most, _inWords(name))
        for field, (name, one) in METHOD_PARAMETERS.items()
        if one.unit
    },
    "straightening": Range(0.0, 100.0, "a straightening", " %"),
    "flowMean": Range(0.0, 60.0, "a mean flow", " L/min"),
    "flowPeak": Range(0.0, 200.0, "a peak flow", " L/min"),
    "inletPressure": Range(0.0, 300.0, "a pressure at the inlet", " mmHg"),
    "wedgePressure": Range(0.0, 300.0, "a wedge pressure", " mmHg"),
    "splitRight": Range(0.0, 99.0, "a share of the flow to the right", " %"),
    "flowBsa": Range(0.0, parameters_of(Known)["bsa"].most, "a body surface area", " m2"),
    "suggestRatio": Range(*RATIOS, "a ratio to the adjacent vessel", ""),
    "suggestMargin": Range(0.0, LONGEST_MARGIN, "a margin"),
}


def _within(name):
    return WithinRange(RANGES[name].low, RANGES[name].high)


CHOICE_LABELS = {
    "rule": {"events": _("adaptive"), "published": _("as in the paper")},
    "falloff": {
        "compact": _("gradual (as in the paper)"),
        "wendland": _("steep (Wendland)"),
        "cosine": _("gradual (half cosine)"),
    },
    "blend": {
        "linear": _("gradual (as in the paper)"),
        "quadratic": _("steeper (quadratic)"),
        "exponential": _("steepest (exponential)"),
    },
}
"""The texts in the panel for the library's keys, by parameter."""

REMEDIES = {
    "foreshortening": _(" (in Device, untick As known of the device or move Foreshortening)"),
    "unusual": _(" (in Flow, tick Unusual flow is meant so)"),
}
"""What the library's sentences advise, as the panel calls it."""


# Node types are written Optional[X], not X | None: Python before 3.11.7 takes one for the other inside of Annotated, and Slicer
# then finds no connector for the selector.


@parameterPack
class StentParameters:
    """One stent of the plan. Sizes in mm; foreshortening in percent, as on screen.

    `details` is what there is beyond them (device, balloon, kept end, shape), as the library's `StentDetails` keeps it.
    With `deviceShortening` the device says how much shorter it becomes. `redilation` is the diameter to which the same stent is
    dilated at once after it, of the second balloon where it has a balloon; 0 for none. With the placement `AGAIN` it is no stent of its
    own: it dilates the one above it that has the same handle, as that lies by then. `landmark` is where it is at a lesion or on a branch,
    as the placement of a plan's document.
    """

    label: str = "Stent"
    enabled: bool = True
    diameter: Annotated[float, _within("diameter")] = 8.0
    length: Annotated[float, _within("length")] = 20.0
    foreshortening: Annotated[float, _within("foreshortening")] = 10.0
    placement: Placement = Placement.CENTER
    wholeCurve: bool = True
    details: str = ""
    deviceShortening: bool = False
    redilation: Annotated[float, _within("redilation")] = 0.0
    landmark: str = ""
    handle: Union[vtkMRMLMarkupsFiducialNode, vtkMRMLMarkupsCurveNode, None]


def _methodFields():
    """What `MethodParameters` declares: annotations, and the library's defaults. A step of 0 stands for the rule's own."""
    kinds, defaults = {}, Plan().method
    for field, (_name, one) in METHOD_PARAMETERS.items():
        kinds[field] = (
            Annotated[str, Choice(list(one.names))]
            if one.names
            else Annotated[float, _within(field)]
        )
    values = {field: defaults[name] or 0.0 for field, (name, _one) in METHOD_PARAMETERS.items()}
    kinds["straightening"], values["straightening"] = (
        Annotated[float, _within("straightening")],
        0.0,
    )
    return {"__doc__": "How the wall follows the stent.", "__annotations__": kinds, **values}


MethodParameters = parameterPack(type("MethodParameters", (), _methodFields()))


@parameterNodeWrapper
class SDFStentParameterNode:
    """Inputs, the plan, what is shown, and the nodes that hold the results.

    `stents` is the plan's ordered list; `stent` is the selected one while it is edited, kept equal to `stents[selected]` by
    `StentList`. `tiles` is the result at a glance, as JSON: the library's `Tile` as lists.
    """

    vessel: Union[vtkMRMLModelNode, vtkMRMLSegmentationNode, None]
    segmentID: str = ""
    centerline: Union[vtkMRMLModelNode, vtkMRMLMarkupsCurveNode, None]

    stents: list[StentParameters]
    selected: int = -1
    stent: StentParameters
    deviceTable: str = ""
    suggestRatio: Annotated[float, _within("suggestRatio")] = SizingWishes().ratio
    suggestMargin: Annotated[float, _within("suggestMargin")] = SizingWishes().margin
    method: MethodParameters

    autoUpdate: bool = True
    expansion: Annotated[float, WithinRange(0.0, 100.0)] = 100.0
    map: SurfaceMap = SurfaceMap.NONE
    flowMean: Annotated[float, _within("flowMean")] = 0.0
    flowPeak: Annotated[float, _within("flowPeak")] = 0.0
    inletPressure: Annotated[float, _within("inletPressure")] = 0.0
    wedgePressure: Annotated[float, _within("wedgePressure")] = 0.0
    splitRight: Annotated[float, _within("splitRight")] = 0.0
    flowWave: str = ""
    """That of a plan, as JSON, its times and flows; it counts while mean and peak are its own."""
    flowInlets: str = ""
    """As JSON, names, flows and waves; scaled to the mean flow."""
    flowBsa: Annotated[float, _within("flowBsa")] = 0.0
    """Body surface area, m2; 0 for none."""
    flowUnusual: bool = False
    """Whether a heart rate or a flow beyond the usual ones is meant so."""
    rightBranch: str = ""
    """A place in it, mm in RAS, as JSON, once the flow was found."""
    showStents: bool = True
    showDevice: bool = False
    deviceMesh: Optional[vtkMRMLModelNode]
    segmentEnds: Union[
        vtkMRMLMarkupsFiducialNode, vtkMRMLMarkupsLineNode, vtkMRMLMarkupsCurveNode, None
    ]
    closeBranches: bool = False

    outputVessel: Optional[vtkMRMLModelNode]
    outputCenterline: Optional[vtkMRMLModelNode]
    outputStents: Optional[vtkMRMLModelNode]
    outputTable: Optional[vtkMRMLTableNode]
    outputTexts: Optional[vtkMRMLTableNode]
    """The same to be read: a table view has "nan" for a number that is not known."""
    outputChart: Optional[vtkMRMLPlotChartNode]

    status: str = ""
    """What the last click said."""
    lumenSummary: str = ""
    certificateSummary: str = ""
    warningSummary: str = ""
    tiles: str = ""
    atHand: str = ""
    """What the 3D view tells of the selected stent, line by line."""
    planDocument: str = ""


STENT_FIELDS = tuple(StentParameters.allParameters)


# The node looks up every single value in its texts when it is asked for. What follows is read once and kept until the node is
# modified; it is free of the node, and nobody may change it.


def stentsOf(parameterNode):
    """The plan's stents."""
    return _once(
        parameterNode,
        "stents",
        lambda: [SimpleNamespace(**stentValues(stent)) for stent in parameterNode.stents],
    )


def stentOf(parameterNode):
    """The stent that is edited."""
    return _once(
        parameterNode, "stent", lambda: SimpleNamespace(**stentValues(parameterNode.stent))
    )


def methodOf(parameterNode):
    """How the wall follows the stent."""
    return _once(
        parameterNode,
        "method",
        lambda: SimpleNamespace(
            **{name: getattr(parameterNode.method, name) for name in MethodParameters.allParameters}
        ),
    )


_known = weakref.WeakKeyDictionary()
"""By parameter node: its time of modification, and what was read since."""


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


def stentValues(stent):
    """The values of a stent as a dictionary, free of the node it may live in."""
    return {name: getattr(stent, name) for name in STENT_FIELDS}
