"""Values of a treatment: a state per step, and the result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..centerline import Centerline
from ..certificate import Certificate
from ..deformation import DeploymentResult, DeploymentState
from ..geometry import Surface
from ..lumen import DiameterProfile, ExtendedAxis, FaceStretch, face_stretches
from ..stent import (
    Lattice,
    OfStent,
    Stent,
    StentAxis,
    design_of,
    laid_along,
    redilated,
    stent_lattice,
)
from ..validation import DeploymentError, Floats, InputError, Points
from ..vessel import Apposition, NeighborLumen, Ostium


@dataclass(frozen=True)
class TreatmentState:
    """The vessel at one radius of one of the stents.

    Attributes
    ----------
    placed : PlacedStent
        That stent in its place.
    fraction : float
        Done of the whole treatment, in [0, 1].
    deployment : DeploymentState
        Radius, and the points that this stent has moved.
    before : Surface
        As the earlier stents have left it.
    """

    placed: PlacedStent
    fraction: float
    deployment: DeploymentState
    before: Surface

    @property
    def number(self) -> int:
        """The number of the stent in the plan, from 1."""
        return self.placed.number

    def points(self) -> Points:
        """Points (n, 3) of the surface in this state, mm."""
        return self.deployment.applied_to(self.before.points)


@dataclass(frozen=True)
class PlacedStent:
    """A stent of a plan in its place in the vessel.

    Attributes
    ----------
    number : int
        Number in the plan, from 1.
    stent : Stent
    axis : StentAxis
        Axis in the vessel.
    """

    number: int
    stent: Stent
    axis: StentAxis
    row: int = field(default=0, kw_only=True)
    """Row for whoever reads of it, from 1: by default its number in the plan."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "row", self.row or self.number)

    @property
    def earlier(self) -> int | None:
        """Number of the stent that it dilates again; None where it dilates none."""
        placement = self.stent.placement
        return placement.number if isinstance(placement, OfStent) else None

    def prescribed(self, arc_length: Floats) -> Floats:
        """Diameters (k,), mm, that it shall have at some arc lengths (k,) of its axis, mm."""
        if self.axis.profile is None:
            return np.full(len(arc_length), float(self.stent.diameter))
        return self.axis.profile.at(arc_length / self.axis.deployed_length)

    def lattice(self, radius: float | None = None) -> Lattice:
        """Its rings and struts; while it expands, at its largest radius by then, mm."""
        if radius is None:
            return stent_lattice(self.stent, self.axis)
        design = design_of(self.stent)
        expansion = design.expansion_at(radius, self.stent.widest_diameter / 2)
        return stent_lattice(self.stent, self.axis, design, expansion)

    def laid(self, points: Points) -> Points:
        """Points (n, 3) of a straight mesh, along z and its middle at z = 0, where it lies, mm."""
        return laid_along(points, self.stent, self.axis)


@dataclass(frozen=True)
class TreatedStent(PlacedStent):
    """A stent after the treatment.

    Attributes
    ----------
    before, after : DiameterProfile
        Diameters of the vessel along the axis, before any stent and after all of them.
    around_before, around_after : DiameterProfile
        Diameters likewise, and up to 20 mm beyond both ends.
    way : ExtendedAxis
        Axis and the way beyond both ends, along which the places of branches count.
    branches : tuple of Ostium
        Side branches near it, found on the surface that it was put into.
    neighbors : tuple of NeighborLumen
        Lumens beside it whose wall has moved; branches by the names of their ostia.
    apposition : Apposition or None
        Contact with the wall after treatment; None for one that is dilated again, which then
        has neither this size nor this place.
    again : int or None
        Number of the last of the later stents that are this one, dilated again.
    again_row : int or None
        Row by which a reader counts that one; its own `row` where it is dilated again at once.
    earlier_row : int or None
        Row of the stent that it dilates again; None where it dilates none.
    result : DeploymentResult
        Its deployment, before the stents after it.
    """

    before: DiameterProfile
    after: DiameterProfile
    around_before: DiameterProfile
    around_after: DiameterProfile
    way: ExtendedAxis
    branches: tuple[Ostium, ...]
    neighbors: tuple[NeighborLumen, ...]
    apposition: Apposition | None
    again: int | None
    result: DeploymentResult
    again_row: int | None = field(default=None, kw_only=True)
    earlier_row: int | None = field(default=None, kw_only=True)

    @property
    def moved_points(self) -> int:
        """Number of points of the surface that it moved."""
        return len(self.result.state.indices)


@dataclass(frozen=True)
class TreatmentResult:
    """Result of a treatment.

    Attributes
    ----------
    before, surface : Surface
        Surfaces before any stent, and after all of them.
    indices : (k,) array
        Points that moved; the others have the bits of the input.
    centerline : Centerline or None
        Moved along.
    companions : (c, 3) array
        Further points that were dragged along, mm.
    stents : tuple of TreatedStent
        Stents that were switched on, in order.
    certificate : Certificate or None
        Certificate from the input to the end of the plan; None when the settings ask for none.
    warnings : tuple of Caution
        Cautions for the user; `str` of one is its sentence.
    timings : dict
        Seconds for setup, deploy, measure and certify.
    """

    before: Surface
    surface: Surface
    indices: NDArray[np.int64]
    centerline: Centerline | None
    companions: Points
    stents: tuple[TreatedStent, ...]
    certificate: Certificate | None
    warnings: tuple[Caution, ...]
    timings: dict[str, float]

    @property
    def points(self) -> Points:
        """The points (n, 3) of the surface after all stents, mm."""
        return self.surface.points

    @property
    def coordinates(self) -> Points:
        """(k, 3) where the moved points are, mm."""
        return self.points[self.indices]

    @property
    def final_stents(self) -> tuple[TreatedStent, ...]:
        """Stents that lie in the vessel in the end: one that is dilated again once, as the last."""
        return tuple(stent for stent in self.stents if stent.again is None)

    @cached_property
    def stretch(self) -> FaceStretch:
        """The stretch of every triangle."""
        return face_stretches(self.before, self.surface)


def switched_on(stents: Sequence[Stent]) -> list[tuple[int, Stent]]:
    """The stents of a plan to deploy, with their numbers; `InputError` when there is none."""
    enabled = [(number, stent) for number, stent in enumerate(stents, start=1) if stent.enabled]
    if not enabled:
        raise InputError(
            f"plan: expected at least one stent that is switched on, got {len(stents)} "
            "stents, all switched off; switch one on."
            if stents
            else "plan: expected at least one stent, got none; add one."
        )
    return enabled


def is_redilation(stent: Stent, number: int) -> bool:
    """Whether a stent is that of a number, dilated again."""
    return isinstance(stent.placement, OfStent) and stent.placement.number == number


def latest_of(number: int, stents: Mapping[int, Stent]) -> int:
    """The number as which a stent lies in the vessel: its own, or that of its last redilation.

    The stents are in order and resolved, so that each follows the state before it.
    """
    for later, stent in stents.items():
        if is_redilation(stent, number):
            number = later
    return number


def resolved(stent: Stent, placed: Mapping[int, PlacedStent]) -> tuple[Stent, StentAxis | None]:
    """Stent with the sizes, and the axis, of the earlier one it dilates again; None for no such
    axis.

    One that has been dilated again in between is dilated as it lies by then.

    Parameters
    ----------
    stent : Stent
    placed : mapping of int to PlacedStent
        The earlier stents by number, in order.

    Raises
    ------
    InputError
        No such stent before it, or one that cannot be dilated so.
    """
    placement = stent.placement
    if not isinstance(placement, OfStent):
        return stent, None
    if placement.number not in placed:
        raise InputError(
            f"redilation: expected an earlier stent that is switched on, got number "
            f"{placement.number}; switch that one on, or put this stent behind it."
        )
    number = latest_of(placement.number, {one.number: one.stent for one in placed.values()})
    again, first = replace(stent, placement=OfStent(number)), placed[number]
    return redilated(again, first.stent, first.axis), first.axis


def label_of(stents: Sequence[Stent], number: int, rows: Sequence[int] = ()) -> str:
    """Name of a stent in messages; empty when there is only one, without a name of its own.

    Where `rows` tell by what each is counted, by that.
    """
    row = rows[number - 1] if rows else number
    plain, name = f"Stent {row}", stents[number - 1].name
    if name in ("", plain):
        return "" if len(stents) == 1 else f"{plain}: "
    return f"{plain} ({name}): "


@contextmanager
def labeled(label: str) -> Iterator[None]:
    """Label errors that are raised inside with their stent."""
    try:
        yield
    except InputError as error:
        raise error.labeled(label) from error
    except DeploymentError as error:
        raise DeploymentError(f"{label}{error}") from error
