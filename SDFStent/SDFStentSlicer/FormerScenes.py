"""Scenes of former versions, which had a parameter for every value: they are read once, into the document of the plan."""

import json

from slicer.i18n import tr as _

from SDFStentLib.plan import NEW_STENT, with_value

from .ParameterNode import handleRole
from .PlanFields import FLOW, METHOD, RANGES, STENT, Placement

COUNT = "stents.len"
"""The parameter by which such a node is known."""

TOLD = _(
    "This plan was saved by a former version and was taken over; once the scene is saved again, it needs this version or a later one."
)


def takeOver(node):
    """Make the document of a parameter node that a former version has left; does nothing to another one.

    Handles were node references of the same roles, behind which Slicer writes a number for the kind of node.
    """
    if not node.HasParameter(COUNT) or node.GetParameter("plan"):
        return
    former = {name: node.GetParameter(name) for name in node.GetParameterNames()}
    stents = [_stent(former, f"stents.{number}.") for number in range(int(former[COUNT] or 0))]
    kept = json.loads(former.get("planDocument") or "{}")
    document = {"stents": stents, "settings": kept.get("settings") or {}, "flow": _flow(former)}
    names = {"units": "mm", "frame": "RAS", "names": _names(kept)}
    document["inputs"] = names if names["names"] else {}
    for name, field in METHOD.items():
        text = former.get(f"method.{name}")
        if text is not None:
            value = _value(text, name in RANGES)
            document = with_value(document, field.path, field.planned(value))
    wasModified = node.StartModify()
    for name in former:
        if name.startswith(("stents.", "stent.", "method.")) or name in (*FLOW, *_OTHERS):
            node.UnsetParameter(name)
    for role in (
        role for number in range(len(stents)) for role in _formerRoles(handleRole(number))
    ):
        if node.GetNodeReferenceID(role):
            node.SetNodeReferenceID(role.rpartition(".")[0], node.GetNodeReferenceID(role))
            node.RemoveNodeReferenceIDs(role)
    for role in ("stent.handle", *_formerRoles("stent.handle")):
        node.RemoveNodeReferenceIDs(role)
    node.SetParameter("plan", json.dumps(document, ensure_ascii=False))
    node.takenOver = node.GetParameter("plan")  # kept as long as the node, and in no file
    node.EndModify(wasModified)


def toldOf(parameterNode):
    """Sentence on a plan that was taken over and not changed since; "" of any other."""
    taken = getattr(parameterNode.parameterNode, "takenOver", None)
    return TOLD if taken is not None and taken == parameterNode.plan else ""


_OTHERS = ("planDocument", "flowWave", "flowInlets")


def _formerRoles(role):
    return [f"{role}.{kind}" for kind in range(2)]  # a point list, and a curve


def _value(text, isNumber):
    return float(text) if isNumber else {"True": True, "False": False}.get(text, text)


def _stent(former, prefix):
    entry = {**NEW_STENT, **json.loads(former.get(f"{prefix}details") or "{}")}
    for name, field in STENT.items():
        text = former.get(prefix + name)
        if text is not None and name not in ("placement", "label"):
            entry[field.path] = field.planned(_value(text, name in RANGES))
    entry["name"] = former.get(f"{prefix}label", NEW_STENT["name"])
    kind = Placement[former.get(f"{prefix}placement", Placement.CENTER.name)]
    landmark = former.get(f"{prefix}landmark")
    entry["placement"] = json.loads(landmark) if landmark and kind.isOfVessel else kind.place
    return entry


def _flow(former):
    found = {}
    for name, field in FLOW.items():
        value = _value(former.get(name, "0.0" if name in RANGES else "False"), name in RANGES)
        found = with_value(found, field.path, field.planned(value))
    flow = found["flow"]
    wave, inlets = (json.loads(former.get(name) or "null") for name in ("flowWave", "flowInlets"))
    if wave:
        flow["wave"] = _wave(wave)
    if inlets:
        flow["inlets"] = [
            {"name": name, "mean": mean, "wave": own and _wave(own)} for name, mean, own in inlets
        ]
    return flow if any(flow.values()) else None


def _wave(rows):
    return dict(zip(("time", "flow"), rows, strict=True))


def _names(kept):
    """Names of vessels in the last plan, its places in mm in RAS."""
    inputs = kept.get("inputs") or {}
    scale = {"mm": 1.0, "cm": 10.0, "m": 1000.0}[inputs.get("units", "mm")]
    sign = -1.0 if inputs.get("frame") == "LPS" else 1.0
    return {
        name: place
        if isinstance(place, int)
        else [one * scale * way for one, way in zip(place, (sign, sign, 1.0), strict=True)]
        for name, place in (inputs.get("names") or {}).items()
    }
