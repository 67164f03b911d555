"""Ratios of a stent and its balloon to the vessel, and those that sources had."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..cautions import Caution
from ..stent import WIDE_BALLOON, OfStent, Stent
from ..vessel import Lesion
from .lesions import TreatedLesion
from .placing import HealthyVessel, beside_lesion, healthy_vessel
from .value import TreatedStent


class RatioRange(NamedTuple):
    """Ratios of a source."""

    median: float
    low: float
    high: float


class SeenRatios(NamedTuple):
    """Stents over one kind of vessel, before they were dilated again and after that."""

    vessel: str
    """Words for the vessel whose diameter is the denominator."""
    before: RatioRange
    after: RatioRange


SEEN_RATIOS = (
    SeenRatios(
        "distal pulmonary artery", RatioRange(0.66, 0.44, 1.5), RatioRange(0.86, 0.48, 1.88)
    ),
    SeenRatios("descending aorta", RatioRange(0.66, 0.38, 1.02), RatioRange(0.85, 0.52, 1.2)),
)
"""Palmaz stents at 21 sites of pulmonary arteries and in 12 coarctations, median and range (Heart
2003;89:905, abstract). One pulmonary artery ruptured distal to its stent; where neointima was more
than 1 mm thick in pulmonary arteries, 5 of 9 stents had been overdilated at implantation."""

WIDE = 1.2
"""Ratio of stent to healthy vessel from which on a caution is given: the most of `SEEN_RATIOS` in
coarctations. In pulmonary arteries more was seen, and a rupture."""

NARROW = 0.38
"""The least of them."""


@dataclass(frozen=True)
class SizeRatios:
    """Diameters of a stent and its balloon against the vessel in which it lies.

    Attributes
    ----------
    diameter : float
        Diameter of its lumen, mm.
    healthy : HealthyVessel
        Healthy vessel in which it lies.
    stenosis_diameter : float
        Smallest inscribed diameter of the lesion that it covers, mm; NaN where it covers none.
    balloon_to_stenosis : float
        Balloon over that; NaN without a balloon, and for one that is dilated again: that balloon
        finds the lumen that the first has left.
    """

    diameter: float
    healthy: HealthyVessel
    stenosis_diameter: float = math.nan
    balloon_to_stenosis: float = math.nan

    @property
    def adjacent_diameter(self) -> float:
        """Diameter of the healthy vessel where it is narrowest, mm."""
        return self.healthy.narrowest

    @property
    def stent_to_adjacent(self) -> float:
        """Lumen over that."""
        return self.diameter / self.adjacent_diameter

    @property
    def narrowest_place(self) -> str:
        """Words for the place where the healthy vessel is narrowest."""
        narrow = self.healthy
        if narrow.narrowest == narrow.distal:
            return "at its distal end"
        return "at its proximal end" if narrow.narrowest == narrow.proximal else "that it lies in"

    def cautions(self) -> Iterator[Caution]:
        """Cautions for ratios beyond what their source saw."""
        ratio, healthy = self.stent_to_adjacent, {"healthy_mm": self.adjacent_diameter}
        where = {"where": self.narrowest_place}
        if ratio > WIDE:
            widths = {"stent_diameter_mm": self.diameter, "times": ratio, **healthy}
            yield Caution("overdilated", {**widths, **where})
        if ratio < NARROW:
            yield Caution("ratio-adjacent", {"ratio": ratio, **healthy, **where})
        if self.balloon_to_stenosis > WIDE_BALLOON:
            ratios = {"ratio": self.balloon_to_stenosis, "high": WIDE_BALLOON}
            yield Caution("ratio-stenosis", {**ratios, "stenosis_mm": self.stenosis_diameter})


def size_ratios(
    lesion: Lesion,
    lumen: float,
    balloon: float = math.nan,
    healthy: HealthyVessel | None = None,
) -> SizeRatios:
    """Ratios of the diameters, mm, of a stent's lumen and of its balloon to a lesion's.

    With the healthy vessel where the stent lies, else with that beside the lesion.
    """
    healthy, stenosis = healthy or beside_lesion(lesion), lesion.minimum_diameter
    return SizeRatios(lumen, healthy, stenosis, balloon / stenosis)


def stent_ratios(stent: Stent, lesion: Lesion, healthy: HealthyVessel | None = None) -> SizeRatios:
    """Ratios of a stent to a lesion that it covers; `healthy` as for `size_ratios`."""
    balloon = stent.balloon
    if balloon is None or isinstance(stent.placement, OfStent):
        return size_ratios(lesion, stent.diameter, math.nan, healthy)
    return size_ratios(lesion, stent.diameter, balloon.diameter, healthy)


def treated_ratios(one: TreatedStent, lesions: Sequence[TreatedLesion] | None) -> SizeRatios:
    """Ratios of a stent to the vessel where it lies, and to the tightest lesion it covers.

    Parameters
    ----------
    one : TreatedStent
    lesions : sequence of TreatedLesion or None
        Lesions of its vessel; None where they were not looked for.
    """
    native = None if lesions is None else [lesion.before for lesion in lesions]
    healthy = healthy_vessel(one.around_before, one.axis.deployed_length, native)
    for lesion in lesions or ():
        if one.number in lesion.stents:
            return stent_ratios(one.stent, lesion.before, healthy)
    return SizeRatios(one.stent.diameter, healthy)


def ratio_cautions(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    label: Callable[[int], str] = "".format,
) -> Iterator[Caution]:
    """Cautions for ratios beyond what their source saw; `label` names a stent by its number."""
    for one in stents:
        for caution in treated_ratios(one, lesions).cautions():
            yield replace(caution, stent=one.number).labeled(label(one.number))
