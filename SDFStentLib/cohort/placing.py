"""What the parameters of a case mean in the vessel of a patient: the plan that is carried out."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..plan import InputFiles, Plan, StentSizes, detailed_stent, stent_details, turned
from ..stent import AtCenter, AtDistalEnd, Placement, Stent
from ..treatment import AxisChange, axis_in_vessel
from ..units import are_apart
from ..validation import InputError, Points, as_number
from ..vessel import Lesion
from .axes import PLACES, SHAPE_PARTS
from .cases import Parameters
from .value import Constraints

NEAR = 1.0
"""Distal ends so far apart are not at the same place of a branch, mm."""


class Excluded(Exception):
    """A case that the constraints of its sweep rule out; the message says which."""


class _Place(NamedTuple):
    """The middle of a stent on the centerline."""

    way: Line
    """From the root to the end of the branch."""
    at: float
    """Along the way, mm."""
    start: float
    """Of the branch, along the way, mm."""
    lesion: Lesion | None

    @property
    def point(self) -> Points:
        """(3,) mm."""
        return self.way.at(np.array([self.at]))[0]

    def placement(self, deployed_length: float, tree: Centerline) -> Placement:
        """By its middle; where that is not enough to lead into the branch, by its distal end."""
        distal = self.at + deployed_length / 2
        if distal <= self.start or distal > self.way.arc_lengths[-1]:
            return AtCenter(self.point)
        end = self.way.at(np.array([distal]))[0]
        leads = tree.path_around(self.point, deployed_length).points[-1]
        if self.at < self.start or np.linalg.norm(leads - end) > NEAR:
            return AtDistalEnd(end)
        return AtCenter(self.point)


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
    base = plan.stents[number - 1]
    place = _place(parameters, inputs)
    diameter = _diameter(base, parameters, place, plan, inputs)
    stent = _stent(base, parameters, diameter)
    if place is not None:
        assert stent.length is not None
        placement = place.placement(stent.length * (1 - stent.foreshortening), _tree(inputs))
        stent = replace(stent, placement=placement)
    _check(stent, place, constraints, plan, inputs)
    if place is not None and are_apart(plan.frame, inputs.surface.frame):
        stent = turned(stent)
    stents = (*plan.stents[: number - 1], stent, *plan.stents[number:])
    return replace(plan, stents=stents)


def _place(parameters: Parameters, inputs: InputFiles) -> _Place | None:
    if not set(parameters) & set(PLACES):
        return None
    tree = _tree(inputs)
    if "lesion" in parameters:
        return _at_lesion(parameters, tree, inputs.vessel.lesions or ())
    branch = _branch(parameters["branch"], tree, inputs)
    points = tree.branches[branch]
    start, end = tree.arc_length[points[[0, -1]]]
    if "fraction" in parameters:
        share = as_number(parameters["fraction"], "fraction", minimum=0, maximum=1)
        along = share * (end - start)
    else:
        along = as_number(
            parameters["distance"], "distance", unit="mm", minimum=0, maximum=float(end - start)
        )
    way = Line(tree.points[tree.ancestry(int(points[-1]))])
    return _Place(way, float(start + along), float(start), None)


def _at_lesion(parameters: Parameters, tree: Centerline, lesions: tuple[Lesion, ...]) -> _Place:
    number, offset = parameters["lesion"], parameters.get("offset", 0.0)
    assert isinstance(number, int)
    assert isinstance(offset, float | int)
    if number > len(lesions):
        raise InputError(f"lesion: expected one of the {len(lesions)} there are, got {number}.")
    lesion = lesions[number - 1]
    points = tree.branches[lesion.branch]
    way = Line(tree.points[tree.ancestry(int(points[-1]))])
    middle = (lesion.start + lesion.end) / 2
    low, high = -middle, way.arc_lengths[-1] - middle
    at = middle + as_number(offset, "offset", unit="mm", minimum=low, maximum=float(high))
    return _Place(way, at, float(tree.arc_length[points[0]]), lesion)


def _branch(wanted: Any, tree: Centerline, inputs: InputFiles) -> int:
    """Its index, by number from 1 or by name."""
    names = inputs.vessel.branch_names
    if wanted in names:
        return names.index(wanted)
    if isinstance(wanted, int) and wanted <= len(tree.branches):
        return wanted - 1
    raise InputError(
        f"branch: expected 1 to {len(tree.branches)} or one of {', '.join(names)}, got {wanted!r}."
    )


def _diameter(
    base: Stent, parameters: Parameters, place: _Place | None, plan: Plan, inputs: InputFiles
) -> float:
    if "diameter_over_lumen" in parameters:
        middle = _halfway(_axis(base, plan, inputs)) if place is None else place.point
        return _number(parameters["diameter_over_lumen"]) * _lumen(middle, inputs)
    if "diameter_over_reference" in parameters:
        assert place is not None
        assert place.lesion is not None
        return _number(parameters["diameter_over_reference"]) * place.lesion.reference_diameter
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


def _check(
    stent: Stent, place: _Place | None, rules: Constraints, plan: Plan, inputs: InputFiles
) -> None:
    """Raise `Excluded` for a stent beyond the constraints."""
    if rules.diameter_over_reference is not None:
        assert place is not None
        assert place.lesion is not None
        ratio = stent.diameter / place.lesion.reference_diameter
        _check_ratio(ratio, rules.diameter_over_reference, "diameter over the reference")
    if rules.diameter_over_lumen is None and rules.distance_to_ends is None:
        return
    axis = _axis(stent, plan, inputs)
    if rules.diameter_over_lumen is not None:
        ratio = stent.diameter / _lumen(_halfway(axis), inputs)
        _check_ratio(ratio, rules.diameter_over_lumen, "diameter over the lumen")
    if rules.distance_to_ends is not None:
        left = min(_distances_to_ends(axis, _tree(inputs)))
        if left < rules.distance_to_ends:
            raise Excluded(f"distance to the ends: {left:.1f} mm, below {rules.distance_to_ends:g}")


def _check_ratio(ratio: float, bounds: tuple[float, float], what: str) -> None:
    if not bounds[0] <= ratio <= bounds[1]:
        raise Excluded(f"{what}: {ratio:.3f}, beyond {bounds[0]:g} to {bounds[1]:g}")


def _distances_to_ends(axis: Line, tree: Centerline) -> Iterator[float]:
    """From the ends of an axis along the centerline to its root and to the outlets below, mm."""
    first, last = (tree.project(end) for end in axis.points[[0, -1]])
    yield first.arc_length
    for leaf in tree.leaves:
        if last.index in tree.ancestry(int(leaf)):
            yield float(tree.arc_length[leaf] - last.arc_length)


def _lumen(point: Points, inputs: InputFiles) -> float:
    """Inscribed diameter at a place (3,) of the centerline, mm."""
    radius = _tree(inputs).project(point).inscribed_radius
    if not np.isfinite(radius):
        raise InputError(
            "lumen: expected a centerline with the radius of inscribed spheres, got one without; "
            "give diameters in mm."
        )
    return 2 * radius


def _axis(stent: Stent, plan: Plan, inputs: InputFiles) -> Line:
    vessel = inputs.vessel
    change = AxisChange.of(plan.straightening_fraction, plan.settings)
    return axis_in_vessel(stent, vessel.centerline, vessel.surface, change).line


def _halfway(axis: Line) -> Points:
    middle: Points = axis.at(axis.arc_lengths[-1:] / 2)[0]
    return middle


def _tree(inputs: InputFiles) -> Centerline:
    if inputs.vessel.centerline is None:
        raise InputError("place: expected a patient with a centerline, got one without.")
    return inputs.vessel.centerline


def _number(value: Any) -> float:
    return float(value)
