"""The result of a staged plan before a stent is dilated again: that of today, not the last one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ..stent import OfStent
from ..treatment import TreatedLesion, TreatmentResult, Vessel, treated_lesions

_SPACING = 1.0
"""Of the stations along the stents, mm."""


class Today(NamedTuple):
    """What the stents before the first redilation have left."""

    redilation: int
    """Number of the first stent that is an earlier one, dilated again."""
    minimum_lumen: Mapping[int, float]
    """By number of a stent, its smallest inscribed diameter by then, mm; NaN where not known."""
    lesions: tuple[TreatedLesion, ...] | None
    """Before any stent and by then; None without a centerline."""


def today_of(vessel: Vessel, result: TreatmentResult) -> Today | None:
    """The result in a vessel before any stent is dilated again; None where none is."""
    stents = result.stents
    again = [place for place, one in enumerate(stents) if isinstance(one.stent.placement, OfStent)]
    if not again:
        return None
    done = stents[: again[0]]
    surface = done[-1].result.surface
    by_then = Vessel(surface)
    lumen = {one.number: by_then.diameters(one.axis.line, _SPACING).minimum for one in done}
    lesions = None
    if vessel.lesions is not None:
        lesions = treated_lesions(vessel.lesions, done, surface, vessel.surface)
    return Today(stents[again[0]].number, lumen, lesions)
