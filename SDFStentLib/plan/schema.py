"""Plans as JSON documents: described by a JSON schema (draft 7), made of what the parts say."""

from __future__ import annotations

from typing import Any

from ..flow import Known
from ..stent import Stent
from ..units import MILLIMETERS
from .document import POINT_PLACEMENTS, SCHEMA, SCHEMA_VERSION
from .plan import method_parameters
from .typed import list_of, object_schema, or_null, schema_of

NUMBER, TEXT = {"type": "number"}, {"type": "string"}
POINT = list_of(NUMBER, 3)
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
        "settings": object_schema(settings),
    }
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "SDFStent plan",
        "description": "Everything that determines a result. Lengths and diameters are in mm; "
        "points are in the unit and frame of the inputs.",
        **object_schema(properties, ("schema", "version", "stents")),
    }


def _placement() -> dict[str, Any]:
    axis = {"anyOf": [FILE, object_schema({"points": list_of(POINT)}, ("points",))]}
    kinds = [
        *({name: POINT} for name in POINT_PLACEMENTS),
        {"from": POINT, "to": POINT},
        {"axis": axis},
        {"stent": {"type": "integer", "minimum": 1}},
    ]
    return {"anyOf": [object_schema(kind, tuple(kind)) for kind in kinds]}
