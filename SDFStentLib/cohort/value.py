"""A sweep as one value: a plan, what varies in it, and the files of each patient."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..files import read_text, read_with_pieces
from ..plan import (
    Plan,
    in_words,
    parsed,
    plan_from_document,
    read_axis_file,
    section,
    sequence,
    text_value,
)
from ..stent import InputFile
from ..validation import InputError
from .axes import DIAMETERS, PLACES, SweepAxis
from .constraints import Constraints

MOST_SAMPLES = 10_000_000
"""Largest number of samples for each patient of a sweep."""


@dataclass(frozen=True)
class Sampling:
    """Sampling of points: the method, their number for each patient, and the seed."""

    method: str = "grid"
    count: int = 0
    seed: int = 0


@dataclass(frozen=True)
class Patient:
    """A name, and the base plan for this patient's files with their current hashes."""

    name: str
    plan: Plan


@dataclass(frozen=True, eq=False)
class Sweep:
    """Everything that determines a cohort.

    Attributes
    ----------
    patients : tuple of Patient
    axes : tuple of SweepAxis
    sampling : Sampling
    constraints : Constraints
    stent : int
        Number of the stent that the axes change, from 1.
    store : {"vtp", "moved"}
    folder : str
        Folder of the document, from which paths in it start.
    time_limit : float, optional
        Time limit of each case, s, after which it has failed. It changes no result.
    """

    patients: tuple[Patient, ...]
    axes: tuple[SweepAxis, ...]
    sampling: Sampling
    constraints: Constraints = Constraints()
    stent: int = 1
    store: str = "vtp"
    folder: str = ""
    time_limit: float | None = None


INPUT_KEYS = ("surface", "centerline", "units", "frame", "root", "reference", "names")
"""Keys that a patient may have besides a name, as in the inputs of a plan."""


def template_of(value: Any, folder: str) -> tuple[dict[str, Any], str]:
    """The document of the base plan, and the folder from which its paths start."""
    if isinstance(value, Mapping):
        return dict(value), folder
    if not isinstance(value, str):
        raise InputError(f"plan: expected a plan or the name of its file, got {in_words(value)}.")
    path = os.path.join(folder, value)
    found = parsed(read_text(path, "a plan in JSON"), path)
    if not isinstance(found, Mapping):
        raise InputError(f"{path}: expected a plan, got {in_words(found)}.")
    return dict(found), os.path.dirname(path)


def patients_of(
    value: Any,
    template: Mapping[str, Any],
    axes: tuple[SweepAxis, ...],
    stent: int,
    folders: tuple[str, str],
) -> tuple[Patient, ...]:
    """The patients that a document lists, each with a whole plan; by default the base plan's own.

    Parameters
    ----------
    value : Any
        The list as the document has it; None if it has none.
    template : mapping
        The document of the base plan.
    axes : tuple of SweepAxis
        Axes; values that they give may be left out of the template.
    stent : int
        Number of the stent that they change, from 1.
    folders : tuple of two str
        Folders from which paths start: those of the patients, and those of the base plan.

    Raises
    ------
    InputError
        An entry that is no patient, or one without a surface or a name of its own; an invalid plan.
    """
    filled = _filled(template, axes, stent)
    if value is None:
        plan = _plan(filled, folders[1], stent)
        name = "" if plan.surface is None else Path(plan.surface.path).stem
        return (_checked(Patient(name, _with_hashes(plan)), "plan"),)
    patients: dict[str, Patient] = {}
    for index, item in enumerate(sequence(value, "patients")):
        where = f"patients[{index}]"
        given = dict(section(item, where, ("name", "surface"), INPUT_KEYS))
        name = text_value(given.pop("name"), f"{where}.name")
        if not name or name in patients:
            raise InputError(f"{where}.name: expected another name for everyone, got {name!r}.")
        for key in ("surface", "centerline"):
            if isinstance(given.get(key), str):
                given[key] = {"file": given[key]}
        try:
            plan = _plan({**filled, "inputs": given}, folders[0], stent)
        except InputError as error:
            raise error.labeled(f"{where}: ") from error
        patients[name] = _checked(Patient(name, _with_hashes(plan)), where)
    if not patients:
        raise InputError("patients: expected at least one, got none.")
    return tuple(patients.values())


def _filled(template: Mapping[str, Any], axes: tuple[SweepAxis, ...], stent: int) -> dict[str, Any]:
    """Template completed to a plan: values that the axes give may be left out of it."""
    listed = sequence(template.get("stents", []), "plan.stents")
    stents = [dict(one) if isinstance(one, Mapping) else one for one in listed]
    if not 0 < stent <= len(stents):
        raise InputError(f"stent: expected 1 to {len(stents)}, got {stent}.")
    own, names = stents[stent - 1], {axis.name for axis in axes}
    if isinstance(own, dict):
        if names & set(DIAMETERS):
            own.setdefault("diameter", 1)
        if names & set(PLACES):
            own.pop("placement", None)
        if "length" in names or "device" in names:
            own.setdefault("length", 1)
    return {**template, "stents": stents}


def _plan(document: Mapping[str, Any], folder: str, stent: int) -> Plan:
    try:
        plan = plan_from_document(document, folder, read_axis_file)
    except InputError as error:
        raise error.labeled("plan: ") from error
    if not plan.stents[stent - 1].enabled:
        raise InputError(f"stent: expected one that is switched on, got number {stent}.")
    return plan


def _with_hashes(plan: Plan) -> Plan:
    return replace(plan, surface=_hashed(plan.surface), centerline=_hashed(plan.centerline))


def _hashed(file: InputFile | None) -> InputFile | None:
    """The file with the hash of its contents, unless the document gives one."""
    if file is None or file.sha256 is not None:
        return file
    try:
        return InputFile(file.path, read_with_pieces(file.path).sha256)
    except InputError:
        return file  # whoever reads it says why not


def _checked(patient: Patient, where: str) -> Patient:
    if patient.plan.surface is None:
        raise InputError(f"{where}: expected a surface file, got none; name it in the inputs.")
    return patient
