"""The plan of a parameter node as the library's: its document, with places by the handles and files by the nodes."""

import json
from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import slicer
from slicer.i18n import tr as _

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.plan import (
    Case,
    Plan,
    flow_entry,
    load_plan,
    numbers_again,
    plan_from_document,
    plan_text,
    rows_from,
    rows_of,
    save_plan,
    stents_of,
    value_at,
    views_entry,
    views_of,
)
from SDFStentLib.validation import InputError, as_place

from . import Conversion, Dependencies, Flow, Handles
from .ParameterNode import stentsOf
from .PlanFields import FLOW, METHOD, METHOD_PARAMETERS, RANGES, STENT, Placement
from .StentList import StentList


def plannedOf(parameterNode):
    """Stents in order as the library's: a number is that of the saved plan, also where stents above are switched off.

    One that is off may lie nowhere yet; where its sizes do not fit together either it is there by its name.
    """
    return _planned(stentsOf(parameterNode), has_named=True)


def caseOf(parameterNode, vessel, live=False, **how):
    """The library's `Case` of all stents in its `Vessel`; `live` for a preview."""
    plan = Plan(
        stents=tuple(plannedOf(parameterNode)),
        settings=settingsOf(parameterNode, live),
        straightening_fraction=parameterNode.get("settings.straightening_fraction"),
    )
    rows = rows_of([stent.draft for stent in stentsOf(parameterNode)])
    return Case(vessel, plan, "RAS", rows=rows, **how)


def _planned(stents, has_named=False):
    drafts = [stent.draft for stent in stents]
    again = numbers_again(drafts, [stent.handle for stent in stents])
    places = [placeOf(stent, number) for stent, number in zip(stents, again, strict=True)]
    return stents_of(drafts, places, has_named)


def placeOf(stent, again=None):
    """Place of a stent, in RAS, as in the document of a whole plan; None for one that is off and lies nowhere yet.

    `again` is the number of the one that it dilates again. Raises `InputError` where it cannot be said yet.
    """
    if not stent.enabled and _isUnplaced(stent, again):
        return None
    kind, handle = stent.placement, stent.handle
    if kind == Placement.AGAIN:
        if again is None:
            raise InputError(
                f"{stent.label}: expected a stent above it with the same handle, which it dilates again, got none; choose its handle."
            )
        return {"stent": again}
    if kind.isOfVessel:
        return stent.draft.entry["placement"]
    if kind == Placement.ALONG_CURVE:
        return {"axis": {"points": Conversion.curvePoints(handle)}}
    points = Conversion.handlePoints(handle, kind.pointCount, stent.label)
    return dict(zip(kind.place, points, strict=True))


def _isUnplaced(stent, again):
    """Whether it cannot be said yet where a stent lies; `again` is the number of the one that it dilates again."""
    isOrphan = stent.placement == Placement.AGAIN and again is None
    return isOrphan or bool(Dependencies.missingOf(stent))


def plannedStent(stent):
    """The library's stent, by its own place. Raises `InputError` where it has none, or its sizes do not fit together."""
    return stent.draft.at(placeOf(stent))


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
    Without files it is what the user has set: the place of the right branch, which a deployment finds, is none of it either.
    """
    chosen = stentsOf(parameterNode) if stents is None else stents
    vessel, line = parameterNode.vessel, parameterNode.centerline
    surface, centerline = (fileOf(node) if hasFiles else None for node in (vessel, line))
    plan = Plan(
        stents=tuple(_planned(chosen)),
        frame="RAS",
        units="mm" if surface is None else Conversion.fileUnits(vessel),
        settings=settingsOf(parameterNode),
        straightening_fraction=parameterNode.get("settings.straightening_fraction"),
        flow=Flow.plannedFlow(parameterNode, isFound=hasFiles),
        views=views_of(parameterNode.get("views")),
    )
    frame = "RAS" if surface is None else Conversion.fileFrame(vessel)
    return plan.marked(marksOf(parameterNode)).of_files(surface, centerline).in_frame(frame)


def marksOf(parameterNode):
    """Marks of the plan on the vessel, in RAS: the library's `Marks`, a root, places of healthy vessel, and names."""
    return _marksIn(json.dumps(parameterNode.get("inputs")))


@lru_cache(maxsize=8)
def _marksIn(text):
    empty = json.loads(plan_text(Plan()))
    return plan_from_document({**empty, "inputs": json.loads(text)}).marks.in_frame("RAS")


def setMarks(parameterNode, marks):
    """Set what the plan says of the vessel, in RAS; see `marksOf`."""
    document = json.loads(plan_text(Plan(frame="RAS").marked(marks)))["inputs"]
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
    """Restore stents and method from such a text, with the handles that exist and new ones for stents that were removed."""
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
    plan = plan.in_frame("RAS")
    try:
        rows = rows_from(plan.stents)
    except InputError as error:
        raise error.labeled(f"{path}: ") from error
    stents = [row.entry for row in rows]
    flow = flow_entry(plan.flow)
    shown = SimpleNamespace(
        get=lambda path: value_at({"settings": plan.method, "flow": flow}, path)
    )
    for number, values in enumerate(stents, start=1):
        _checkRanges(_shownOf(values, STENT), f"{path}: {values['name'] or f'stent {number}'}")
    for fields, name in ((METHOD, "settings"), (FLOW, "flow")):
        found = {key: one.shown(shown.get(one.path)) for key, one in fields.items()}
        _checkRanges(found, f"{path}: {name}")
    for values, row in zip(stents, rows, strict=True):  # nothing is refused from here on
        own = former.get(values["name"])
        if row.original is not None:
            values["handle"] = stents[row.original]["handle"]
        elif row.stent.placement is None and own is not None:  # as it was
            values["handle"], values["placement"] = own.handle, own.draft.entry["placement"]
        else:
            kind = Placement.of(values["placement"])
            values["handle"] = _handleOf(kind, row.points, values["name"], own and own.handle)
    with slicer.util.NodeModify(parameterNode):
        views = views_entry(plan.views)
        parameterNode.change({"settings": plan.method, "flow": flow, "views": views})
        setMarks(parameterNode, plan.marks)
        StentList(parameterNode).replace(stents, 0 if stents else -1)


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


def _handleOf(kind, points, label, former=None):
    if kind.isOfVessel and Handles.isOwn(former):
        return former  # it follows
    className = Handles.CURVE if kind == Placement.ALONG_CURVE else Handles.POINTS
    if former is not None and Handles.bringTo(former, className, points):
        return former
    return Handles.createHandle(slicer.mrmlScene, label, points, className)


def fileOf(node):
    """The path of the file that a model came from, when the plan can be replayed with it; else None."""
    if (
        node is None
        or not node.IsA("vtkMRMLModelNode")
        or node.GetParentTransformNode() is not None
    ):
        return None
    storage = node.GetStorageNode()
    if storage is None or not storage.GetFileName() or node.GetModifiedSinceRead():
        return None
    return storage.GetFullNameFromFileName()


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
