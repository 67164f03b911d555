"""Sweeps as JSON documents: read, and described by a JSON schema (draft 7)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from ..files import read_text
from ..plan import (
    INPUTS,
    check_schema,
    in_words,
    list_of,
    number,
    object_schema,
    or_null,
    parsed,
    section,
)
from ..validation import InputError, as_number, as_path
from .axes import DIAMETERS, MOST_STEPS, NAMES, PLACES, SweepAxis, axis_from_document, rising
from .constraints import Constraints
from .value import MOST_SAMPLES, Sampling, Sweep, patients_of, template_of

SCHEMA, SCHEMA_VERSION = "sdfstent-sweep", 1
METHODS = ("grid", "random", "latin-hypercube", "sobol")
STORES = ("vtp", "moved")
"""Ways to store a surface: all of it, or only the points that moved."""

KEYS = ("patients", "stent", "sampling", "constraints", "store", "time_limit")
RATIOS = ("diameter_over_lumen", "diameter_over_reference")


def load_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Read a sweep document, and the hashes of the files of its patients.

    A patient's missing or damaged file is reported when a case needs it, so that it does not hold
    up the other patients.

    Raises
    ------
    InputError
        A file that cannot be read, no JSON, another schema or version, or a key or a value that
        does not belong there; its place is named.
    """
    path = as_path(path)
    text = read_text(path, "a sweep in JSON")
    try:
        return sweep_from_document(parsed(text, "sweep"), os.path.dirname(os.path.abspath(path)))
    except InputError as error:
        raise error.labeled(f"{path}: ") from error


def sweep_from_document(document: Any, folder: str | None = None) -> Sweep:
    """A sweep from the values of its document; relative paths start at `folder`.

    Raises
    ------
    InputError
        As for `load_sweep`.
    """
    folder = os.path.abspath(folder or ".")
    check_schema(document, SCHEMA, SCHEMA_VERSION, "this is no sweep")
    given = section(document, "sweep", ("schema", "version", "plan", "axes"), KEYS)
    axes = _axes(given["axes"])
    template, folder_of_plan = template_of(given["plan"], folder)
    stent = _whole(given.get("stent", 1), "stent")
    sampling = _sampling(given.get("sampling", {"method": "grid"}))
    for axis in axes:
        if sampling.method == "grid" and not axis.is_listed:
            raise InputError(
                f"axes.{axis.name}: expected values or steps for a grid, got a range; list the "
                "values, or name another method of sampling."
            )
    return Sweep(
        patients=patients_of(
            given.get("patients"), template, axes, stent, (folder, folder_of_plan)
        ),
        axes=axes,
        sampling=sampling,
        constraints=_constraints(given.get("constraints", {}), axes),
        stent=stent,
        store=_one_of(given.get("store", "vtp"), "store", STORES),
        folder=folder,
        time_limit=_time_limit(given.get("time_limit")),
    )


def _axes(value: Any) -> tuple[SweepAxis, ...]:
    if not isinstance(value, Mapping) or not value:
        got = "an empty object" if isinstance(value, Mapping) else in_words(value)
        raise InputError(f"axes: expected an object with at least one axis, got {got}; add one.")
    axes = tuple(axis_from_document(name, value[name], f"axes.{name}") for name in value)
    names = [axis.name for axis in axes]
    if sum(name in DIAMETERS for name in names) > 1:
        raise InputError(f"axes: expected one of {', '.join(DIAMETERS)}, got several.")
    if "shape" in names and any(name.startswith("shape.") for name in names):
        raise InputError("axes: expected whole shapes or parts of one, got both.")
    by_branch = {"branch", "distance", "fraction"} & set(names)
    by_lesion = {"lesion", "offset"} & set(names)
    if (by_branch and by_lesion) or len(by_branch) == 3:
        raise InputError(
            "axes: expected a branch with a distance or a fraction, or a lesion with an offset, "
            f"got {', '.join(name for name in names if name in PLACES)}."
        )
    for found, needed in ((by_branch, "branch"), (by_lesion, "lesion")):
        if found and needed not in found:
            raise InputError(
                f"axes: expected a {needed} with {', '.join(sorted(found))}, got none."
            )
    if by_branch == {"branch"}:
        raise InputError("axes: expected a distance or a fraction with branch, got none.")
    if "diameter_over_reference" in names and "lesion" not in names:
        raise InputError("axes: expected a lesion with diameter_over_reference, got none.")
    return axes


def _sampling(value: Any) -> Sampling:
    given = section(value, "sampling", ("method",), ("count", "seed"))
    method = _one_of(given["method"], "sampling.method", METHODS)
    if method == "grid":
        if len(given) > 1:
            raise InputError("sampling: expected neither count nor seed for a grid.")
        return Sampling()
    count = _whole(
        section(given, "sampling", ("method", "count"), ("seed",))["count"], "sampling.count"
    )
    if count > MOST_SAMPLES:
        raise InputError(f"sampling.count: expected at most {MOST_SAMPLES}, got {count}.")
    seed = given.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise InputError(f"sampling.seed: expected a whole number from 0, got {in_words(seed)}.")
    return Sampling(method, count, seed)


def _constraints(value: Any, axes: tuple[SweepAxis, ...]) -> Constraints:
    given = section(value, "constraints", (), (*RATIOS, "distance_to_ends"))
    found: dict[str, Any] = {
        key: rising(given[key], f"constraints.{key}") for key in RATIOS if key in given
    }
    if "diameter_over_reference" in found and "lesion" not in {axis.name for axis in axes}:
        raise InputError("constraints.diameter_over_reference: expected the axis lesion, got none.")
    if "distance_to_ends" in given:
        where = "constraints.distance_to_ends"
        found["distance_to_ends"] = float(number(given["distance_to_ends"], where))
    return Constraints(**found)


def _time_limit(value: Any) -> float | None:
    if value is None:
        return None
    return as_number(number(value, "time_limit"), "time_limit", unit="s", above=0)


def _whole(value: Any, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise InputError(f"{where}: expected a whole number from 1, got {in_words(value)}.")
    return value


def _one_of(value: Any, where: str, known: tuple[str, ...]) -> str:
    if value not in known:
        raise InputError(f"{where}: expected one of {', '.join(known)}, got {in_words(value)}.")
    return str(value)


_NUMBER, _TEXT, _OBJECT = {"type": "number"}, {"type": "string"}, {"type": "object"}
_FROM_ONE = {"type": "integer", "minimum": 1}
_TWO = list_of(_NUMBER, 2)
_ITEMS: dict[str, Any] = {
    "branch": {"anyOf": [_FROM_ONE, _TEXT]},
    "lesion": _FROM_ONE,
    "device": {"anyOf": [_TEXT, _OBJECT]},
    "shape": or_null(_OBJECT),
}
"""Schemas of the values of the axes whose values are listed."""


def sweep_schema() -> dict[str, Any]:
    """The schema of a sweep's document; `docs/cohorts.md` explains the keys."""
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
    """Schema of an axis: a value, a list, even steps, a uniform range, or a normal distribution."""
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
