"""Placement of a plan's stents, one after another in the vessel as it is then."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface
from ..lumen import VesselInside
from ..stent import Stent
from ..validation import Points
from .straightening import AxisChange, axis_in_vessel
from .value import PlacedStent, label_of, labeled, resolved
from .warnings import check_width

Shown = TypeVar("Shown")


class InterimVessel(NamedTuple):
    """A vessel between two stents of a plan."""

    vessel: Surface | VesselInside
    """Vessel into which the next one is put."""
    centerline: Centerline | None
    companions: Points = np.empty((0, 3))
    """(c, 3) further points that are dragged along, mm."""

    @property
    def dragged(self) -> Points:
        """(n, 3) points that are dragged along, mm: the centerline's, then the companions."""
        if self.centerline is None:
            return self.companions
        return np.concatenate([self.centerline.points, self.companions])

    def after(self, vessel: Surface | VesselInside, dragged: Points) -> InterimVessel:
        """The vessel as the next stent finds it, with what was dragged along where it is now."""
        tree = self.centerline
        if tree is None:
            return InterimVessel(vessel, None, dragged)
        moved, companions = np.split(dragged, [len(tree.points)])
        return InterimVessel(vessel, tree.with_points(moved), companions)


@dataclass(frozen=True)
class Placer:
    """Puts stents into the vessel `native`.

    Attributes
    ----------
    native : Surface
        Surface before any stent: none may be far wider than its lumen.
    stents : sequence of Stent
        Stents of the whole plan.
    change : AxisChange
        Smoothing and straightening of their axes.
    rows : sequence of int
        Rows by which messages count the stents; by default their places in `stents`.
    probes : callable, optional
        Points (n, 3) of the native wall that stand for it near those of an axis, mm.
    """

    native: Surface
    stents: Sequence[Stent]
    change: AxisChange
    rows: Sequence[int] = ()
    probes: Callable[[Points], Points] | None = None

    def label(self, number: int) -> str:
        """Name of a stent in messages; empty when there is only one, without a name."""
        return label_of(self.stents, number, self.rows)

    def placed(
        self,
        number: int,
        earlier: Mapping[int, PlacedStent],
        centerline: Centerline | None,
        vessel: Surface | VesselInside,
    ) -> PlacedStent:
        """A stent by number, where the earlier ones have left the centerline and the vessel.

        `InputError` with its label for one that cannot lie there.
        """
        with labeled(self.label(number)):
            stent, lies_on = resolved(self.stents[number - 1], earlier)
            axis = axis_in_vessel(stent, centerline, vessel, self.change, lies_on=lies_on)
            probes = None if self.probes is None else self.probes(axis.points)
            check_width(stent.widest_diameter, axis, self.native, probes)
            row = self.rows[number - 1] if self.rows else number
            return PlacedStent(number, stent, axis, row=row)

    def in_turn(
        self,
        numbers: Iterable[int],
        course: InterimVessel,
        grow: Callable[[PlacedStent, InterimVessel], Generator[Shown, None, InterimVessel]],
        known: Mapping[int, PlacedStent] | None = None,
    ) -> Generator[Shown, None, InterimVessel]:
        """Place stents by number and let each grow, in order; yields the states of all.

        `grow` returns the course behind a stent. Those that are `known` lie where they do.
        """
        placed = dict(known or {})
        for number in numbers:
            if number not in placed:
                placed[number] = self.placed(number, placed, course.centerline, course.vessel)
            course = yield from grow(placed[number], course)
        return course
