"""Plans as JSON documents: writing, undone by `reader`, and the JSON schema (draft 7) of them."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..files import write_bytes
from ..flow import Known
from ..stent import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtLesion,
    AtProximalEnd,
    BetweenPoints,
    InputFile,
    OfStent,
    OfVessel,
    OnBranch,
    Placement,
    Stent,
)
from ..units import MILLIMETERS
from ..validation import InputError, as_path, check_is_a
from ..view import ViewWishes
from .entry import stent_entry
from .json_document import json_text, text_value, unscaled
from .plan import Plan, method_parameters
from .typed import list_of, object_schema, or_null, schema_of
from .vessel_names import names_document

SCHEMA = "sdfstent-plan"
SCHEMA_VERSION = 2
"""The version of the documents that are written and read."""

POINT_PLACEMENTS: dict[str, type[AtCenter] | type[AtDistalEnd] | type[AtProximalEnd]] = {
    "center": AtCenter,
    "distal": AtDistalEnd,
    "proximal": AtProximalEnd,
}
"""Placements by one point, as the document and the command line call them."""

PLACEMENTS: dict[str, type] = {
    **POINT_PLACEMENTS,
    "from": BetweenPoints,
    "axis": AlongAxis,
    "stent": OfStent,
    "lesion": AtLesion,
    "branch": OnBranch,
}
"""Placements by the first key that they have in a document."""


def save_plan(
    plan: Plan, path: str | os.PathLike[str], *, relative_to: str | os.PathLike[str] | None = None
) -> None:
    """Write a plan as JSON, whole or not at all.

    Parameters
    ----------
    plan : Plan
    path : path
    relative_to : path, optional
        Folder that the paths of its files start from; that of the plan by default, as it must be
        when the plan is read.

    Raises
    ------
    InputError
        Settings with a function of one's own, a name of a stent that is no text, or a file that
        cannot be written.
    """
    check_is_a(plan, Plan, "plan")
    folder = os.path.dirname(os.path.abspath(as_path(path))) if relative_to is None else relative_to
    write_bytes(path, plan_text(plan, os.fspath(folder)).encode())


def plan_text(plan: Plan, folder: str | None = None) -> str:
    """The plan as JSON text; files relative to a folder, or absolute."""
    return json_text(plan_document(plan, folder)) + "\n"


def plan_document(plan: Plan, folder: str | None = None) -> dict[str, Any]:
    """The plan as values of JSON. Points in its unit, as `Decimal`; everything else in mm.

    Raises
    ------
    InputError
        Settings with a function of one's own or a name that is no text, which a document cannot
        hold.
    """
    for name, value in plan.method.items():
        if callable(value):
            raise InputError(
                f"settings.{name}: expected a name, got a function; a plan holds names only."
            )
    return {
        "schema": SCHEMA,
        "version": SCHEMA_VERSION,
        "sdfstent_version": plan.sdfstent_version,
        "inputs": {
            "units": plan.units,
            "frame": plan.frame,
            "surface": _file_document(plan.surface, folder),
            "centerline": _file_document(plan.centerline, folder),
            "root": None if plan.root is None else _filed(plan.root, plan.units),
            "reference": [_filed(place, plan.units) for place in plan.reference],
            "names": names_document(plan.names, plan.units),
        },
        "stents": [_stent_document(stent, plan.units, folder) for stent in plan.stents],
        "flow": None if plan.flow is None else _flow_document(plan.flow, plan.units),
        "views": None if plan.views is None else asdict(plan.views),
        "settings": plan.method,
    }


def _flow_document(known: Known, units: str) -> dict[str, Any]:
    document = asdict(known)
    if not document["unusual"]:
        del document["unusual"]
    return {**document, "right": None if known.right is None else _filed(known.right, units)}


def _filed(point: Any, units: str) -> list[Any]:
    return [unscaled(value, MILLIMETERS[units]) for value in point]


def _stent_document(stent: Stent, units: str, folder: str | None) -> dict[str, Any]:
    first = {"name": text_value(stent.name, "stent name"), "enabled": stent.enabled}
    found = {**first, **stent_entry(stent), "diameter": float(stent.diameter)}
    return {**found, "placement": placement_document(stent.placement, units, folder)}


def placement_document(
    placement: Placement | None,
    units: str = "mm",
    folder: str | None = None,
) -> dict[str, Any] | None:
    """A placement as in a plan's document, its points in a unit as `Decimal`; null for none."""

    def point(coordinates: Any) -> list[Any]:
        return _filed(coordinates, units)

    if isinstance(placement, AlongAxis):
        by_file = _file_document(placement.file, folder)
        return {"axis": by_file or {"points": [point(p) for p in placement.points]}}
    if placement is None:
        return None
    if isinstance(placement, OfStent):
        return {"stent": placement.number}
    if isinstance(placement, OfVessel):
        return {PLACE_WORDS.get(key, key): v for key, v in vars(placement).items() if v is not None}
    if isinstance(placement, BetweenPoints):
        return {"from": point(placement.start), "to": point(placement.end)}
    name = next(key for key, kind in POINT_PLACEMENTS.items() if isinstance(placement, kind))
    return {name: point(placement.point)}


def _file_document(file: InputFile | None, folder: str | None) -> dict[str, Any] | None:
    if file is None:
        return None
    path = file.path
    if folder is not None:
        try:
            path = os.path.relpath(path, folder)
        except ValueError:  # another drive, on Windows
            path = file.path
    return {"file": Path(path).as_posix(), "sha256": file.sha256}


NUMBER, TEXT = {"type": "number"}, {"type": "string"}
POINT = list_of(NUMBER, 3)
WHOLE = {"type": "integer", "minimum": 1}
ALONG = ("distance", "fraction")
FILE = object_schema({"file": {**TEXT, "minLength": 1}, "sha256": or_null(TEXT)}, ("file",))
INPUTS: dict[str, Any] = {
    "units": {"enum": list(MILLIMETERS)},
    "frame": {"enum": ["RAS", "LPS", None]},
    "surface": or_null(FILE),
    "centerline": or_null(FILE),
    "root": or_null(POINT),
    "reference": {**list_of(POINT), "maxItems": 2},
    "names": {
        "type": "object",
        "propertyNames": {"pattern": r"\S"},
        "additionalProperties": {"anyOf": [POINT, {"type": "integer"}]},
    },
}


def plan_schema() -> dict[str, Any]:
    """The schema of a plan's document; `docs/plan.md` says what the keys stand for."""
    settings = {
        name: {"description": one.sentence}
        | (or_null(one.schema()) if one.is_optional else one.schema())
        for name, one in method_parameters().items()
    }
    properties = {
        "schema": {"const": SCHEMA},
        "version": {"const": SCHEMA_VERSION},
        "sdfstent_version": TEXT,
        "inputs": object_schema(INPUTS),
        "stents": list_of(schema_of(Stent, placement=_placement())),
        "flow": or_null(schema_of(Known)),
        "views": or_null(schema_of(ViewWishes)),
        "settings": object_schema(settings),
    }
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "SDFStent plan",
        "description": "Everything that determines a result. Lengths and diameters are in mm; "
        "points are in the unit and frame of the inputs.",
        **object_schema(properties, ("schema", "version", "stents")),
    }


PLACE_WORDS = {"number": "lesion"}
"""Words of `AtLesion` and `OnBranch` in a document, where these are others than their own."""


def _placement() -> dict[str, Any]:
    axis = {"anyOf": [FILE, object_schema({"points": list_of(POINT)}, ("points",))]}
    kinds = [
        *({name: POINT} for name in POINT_PLACEMENTS),
        {"from": POINT, "to": POINT},
        {"axis": axis},
        {"stent": WHOLE},
    ]
    found = [object_schema(kind, tuple(kind)) for kind in kinds]
    lesion = object_schema({"lesion": WHOLE, "offset": or_null(NUMBER)}, ("lesion",))
    branch = {"anyOf": [WHOLE, TEXT]}
    along = [object_schema({"branch": branch, key: NUMBER}, ("branch", key)) for key in ALONG]
    return or_null({"anyOf": [*found, lesion, *along]})
