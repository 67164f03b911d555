"""Sweeps as JSON documents: described by a JSON schema (draft 7)."""

from __future__ import annotations

from typing import Any

from ..plan import INPUTS, list_of, object_schema, or_null
from .axes import MOST_STEPS, NAMES
from .document import METHODS, RATIOS, SCHEMA, SCHEMA_VERSION, STORES
from .value import MOST_SAMPLES

_NUMBER, _TEXT, _OBJECT = {"type": "number"}, {"type": "string"}, {"type": "object"}
_FROM_ONE = {"type": "integer", "minimum": 1}
_TWO = list_of(_NUMBER, 2)
_ITEMS: dict[str, Any] = {
    "branch": {"anyOf": [_FROM_ONE, _TEXT]},
    "lesion": _FROM_ONE,
    "device": {"anyOf": [_TEXT, _OBJECT]},
    "shape": or_null(_OBJECT),
}
"""Of the axes whose values are listed."""


def sweep_schema() -> dict[str, Any]:
    """The schema of a sweep's document; `docs/cohorts.md` says what the keys stand for."""
    file = {"anyOf": [_TEXT, INPUTS["surface"]]}
    inputs = {**INPUTS, "name": {**_TEXT, "minLength": 1}, "surface": file, "centerline": file}
    axes = {name: _axis(name) for name in NAMES}
    properties = {
        "schema": {"const": SCHEMA},
        "version": {"const": SCHEMA_VERSION},
        "plan": {"anyOf": [_TEXT, _OBJECT]},
        "patients": {**list_of(object_schema(inputs, ("name", "surface"))), "minItems": 1},
        "stent": _FROM_ONE,
        "axes": {**object_schema(axes), "minProperties": 1},
        "sampling": {
            "anyOf": [
                object_schema({"method": {"const": METHODS[0]}}, ("method",)),
                object_schema(
                    {
                        "method": {"enum": list(METHODS[1:])},
                        "count": {**_FROM_ONE, "maximum": MOST_SAMPLES},
                        "seed": {"type": "integer", "minimum": 0},
                    },
                    ("method", "count"),
                ),
            ]
        },
        "constraints": object_schema({**dict.fromkeys(RATIOS, _TWO), "distance_to_ends": _NUMBER}),
        "store": {"enum": list(STORES)},
        "time_limit": or_null({**_NUMBER, "exclusiveMinimum": 0}),
    }
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "SDFStent sweep",
        "description": "Many deployments of one plan. Lengths and diameters are in mm; points are "
        "in the unit and frame of the inputs.",
        **object_schema(properties, ("schema", "version", "plan", "axes")),
    }


def _axis(name: str) -> dict[str, Any]:
    """One value, a list, even steps, a uniform range or a normal distribution (mean and SD)."""
    item = _ITEMS.get(name, _NUMBER)
    listed = {**list_of(item), "minItems": 1}
    kinds = [item, listed, object_schema({"values": listed}, ("values",))]
    if name not in _ITEMS:
        steps = {"type": "integer", "minimum": 2, "maximum": MOST_STEPS}
        spread = {"from": _NUMBER, "to": _NUMBER, "steps": steps}
        kinds += [
            object_schema(spread, tuple(spread)),
            object_schema({"uniform": _TWO}, ("uniform",)),
            object_schema({"normal": _TWO, "within": _TWO}, ("normal",)),
        ]
    return {"anyOf": kinds}
