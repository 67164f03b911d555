"""Constraints on the cases of a sweep, and the cases that are left out by them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line
from ..plan import InputFiles, Plan, turned
from ..stent import Stent
from ..treatment import AxisChange, StentMiddle, axis_in_vessel
from ..units import are_apart
from ..validation import InputError, Points


class Excluded(Exception):
    """A case that the constraints of its sweep rule out; the message says which."""


@dataclass(frozen=True)
class Constraints:
    """Constraints that a case keeps to, or is left out.

    Attributes
    ----------
    diameter_over_lumen, diameter_over_reference : tuple of two floats, optional
        Least and most of the stent's diameter over that of the lumen at its middle before
        treatment, and over the reference of the lesion that it is placed at.
    distance_to_ends : float, optional
        Least distance along the centerline from the stent's ends to those of the vessel, mm.
    """

    diameter_over_lumen: tuple[float, float] | None = None
    diameter_over_reference: tuple[float, float] | None = None
    distance_to_ends: float | None = None


class Where(NamedTuple):
    """Place of a case's stent in its vessel."""

    plan: Plan
    """The plan, for its frame, and how axes are changed."""
    inputs: InputFiles
    spot: StentMiddle | None
    """Place of the stent; None where the case has no place of its own."""

    @property
    def tree(self) -> Centerline:
        """`InputError` without one."""
        tree = self.inputs.vessel.centerline
        if tree is None:
            raise InputError("lumen: expected a patient with a centerline, got one without.")
        return tree

    @property
    def reference(self) -> float:
        """The reference diameter of the lesion, mm."""
        assert self.spot is not None
        assert self.spot.lesion is not None
        return self.spot.lesion.reference_diameter

    def axis(self, stent: Stent) -> Line:
        """The axis on which a stent lies there."""
        plan, vessel = self.plan, self.inputs.vessel
        if are_apart(plan.frame, self.inputs.surface.frame):
            stent = turned(stent)
        change = AxisChange.of(plan.straightening_fraction, plan.settings)
        return axis_in_vessel(vessel.placed(stent), vessel.centerline, vessel.surface, change).line

    def lumen(self, point: Points) -> float:
        """Inscribed diameter at a place (3,) of the centerline, mm."""
        radius = self.tree.project(point).inscribed_radius
        if not np.isfinite(radius):
            raise InputError(
                "lumen: expected a centerline with the radius of inscribed spheres, got one "
                "without; give diameters in mm."
            )
        return 2 * radius


def check_constraints(stent: Stent, rules: Constraints, where: Where) -> None:
    """Raise `Excluded` for a stent beyond the constraints."""
    if rules.diameter_over_reference is not None:
        ratio = stent.diameter / where.reference
        _check_ratio(ratio, rules.diameter_over_reference, "diameter over the reference")
    if rules.diameter_over_lumen is None and rules.distance_to_ends is None:
        return
    axis = where.axis(stent)
    if rules.diameter_over_lumen is not None:
        ratio = stent.diameter / where.lumen(halfway(axis))
        _check_ratio(ratio, rules.diameter_over_lumen, "diameter over the lumen")
    if rules.distance_to_ends is not None:
        left = min(_distances_to_ends(axis, where.tree))
        if left < rules.distance_to_ends:
            raise Excluded(f"distance to the ends: {left:.1f} mm, below {rules.distance_to_ends:g}")


def halfway(axis: Line) -> Points:
    """The middle of an axis, (3,) mm."""
    middle: Points = axis.at(axis.arc_lengths[-1:] / 2)[0]
    return middle


def _check_ratio(ratio: float, bounds: tuple[float, float], what: str) -> None:
    if not bounds[0] <= ratio <= bounds[1]:
        raise Excluded(f"{what}: {ratio:.3f}, beyond {bounds[0]:g} to {bounds[1]:g}")


def _distances_to_ends(axis: Line, tree: Centerline) -> Iterator[float]:
    """Distances from the ends of an axis along the centerline to root and outlets below, mm."""
    first, last = (tree.project(end) for end in axis.points[[0, -1]])
    yield first.arc_length
    for leaf in tree.leaves:
        if last.index in tree.ancestry(int(leaf)):
            yield float(tree.arc_length[leaf] - last.arc_length)
