"""Parameters to library values and back: stents, method settings, and the plan document."""

import json
from functools import lru_cache

import slicer

from SDFStentLib import placement as library
from SDFStentLib.deployment import DeploymentSettings
from SDFStentLib.plan import InputFile, Plan, PlannedStent
from SDFStentLib.plan_document import plan_text, save_plan
from SDFStentLib.plan_reader import load_plan, plan_from_document
from SDFStentLib.stent import Stent
from SDFStentLib.validation import InputError

from . import Conversion, Handles
from .ParameterNode import MethodParameters, Placement
from .StentList import StentList

BY_POINT = {
    Placement.CENTER: library.AtCenter,
    Placement.DISTAL_END: library.AtDistalEnd,
    Placement.PROXIMAL_END: library.AtProximalEnd,
}


def plannedOf(parameterNode):
    """The stents that are switched on, in order, as the library's planned stents."""
    return [_plannedOf(stent) for stent in parameterNode.stents if stent.enabled]


def settingsOf(parameterNode, live=False):
    """The library's settings: those of the last plan, with what the panel shows in their place.

    `live` ones are the library's preview: the same method with longer steps and no finish.
    """
    method = parameterNode.method
    settings = (
        DeploymentSettings.preview() if live else _plannedSettings(parameterNode.planDocument)
    )
    changes = {
        "influence_distance": method.influenceDistance,
        "smoothing_width": method.smoothingWidth,
        "capsule_length": method.capsuleLength,
        "tissue_gap": method.tissueGap,
        "falloff": method.falloff,
        "rule": method.rule,
    }
    if not live:
        changes["step"] = method.step or None
    return settings.with_changes(**changes)


def planOf(parameterNode):
    """Everything that determines the result, as the library's plan in RAS."""
    stents = [
        PlannedStent(_stentOf(s), name=s.label, enabled=s.enabled) for s in parameterNode.stents
    ]
    return Plan(
        stents=tuple(stents),
        surface=_fileOf(parameterNode.vessel),
        centerline=_fileOf(parameterNode.centerline),
        frame="RAS",
        settings=settingsOf(parameterNode),
        straightening_fraction=parameterNode.method.straightening / 100,
    )


def remember(parameterNode):
    """Keep the plan's document in the parameter node."""
    parameterNode.planDocument = plan_text(planOf(parameterNode))


def save(path, parameterNode):
    """Write the plan document."""
    save_plan(planOf(parameterNode), path)


def load(path, parameterNode):
    """Replace stents and method by those of a plan document; its handles are made, the old ones stay in the scene."""
    plan = load_plan(path)
    if plan.frame == "LPS":
        raise InputError(f"Plan {path}: expected points in RAS, got LPS; save the plan in RAS.")
    stents = [_valuesOf(planned) for planned in plan.stents]
    settings = plan.settings
    with slicer.util.NodeModify(parameterNode):
        parameterNode.method = MethodParameters(
            influenceDistance=settings.influence_distance,
            smoothingWidth=settings.smoothing_width,
            capsuleLength=settings.capsule_length,
            tissueGap=settings.tissue_gap,
            falloff=settings.falloff,
            rule=settings.rule,
            step=settings.step or 0.0,
            straightening=100 * plan.straightening_fraction,
        )
        parameterNode.planDocument = plan_text(plan)
        StentList(parameterNode).replace(stents, 0 if stents else -1)


@lru_cache(maxsize=8)
def _plannedSettings(document):
    return plan_from_document(json.loads(document)).settings if document else DeploymentSettings()


def _plannedOf(stent):
    return PlannedStent(_stentOf(stent), name=stent.label, enabled=stent.enabled)


def _stentOf(stent):
    hasLength = not stent.placement.usesHandleLength or (
        stent.placement == Placement.ALONG_CURVE and not stent.wholeCurve
    )
    return Stent(
        stent.diameter,
        placement=_placementOf(stent),
        length=stent.length if hasLength else None,
        foreshortening_fraction=stent.foreshortening / 100,
    )


def _placementOf(stent):
    if stent.placement == Placement.ALONG_CURVE:
        return library.AlongAxis(Conversion.curvePoints(stent.handle))
    points = Conversion.handlePoints(stent.handle, stent.placement.pointCount, stent.label)
    if stent.placement == Placement.BETWEEN_POINTS:
        return library.BetweenPoints(*points)
    return BY_POINT[stent.placement](points[0])


def _valuesOf(planned):
    """A planned stent as the values of a `StentParameters`, with a new handle."""
    stent, label = planned.stent, planned.name or "Stent"
    kind, points = _kindAndPoints(stent.placement)
    values = {
        "label": label,
        "enabled": planned.enabled,
        "diameter": stent.diameter,
        "foreshortening": 100 * stent.foreshortening,
        "placement": kind,
        "wholeCurve": stent.length is None,
        "handle": Handles.createHandle(
            slicer.mrmlScene, label, points, isCurve=kind == Placement.ALONG_CURVE
        ),
    }
    return values if stent.length is None else {**values, "length": stent.length}


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
