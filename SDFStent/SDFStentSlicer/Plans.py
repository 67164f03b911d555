"""Parameters to library values and back: stents, method settings, and the plan document."""

import json
from dataclasses import replace
from functools import lru_cache

import slicer
from slicer.i18n import tr as _

from SDFStentLib import stent as library
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.plan import (
    Plan,
    load_plan,
    plan_from_document,
    plan_text,
    save_plan,
    stent_details,
    turned,
)
from SDFStentLib.stent import InputFile, OfStent
from SDFStentLib.validation import InputError

from . import Conversion, Dependencies, Flow, Handles, Sizes
from .ParameterNode import RANGES, MethodParameters, Placement, methodOf, stentsOf
from .Sizes import BY_POINT
from .StentList import StentList


def plannedOf(parameterNode):
    """The stents that are switched on, in order, as the library's stents."""
    return _allPlanned([stent for stent in stentsOf(parameterNode) if stent.enabled])


def _allPlanned(stents):
    """The library's stents of some parameters, with those that are dilated again."""
    redilations = [stent.redilation for stent in stents]
    return Sizes.withRedilations([plannedStent(stent) for stent in stents], redilations)


def settingsOf(parameterNode, live=False):
    """The library's settings: those of the last plan, with what the panel shows in their place.

    `live` ones are the library's preview: the same method with longer steps and no finish.
    """
    method = methodOf(parameterNode)
    settings = (
        DeploymentSettings.preview() if live else _plannedSettings(parameterNode.planDocument)
    )
    changes = {
        "influence_distance": method.influenceDistance,
        "smoothing_width": method.smoothingWidth,
        "capsule_length": method.capsuleLength,
        "tissue_gap": method.tissueGap,
        "axis_smoothing": method.axisSmoothing,
        "falloff": method.falloff,
        "blend": method.blend,
        "rule": method.rule,
    }
    if not live:
        changes["step"] = method.step or None
    return settings.with_changes(**changes)


def planOf(parameterNode, stents=None):
    """Everything that determines the result, as the library's plan; of all stents unless some are given.

    Its points are in the frame of the vessel's file, which may not say so itself; in RAS where there is no file.
    """
    chosen = stentsOf(parameterNode) if stents is None else stents
    surface = _fileOf(parameterNode.vessel)
    frame = "RAS" if surface is None else Conversion.fileFrame(parameterNode.vessel)
    return Plan(
        stents=tuple(_inFrame(stent, frame) for stent in _allPlanned(chosen)),
        surface=surface,
        centerline=_fileOf(parameterNode.centerline),
        frame=frame,
        settings=settingsOf(parameterNode),
        straightening_fraction=parameterNode.method.straightening / 100,
        flow=Flow.flowOf(parameterNode),
    )


def remember(parameterNode):
    """Keep the plan's document in the parameter node; without stents that are switched off and cannot be placed yet."""
    placed = [
        stent
        for stent in stentsOf(parameterNode)
        if not (Dependencies.missingOf(stent) or Sizes.refusal(stent))
    ]
    parameterNode.planDocument = plan_text(planOf(parameterNode, placed))


def save(path, parameterNode):
    """Write the plan document; returns what keeps the command line from replaying it, or ""."""
    save_plan(planOf(parameterNode), path)
    return _withoutFiles(parameterNode)


def load(path, parameterNode):
    """Replace stents and method by those of a plan document; its handles are made, the old ones stay in the scene.

    Returns a sentence when the plan does not say in which frame its points are, else "".
    """
    plan = load_plan(path)
    frame = plan.frame or Conversion.fileFrame(parameterNode.vessel) or "RAS"
    firsts, redilations = _redilated(path, plan.stents)
    planned = [_inFrame(stent, frame) for stent in firsts]
    stents = [
        {**valuesOf(stent), "redilation": diameter}
        for stent, diameter in zip(planned, redilations, strict=True)
    ]
    method, flow = _methodOf(plan), Flow.valuesOf(plan)
    for number, values in enumerate(stents, start=1):
        _checkRanges(values, f"{path}: {values['label'] or f'stent {number}'}")
    _checkRanges(method, f"{path}: settings")
    _checkRanges(flow, f"{path}: flow")
    for values, stent in zip(stents, planned, strict=True):  # nothing is refused from here on
        values["handle"] = _handleOf(stent, values["label"])
    with slicer.util.NodeModify(parameterNode):
        parameterNode.method = MethodParameters(**method)
        for name, value in flow.items():
            setattr(parameterNode, name, value)
        parameterNode.planDocument = plan_text(plan)
        StentList(parameterNode).replace(stents, 0 if stents else -1)
    if plan.frame is not None:
        return ""
    return _("The plan does not name the frame of its points; {frame} is taken.").format(
        frame=frame
    )


def _redilated(path, stents):
    """The stents of a plan without those that dilate one before them again, and to what these do it, mm; else 0.

    Raises `InputError` for a redilation that the panel cannot have.
    """
    firsts, redilations = [], []
    for number, stent in enumerate(stents, start=1):
        if not isinstance(stent.placement, OfStent):
            firsts.append(stent)
            redilations.append(0.0)
            continue
        diameter = stent.diameter if stent.balloon is None else stent.balloon.diameter
        first = number - 1  # only that one, only once, and as the panel would
        if stent.placement.number != first or stents[first - 1] is not firsts[-1]:
            raise _unknownRedilation(path, number, stent)
        if replace(library.dilated_again(firsts[-1], first, diameter), name=stent.name) != stent:
            raise _unknownRedilation(path, number, stent)
        redilations[-1] = diameter
    return firsts, redilations


def _unknownRedilation(path, number, stent):
    return InputError(
        f"{path}: stent {number} dilates stent {stent.placement.number} again in a way that the panel does not have: expected it "
        "right behind that one and with its balloon and recoil; leave it out of the plan, or run it with sdfstent run."
    )


def _inFrame(planned, frame):
    """A stent from RAS to a frame, or back."""
    return turned(planned) if frame == "LPS" else planned


def _methodOf(plan):
    """The plan's settings as the values of `MethodParameters`."""
    settings = plan.settings
    return {
        "influenceDistance": settings.influence_distance,
        "smoothingWidth": settings.smoothing_width,
        "capsuleLength": settings.capsule_length,
        "tissueGap": settings.tissue_gap,
        "axisSmoothing": settings.axis_smoothing,
        "falloff": settings.falloff,
        "blend": settings.blend,
        "rule": settings.rule,
        "step": settings.step or 0.0,
        "straightening": 100 * plan.straightening_fraction,
    }


def _checkRanges(values, name):
    for key, (low, high, words, unit) in RANGES.items():
        if key in values and not low <= values[key] <= high:
            raise InputError(
                f"{name}: expected {words} of {low:g} to {high:g}{unit} in the panel, got {values[key]:g}; "
                "change the plan, or run it with sdfstent run."
            )


@lru_cache(maxsize=8)
def _plannedSettings(document):
    return plan_from_document(json.loads(document)).settings if document else DeploymentSettings()


def plannedStent(stent):
    """The library's stent."""
    planned = Sizes.stentAt(stent, _placementOf(stent), stent.label)
    return planned if stent.enabled else replace(planned, enabled=False)


def _placementOf(stent):
    if stent.placement == Placement.ALONG_CURVE:
        return library.AlongAxis(Conversion.curvePoints(stent.handle))
    points = Conversion.handlePoints(stent.handle, stent.placement.pointCount, stent.label)
    if stent.placement == Placement.BETWEEN_POINTS:
        return library.BetweenPoints(*points)
    return BY_POINT[stent.placement](points[0])


def valuesOf(stent):
    """A stent as the values of a `StentParameters`, still without a handle."""
    kind, _points = _kindAndPoints(stent.placement)
    values = {
        "details": stent_details(stent),
        "label": stent.name or "Stent",
        "enabled": stent.enabled,
        "diameter": stent.diameter,
        "foreshortening": 100 * stent.foreshortening,
        "deviceShortening": stent.device is not None and stent.foreshortening_fraction is None,
        "placement": kind,
        "wholeCurve": stent.length is None,
    }
    return values if stent.length is None else {**values, "length": stent.length}


def _handleOf(planned, label):
    kind, points = _kindAndPoints(planned.placement)
    className = Handles.CURVE if kind == Placement.ALONG_CURVE else Handles.POINTS
    return Handles.createHandle(slicer.mrmlScene, label, points, className)


def _kindAndPoints(placement):
    for kind, cls in BY_POINT.items():
        if isinstance(placement, cls):
            return kind, [placement.point]
    if isinstance(placement, library.BetweenPoints):
        return Placement.BETWEEN_POINTS, [placement.start, placement.end]
    return Placement.ALONG_CURVE, placement.points


def _fileOf(node):
    """The file that a model came from, when the plan can be replayed with it; else None."""
    if (
        node is None
        or not node.IsA("vtkMRMLModelNode")
        or node.GetParentTransformNode() is not None
    ):
        return None
    storage = node.GetStorageNode()
    if storage is None or not storage.GetFileName() or node.GetModifiedSinceRead():
        return None
    return InputFile(storage.GetFullNameFromFileName())


def _withoutFiles(parameterNode):
    """A sentence about inputs of the plan that are in no file, and how to change that; "" when all are."""
    nodes = [parameterNode.vessel]
    if any(stent.placement != Placement.ALONG_CURVE for stent in parameterNode.stents):
        nodes.append(parameterNode.centerline)
    homeless = [node for node in nodes if node is not None and _fileOf(node) is None]
    if not homeless:
        return ""
    advice = dict.fromkeys(_towardsFile(node) for node in homeless)  # each once, in order
    return _(
        "The plan is saved without a file of {names}: sdfstent run cannot replay it; to change that, {advice}, then save "
        "the plan again."
    ).format(names=_(" and ").join(node.GetName() for node in homeless), advice=", ".join(advice))


def _towardsFile(node):
    if node.IsA("vtkMRMLSegmentationNode"):
        return _("export the segment as a model and choose that")
    if not node.IsA("vtkMRMLModelNode"):
        return _("choose a centerline model")
    if node.GetParentTransformNode() is not None:
        return _("harden the transform of {name} and save the scene").format(name=node.GetName())
    return _("save the scene first")
