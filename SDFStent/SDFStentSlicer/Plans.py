"""Parameters to library values and back: stents, method settings, and the plan document."""

import json
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import slicer
from slicer.i18n import tr as _

from SDFStentLib import stent as library
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.plan import (
    Marks,
    Plan,
    load_plan,
    placement_document,
    plan_from_document,
    plan_text,
    save_plan,
    stent_entry,
    turned,
    value_at,
)
from SDFStentLib.stent import InputFile, OfStent, OfVessel
from SDFStentLib.validation import InputError, as_place

from . import Conversion, Dependencies, Flow, Handles, Sizes
from .ParameterNode import stentsOf
from .PlanFields import FLOW, METHOD, METHOD_PARAMETERS, RANGES, STENT, Placement
from .Sizes import BY_POINT
from .StentList import StentList


def plannedOf(parameterNode):
    """All stents in order as the library's: a number is that of the saved plan, also where stents above are switched off.

    One that is off may lie nowhere yet; where its sizes do not fit together either it is there by its name.
    """
    return _allPlanned(stentsOf(parameterNode), isPlan=False)


def rowsOf(parameterNode):
    """The rows of the table, from 1, of each of `plannedOf`: one that is dilated again at once is one row."""
    stents = enumerate(stentsOf(parameterNode), start=1)
    return [row for row, stent in stents for _once in range(1 + (stent.redilation > 0))]


def isUnplaced(stent, again=None):
    """Whether it cannot be said yet where a stent lies, or what it is; `again` is the number of the one that it dilates again."""
    isOrphan = stent.placement == Placement.AGAIN and again is None
    return isOrphan or bool(Dependencies.missingOf(stent) or Sizes.refusal(stent))


def _allPlanned(stents, isPlan=True):
    """The library's stents of some parameters, each followed by itself where it is dilated again at once."""
    planned = []
    for stent, again in zip(stents, Sizes.numbersAgain(stents), strict=True):
        isNowhere = not stent.enabled and isUnplaced(stent, again)
        isAgain = stent.redilation > 0
        if isNowhere and not isPlan and Sizes.refusal(stent):
            named = library.Stent(stent.diameter, name=stent.label, enabled=False)
            planned += [named] * (1 + isAgain)
            continue
        own = plannedStent(stent, again, isNowhere)
        planned.append(own)
        if isAgain:
            planned.append(Sizes.dilatedAgain(own, len(planned), stent.redilation))
    return planned


def settingsOf(parameterNode, live=False):
    """The library's settings: those of the last plan, with what the panel shows in their place.

    `live` ones are the library's preview: the same method with longer steps and no finish.
    """
    method = dict(parameterNode.get("settings"))
    method.pop("straightening_fraction", None)
    if not live:
        return DeploymentSettings().with_changes(**method)
    shown = {name: method[name] for name, _one in METHOD_PARAMETERS.values() if name in method}
    preview = DeploymentSettings.preview()
    return preview.with_changes(**{**shown, "step": preview.step})


def planOf(parameterNode, stents=None, hasFiles=True):
    """Everything that determines the result, as the library's plan; of all stents unless some are given.

    Its points are in the frame of the vessel's file, which may not say so itself; in RAS where there is no file, or none is wanted.
    """
    chosen = stentsOf(parameterNode) if stents is None else stents
    vessel, line = parameterNode.vessel, parameterNode.centerline
    surface, centerline = (fileOf(node) if hasFiles else None for node in (vessel, line))
    frame = "RAS" if surface is None else Conversion.fileFrame(vessel)
    return Plan(
        stents=tuple(_inFrame(stent, frame) for stent in _allPlanned(chosen)),
        surface=surface,
        centerline=centerline,
        units="mm" if surface is None else Conversion.fileUnits(vessel),
        frame=frame,
        settings=settingsOf(parameterNode),
        straightening_fraction=parameterNode.get("settings.straightening_fraction"),
        flow=Flow.plannedFlow(parameterNode, lambda place: _placeInFrame(place, frame)),
        **_known(frame, marksOf(parameterNode)),
    )


def marksOf(parameterNode):
    """What the plan says of the vessel, in RAS: the library's `Marks`, a root, places of healthy vessel, and names."""
    return _marksIn(json.dumps(parameterNode.get("inputs")))


@lru_cache(maxsize=8)
def _marksIn(text):
    empty = json.loads(plan_text(Plan()))
    return _marksOf(plan_from_document({**empty, "inputs": json.loads(text)}))


def _marksOf(plan):
    """The marks of a plan, in RAS."""
    root = None if plan.root is None else np.array(plan.root)
    reference = tuple(map(np.array, plan.reference))
    return Marks(root, reference, plan.names, plan.frame).in_frame("RAS")


def setMarks(parameterNode, marks):
    """Set what the plan says of the vessel, in RAS; see `marksOf`."""
    document = json.loads(plan_text(Plan(frame="RAS", **_known("RAS", marks))))["inputs"]
    parameterNode.change({"inputs": document})


def moveMarks(parameterNode, move):
    """Bring what the plan says of the vessel elsewhere: `move` takes points (n, 3) there."""
    marks = marksOf(parameterNode)
    if marks.root is None and not marks.reference and not marks.names:
        return

    def moved(place):
        return move(np.array(place)[None])[0]

    names = [
        one if isinstance(one.at, int) else replace(one, at=as_place(moved(one.at)))
        for one in marks.names
    ]
    root = None if marks.root is None else moved(marks.root)
    setMarks(
        parameterNode,
        marks._replace(root=root, reference=tuple(map(moved, marks.reference)), names=tuple(names)),
    )


def _known(frame, marks):
    """Marks as arguments of a plan in a frame."""
    turned = marks.in_frame(frame)
    return {
        "root": None if turned.root is None else as_place(turned.root),
        "reference": tuple(map(as_place, turned.reference)),
        "names": turned.names,
    }


def save(path, parameterNode):
    """Write the plan document; returns what keeps the command line from replaying it, or ""."""
    save_plan(planOf(parameterNode), path)
    return _withoutFiles(parameterNode)


def load(path, parameterNode):
    """Replace stents and method by those of a plan document; its handles are made, the old ones are nobody's then.

    Returns what there is to know of it, such as that the plan does not say in which frame its points are, or "".
    """
    plan = load_plan(path)
    frame = plan.frame or Conversion.fileFrame(parameterNode.vessel) or "RAS"
    _take(replace(plan, frame=frame), path, parameterNode, {})
    told = []
    if plan.flow is not None and plan.flow.wave is not None:
        told.append(_("Of the wave of the plan's flow the mean and the peak are taken."))
    if plan.frame is None:
        words = _("The plan does not name the frame of its points; {frame} is taken.")
        told.append(words.format(frame=frame))
    return " ".join(told)


def textOf(parameterNode, hasFiles=True):
    """The plan as the text of its document. Raises `InputError` while a stent is not placed."""
    return plan_text(planOf(parameterNode, hasFiles=hasFiles))


def restore(text, parameterNode):
    """Bring back stents and method of such a text, with the handles that there are and new ones for stents that were removed."""
    former = {stent.label: stent for stent in stentsOf(parameterNode)}
    chosen = parameterNode.selected
    with slicer.util.NodeModify(parameterNode):
        _take(plan_from_document(json.loads(text)), _("Plan"), parameterNode, former)
        StentList(parameterNode).select(min(max(chosen, 0), len(parameterNode.stents) - 1))
    left = [stent.handle for stent in stentsOf(parameterNode)]
    for handle in {stent.handle for stent in former.values()}.difference(left):
        Handles.removeHandle(handle)


def _take(plan, path, parameterNode, former):
    """Replace stents and method; handles of `former` stents of the same names are moved to where they belong, others made."""
    rows = _rows(path, plan.stents)
    planned = [_inFrame(row.stent, plan.frame) for row in rows]
    stents = [
        {**valuesOf(stent), "redilation": row.redilation or None}
        for stent, row in zip(planned, rows, strict=True)
    ]
    flow = Flow.documentOf(plan.flow)
    shown = SimpleNamespace(
        get=lambda path: value_at({"settings": plan.method, "flow": flow}, path)
    )
    for number, values in enumerate(stents, start=1):
        _checkRanges(_shownOf(values, STENT), f"{path}: {values['name'] or f'stent {number}'}")
    for fields, name in ((METHOD, "settings"), (FLOW, "flow")):
        found = {key: one.shown(shown.get(one.path)) for key, one in fields.items()}
        _checkRanges(found, f"{path}: {name}")
    for values, stent, row in zip(
        stents, planned, rows, strict=True
    ):  # nothing is refused from here on
        own = former.get(values["name"])
        if row.original is not None:
            values["handle"] = stents[row.original]["handle"]
        elif stent.placement is None and own is not None:  # as it was
            values["handle"], values["placement"] = own.handle, own.entry["placement"]
        else:
            values["handle"] = _handleOf(stent, values["name"], own and own.handle)
    with slicer.util.NodeModify(parameterNode):
        parameterNode.change({"settings": plan.method, "flow": flow})
        setMarks(parameterNode, _marksOf(plan))
        StentList(parameterNode).replace(stents, 0 if stents else -1)


class _Row(NamedTuple):
    """A stent of a plan in the list of the panel."""

    stent: Any
    redilation: float = 0.0
    """To which it is dilated again at once, as the panel does it, mm."""
    original: int | None = None
    """Of one that dilates another again: the row of that one."""


def _rows(path, stents):
    """The stents of a plan as rows of the list; `InputError` for one that dilates again what is not above it."""
    rows, rowOf = [], {}
    for number, stent in enumerate(stents, start=1):
        if not isinstance(stent.placement, OfStent):
            rowOf[number] = len(rows)
            rows.append(_Row(stent))
            continue
        if stent.placement.number not in rowOf:
            raise InputError(
                f"{path}: stent {number}: expected a stent above it to dilate again, got stent "
                f"{stent.placement.number}; name one above it."
            )
        rowOf[number] = original = rowOf[stent.placement.number]
        if _isAtOnce(stent, number, stents, rows):
            rows[-1] = rows[-1]._replace(redilation=stent.inflated_diameter)
        else:
            rows.append(_Row(stent, original=original))
    return rows


def _isAtOnce(stent, number, stents, rows):
    """Whether a stent is what the panel makes of the last row's second diameter."""
    first = number - 1
    if stent.placement.number != first or stents[first - 1] is not rows[-1].stent:
        return False
    try:
        again = library.dilated_again(rows[-1].stent, first, stent.inflated_diameter)
    except InputError:
        return False
    named = (stent.name, Sizes.nameAgain(rows[-1].stent.name), "")
    return stent.name in named[1:] and replace(again, name=stent.name) == stent


def _placeInFrame(place, frame):
    """A place from RAS to a frame, as a tuple."""
    x, y, z = place
    return (-x, -y, z) if frame == "LPS" else (x, y, z)


def _inFrame(planned, frame):
    """A stent from RAS to a frame, or back."""
    return turned(planned) if frame == "LPS" else planned


def _shownOf(entry, fields):
    """The values of an entry as in the panel."""
    return {name: one.shown(entry[one.path]) for name, one in fields.items() if one.path in entry}


def _checkRanges(values, name):
    for key, (low, high, words, unit) in RANGES.items():
        if key in values and not low <= values[key] <= high:
            raise InputError(
                f"{name}: expected {words} of {low:g} to {high:g}{unit} in the panel, got {values[key]:g}; "
                "change the plan, or run it with sdfstent run."
            )


def plannedStent(stent, number=None, isNowhere=False):
    """The library's stent, at no place where it is nowhere; `number` is that of the one which it dilates again."""
    place = None if isNowhere else _placementOf(stent, number)
    planned = Sizes.stentAt(stent, place, stent.label)
    return planned if stent.enabled else replace(planned, enabled=False)


def _placementOf(stent, number):
    if stent.placement == Placement.AGAIN:
        if number is None:
            raise InputError(
                f"{stent.label}: expected a stent above it with the same handle, which it dilates again, got none; choose its handle."
            )
        return OfStent(number)
    if stent.placement.isOfVessel:
        return Sizes.landmarkOf(stent)
    if stent.placement == Placement.ALONG_CURVE:
        return library.AlongAxis(Conversion.curvePoints(stent.handle))
    points = Conversion.handlePoints(stent.handle, stent.placement.pointCount, stent.label)
    if stent.placement == Placement.BETWEEN_POINTS:
        return library.BetweenPoints(*points)
    return BY_POINT[stent.placement](points[0])


def valuesOf(stent):
    """A stent as the entry of the panel's document, still without a handle."""
    kind, _points = _kindAndPoints(stent.placement)
    values = {
        **stent_entry(stent),
        "name": stent.name or "Stent",
        "foreshortening_fraction": stent.foreshortening,
        "device_shortening": stent.foreshortening_fraction is None
        and (stent.device is not None or kind == Placement.AGAIN),
        "placement": placement_document(stent.placement) if kind.isOfVessel else kind.place,
        "whole_curve": stent.length is None,
    }
    if stent.length is None:
        del values["length"]
    return values


def _handleOf(planned, label, former=None):
    kind, points = _kindAndPoints(planned.placement)
    if kind.isOfVessel and Handles.isOwn(former):
        return former  # it follows
    className = Handles.CURVE if kind == Placement.ALONG_CURVE else Handles.POINTS
    if former is not None and Handles.bringTo(former, className, points):
        return former
    return Handles.createHandle(slicer.mrmlScene, label, points, className)


def _kindAndPoints(placement):
    if placement is None:
        return Placement.CENTER, []
    if isinstance(placement, OfVessel):
        return next(kind for kind, one in Sizes.KINDS.items() if isinstance(placement, one)), []
    for kind, cls in BY_POINT.items():
        if isinstance(placement, cls):
            return kind, [placement.point]
    if isinstance(placement, library.BetweenPoints):
        return Placement.BETWEEN_POINTS, [placement.start, placement.end]
    if isinstance(placement, OfStent):
        return Placement.AGAIN, []
    return Placement.ALONG_CURVE, placement.points


def fileOf(node):
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
    if any(stent.placement.needsCenterline for stent in parameterNode.stents):
        nodes.append(parameterNode.centerline)
    homeless = [node for node in nodes if node is not None and fileOf(node) is None]
    if not homeless:
        return ""
    advice = dict.fromkeys(_towardFile(node) for node in homeless)  # each once, in order
    return _(
        "The plan is saved without a file of {names}: sdfstent run cannot replay it; to change that, {advice}, then save "
        "the plan again."
    ).format(names=_(" and ").join(node.GetName() for node in homeless), advice=", ".join(advice))


def _towardFile(node):
    if node.IsA("vtkMRMLSegmentationNode"):
        return _("export the segment as a model and choose that")
    if not node.IsA("vtkMRMLModelNode"):
        return _("choose a centerline model")
    if node.GetParentTransformNode() is not None:
        return _("harden the transform of {name} and save the scene").format(name=node.GetName())
    return _("save the scene first")
