"""The base plan of a sweep with the parameters of a case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..plan import InputFiles, Plan, stent_entry, stent_of, with_value
from ..stent import AtLesion, OfVessel, OnBranch, Stent
from ..treatment import spot_of
from ..validation import InputError, printable
from .axes import PLACES, SHAPE_PARTS, SIZES
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
        Number of the stent that the parameters are for, from 1.
    parameters : mapping of str to value
        Values by the names of `axes.NAMES`.
    constraints : Constraints
    inputs : InputFiles
        Input files as read for the plan.

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
    entry = {**stent_entry(base), "enabled": True, "diameter": diameter}
    if "device" in parameters:
        device = parameters["device"]
        assert isinstance(device, Mapping)
        length = None if device.get("nominal_length") else base.length
        entry = {**entry, "device": device, "length": length}
    for path in (*SIZES, "shape", *SHAPE_PARTS):
        if path in parameters:
            entry = with_value(entry, path, parameters[path])
    stent = stent_of(entry, base.placement)
    for name in SIZES:
        if name in parameters and getattr(stent, name) != parameters[name]:
            assert stent.device is not None
            raise InputError(
                f"{name}: expected none with {printable(stent.device.name)}, which has its own, "
                f"got {parameters[name]}; leave the axis out, or take another device."
            )
    return stent


def _number(value: Any) -> float:
    return float(value)
