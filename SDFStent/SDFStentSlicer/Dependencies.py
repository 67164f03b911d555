"""Inputs of a deployment: the nodes, what is missing, and whether anything has changed."""

from typing import NamedTuple

import slicer
from slicer.i18n import tr as _

from SDFStentLib.plan import numbers_again

from . import Conversion, Flow
from .ParameterNode import methodOf, stentsOf
from .PlanFields import REMEDIES, Placement


class Standing(NamedTuple):
    """State with which a deployment would begin now."""

    missing: str
    """Sentence on what has to be chosen before; "" when nothing is."""
    signature: tuple
    """A value that differs whenever the result would."""


def standing(parameterNode):
    """The `Standing` of a parameter node; changes nothing."""
    numbered = [(n, stent) for n, stent in enumerate(stentsOf(parameterNode)) if stent.enabled]
    stents = [stent for _number, stent in numbered]
    return Standing(_missing(parameterNode, stents), _signature(parameterNode, numbered))


def areOfTwoVessels(one, other):
    """Whether two signatures are of different vessels, or one has changed: no number of one is of the other."""
    return one[0][:2] != other[0][:2]


def inputNodes(parameterNode):
    """Nodes that the result depends on."""
    handles = [stent.handle for stent in stentsOf(parameterNode)]
    nodes = [parameterNode.vessel, parameterNode.centerline, *handles]
    return [node for i, node in enumerate(nodes) if node is not None and node not in nodes[:i]]


def missing(parameterNode):
    """Sentence on what has to be chosen before Deploy; "" when nothing is. Changes nothing."""
    return standing(parameterNode).missing


def _missing(parameterNode, stents):
    needsCenterline = any(stent.placement.needsCenterline for stent in stents)
    if parameterNode.vessel is None:
        return _("Select a vessel: a surface model or a segmentation.")
    if parameterNode.centerline is None and (needsCenterline or not stents):
        if stents:
            return _("Select a centerline, or make one.")
        return _("Select a centerline, or make one; or add a stent along a curve of your own.")
    if not stents:
        return _("Add a stent, or switch one on.")
    missing = next(filter(None, map(missingOf, stents)), "") or _missingAgain(stents)
    return missing or _refusal(stents) or Flow.refusal(parameterNode)


def _missingAgain(stents):
    """Sentence on the first stent switched on that has none above it to dilate again."""
    again = numbers_again([one.draft for one in stents], [one.handle for one in stents])
    for stent, number in zip(stents, again, strict=True):
        if stent.placement == Placement.AGAIN and number is None:
            return _(
                "{label}: choose the handle of the stent that it dilates again, which has to be above it and switched on."
            ).format(label=stent.label)
    return ""


def _refusal(stents):
    """The first stent whose sizes do not fit together, as a sentence; "" when all do."""
    for stent in stents:
        if stent.draft.refusal is not None:
            sentence = stent.draft.refusal.sentence(REMEDIES)
            return _("{label}: {sentence}").format(label=stent.label, sentence=sentence)
    return ""


def missingOf(stent):
    """Sentence on what a stent's handle lacks; "" when it says where the stent goes."""
    if stent.placement.isOfVessel:
        words = _("{label}: choose a lesion, or a branch.").format(label=stent.label)
        return words if stent.draft.place is None else ""
    if stent.handle is None:
        return _("{label}: choose a handle.").format(label=stent.label)
    if stent.placement == Placement.ALONG_CURVE and not stent.handle.IsA("vtkMRMLMarkupsCurveNode"):
        return _(
            "{label}: choose a markups curve as its handle, or create a new one there and draw it with Place."
        ).format(label=stent.label)
    count = stent.handle.GetNumberOfDefinedControlPoints()
    if stent.placement == Placement.ALONG_CURVE and count < stent.placement.pointCount:
        return _(
            "{label}: click along its axis into a view, at two places at least; Esc ends that."
        ).format(label=stent.label)
    if count < stent.placement.pointCount:
        return _("{label}: place {count} point(s) of its handle in a view.").format(
            label=stent.label, count=stent.placement.pointCount
        )
    return ""


def leave(parameterNode, node):
    """Release a node before it is deleted, lest a selector take its neighbor in the list for the user's choice."""
    with slicer.util.NodeModify(parameterNode):
        for role in ("vessel", "centerline", "outputVessel", "deviceMesh"):
            if getattr(parameterNode, role) is node:
                setattr(parameterNode, role, None)
        if parameterNode.stent.handle is node:
            parameterNode.stent.handle = None


def chooseSegment(parameterNode):
    """Choose the first segment of a vessel that is a segmentation without the chosen segment."""
    vessel = parameterNode.vessel
    if vessel is None or not vessel.IsA("vtkMRMLSegmentationNode"):
        return
    known = vessel.GetSegmentation().GetSegmentIDs()
    if parameterNode.segmentID not in known:
        parameterNode.segmentID = known[0] if known else ""


def places(parameterNode):
    """Index in the list and handle's ID of every stent switched on, by which it is found again when the list has changed.

    Twice in a row for one that is dilated again.
    """
    return [
        (index, stent.handle.GetID() if stent.handle is not None else None)
        for index, stent in enumerate(stentsOf(parameterNode))
        if stent.enabled
        for _once in range(2 if stent.redilation > 0 else 1)
    ]


def _signature(parameterNode, numbered):
    return (
        Conversion.inputStamp(parameterNode),
        str(parameterNode.get("inputs")),
        tuple(vars(methodOf(parameterNode)).values()),
        # Its number is a part of what is told of a stent.
        tuple(
            (number, stent.label, stent.draft.text, _placeOf(stent)) for number, stent in numbered
        ),
    )


def _placeOf(stent):
    if stent.placement.isOfVessel:
        return str(stent.draft.entry["placement"])
    return Conversion.changeStamp(stent.handle)
