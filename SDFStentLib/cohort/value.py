"""A sweep as one value: a plan, what varies in it, in whom, and what a case has to keep to."""

from __future__ import annotations

from dataclasses import dataclass

from ..plan import Plan
from .axes import Axis

MOST_SAMPLES = 10_000_000
"""Of a sweep for each patient."""


@dataclass(frozen=True)
class Sampling:
    """How points are drawn: the method, how many for each patient, and the seed."""

    method: str = "grid"
    count: int = 0
    seed: int = 0


@dataclass(frozen=True)
class Constraints:
    """What a case has to keep to, or is left out.

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


@dataclass(frozen=True)
class Patient:
    """A name, and the base plan on this patient's files, with the hashes of what they hold now."""

    name: str
    plan: Plan


@dataclass(frozen=True, eq=False)
class Sweep:
    """Everything that determines a cohort.

    Attributes
    ----------
    patients : tuple of Patient
    axes : tuple of Axis
    sampling : Sampling
    constraints : Constraints
    stent : int
        The stent of the plan that the axes change, from 1.
    store : {"vtp", "moved"}
    folder : str
        Of the document; paths in it start there.
    time_limit : float, optional
        For each case, s: after it the case has failed. It changes no result.
    """

    patients: tuple[Patient, ...]
    axes: tuple[Axis, ...]
    sampling: Sampling
    constraints: Constraints = Constraints()
    stent: int = 1
    store: str = "vtp"
    folder: str = ""
    time_limit: float | None = None
