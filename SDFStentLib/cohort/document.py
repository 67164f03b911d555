"""The sweep: one value that holds a plan, what varies in it, and in whom; read from JSON."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from ..files import read_text
from ..plan import (
    check_schema,
    in_words,
    number,
    parsed,
    section,
)
from ..validation import InputError, as_number, as_path
from .axes import DIAMETERS, PLACES, Axis, axis_from_document, rising
from .patients import patients_of, template_of
from .value import MOST_SAMPLES, Constraints, Sampling, Sweep

SCHEMA, SCHEMA_VERSION = "sdfstent-sweep", 1
METHODS = ("grid", "random", "latin-hypercube", "sobol")
STORES = ("vtp", "moved")
"""What is kept of a surface: all of it, or the points that moved."""

KEYS = ("patients", "stent", "sampling", "constraints", "store", "time_limit")
RATIOS = ("diameter_over_lumen", "diameter_over_reference")


def load_sweep(path: str | os.PathLike[str]) -> Sweep:
    """Read a sweep document, and the hashes of the files of its patients.

    A patient's file that is missing or damaged is found where a case needs it, so that the other
    patients are not held up.

    Raises
    ------
    InputError
        A file that cannot be read, no JSON, another schema or version, or a key or a value that
        does not belong there, with its place.
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
        As `load_sweep`.
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


def _axes(value: Any) -> tuple[Axis, ...]:
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


def _constraints(value: Any, axes: tuple[Axis, ...]) -> Constraints:
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
