"""Stents of a plan put into a vessel, one after another, as it is by then."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ..centerline import Centerline
from ..geometry import Surface
from ..lumen import VesselInside
from ..stent import Stent
from ..validation import Points
from .straightening import AxisChange, axis_in_vessel
from .value import PlacedStent, label_of, labeled, resolved
from .warnings import check_width


@dataclass(frozen=True)
class Placer:
    """Puts stents into the vessel `native`.

    Attributes
    ----------
    native : Surface
        Before any stent: none may be far wider than its lumen.
    stents : sequence of Stent
        All of the plan.
    change : AxisChange
        What is done to their axes.
    rows : sequence of int
        By which messages count the stents; without, by their places in `stents`.
    probes : callable, optional
        Points (n, 3) of the native wall that stand for it near those of an axis, mm.
    """

    native: Surface
    stents: Sequence[Stent]
    change: AxisChange
    rows: Sequence[int] = ()
    probes: Callable[[Points], Points] | None = None

    def label(self, number: int) -> str:
        """How a message names a stent; empty when there is only one, without a name."""
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
