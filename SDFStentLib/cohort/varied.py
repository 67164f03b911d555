"""The base plan of a sweep with the parameters of a case."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..plan import InputFiles, Plan, StentSizes, detailed_stent, stent_details
from ..stent import AtLesion, OfVessel, OnBranch, Stent
from ..treatment import spot_of
from .axes import PLACES, SHAPE_PARTS
from .cases import Parameters
from .constraints import Constraints, Where, check_constraints, halfway


def plan_of_case(
    plan: Plan, number: int, parameters: Parameters, constraints: Constraints, inputs: InputFiles
) -> Plan:
    """The base plan with the parameters of a case.

    Parameters
    ----------
    plan : Plan
        Base plan of the patient.
    number : int
        Of the stent that the parameters are for, from 1.
    parameters : mapping of str to value
        By the names of `axes.NAMES`.
    constraints : Constraints
    inputs : InputFiles
        What was read for the plan.

    Raises
    ------
    InputError
        No such branch or lesion, a place beyond its vessel, sizes that rule each other out.
    Excluded
        The constraints rule the case out.
    """
    base, place = plan.stents[number - 1], _place(parameters)
    where = Where(plan, inputs, None)
    if place is not None:
        where = where._replace(spot=spot_of(place, inputs.vessel.landmarks))
    stent = _stent(base, parameters, _diameter(base, parameters, where))
    if place is not None:
        stent = replace(stent, placement=place)
    check_constraints(stent, constraints, where)
    return replace(plan, stents=(*plan.stents[: number - 1], stent, *plan.stents[number:]))


def _place(parameters: Parameters) -> OfVessel | None:
    given: dict[str, Any] = {name: parameters[name] for name in PLACES if name in parameters}
    if "lesion" in given:
        return AtLesion(given["lesion"], given.get("offset", 0.0))
    return OnBranch(**given) if given else None


def _diameter(base: Stent, parameters: Parameters, where: Where) -> float:
    if "diameter_over_lumen" in parameters:
        middle = halfway(where.axis(base)) if where.spot is None else where.spot.point
        return _number(parameters["diameter_over_lumen"]) * where.lumen(middle)
    if "diameter_over_reference" in parameters:
        return _number(parameters["diameter_over_reference"]) * where.reference
    return _number(parameters.get("diameter", base.diameter))


def _stent(base: Stent, parameters: Parameters, diameter: float) -> Stent:
    """The base stent with other sizes, device and shape; its place is the base's."""
    details = json.loads(stent_details(base) or "{}")
    length = base.length
    if "device" in parameters:
        details["device"] = device = parameters["device"]
        assert isinstance(device, Mapping)
        length = None if device.get("nominal_length") else length
    if "length" in parameters:
        length = _number(parameters["length"])
    if "shape" in parameters:
        details["shape"] = parameters["shape"]
    for name in SHAPE_PARTS:
        if name in parameters:
            _, *parts = name.split(".")
            inner = details.setdefault("shape", {})
            for part in parts[:-1]:
                inner = inner.setdefault(part, {})
            inner[parts[-1]] = parameters[name]
    details = {key: value for key, value in details.items() if value is not None}
    return detailed_stent(
        json.dumps(details) if details else "",
        StentSizes(diameter, length, base.foreshortening_fraction),
        base.placement,
        base.name,
    )


def _number(value: Any) -> float:
    return float(value)
