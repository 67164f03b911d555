"""How wide and how long a stent for a lesion is: a proposal by a rule, and how it compares.

The lumen is made as wide as the healthy vessel beside the lesion, the smaller one of both sides, so
that neither is overstretched; the balloon is wider by its recoil. That is 1.08 of the vessel, and
1.11 in a tight lesion, where about 1.1 is advised (Palmaz stents in great vessels, abstract,
Cardiology in the Young). The stent covers the lesion's extent: no source says how far it should go
beyond.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..measure import Lesion
from ..stent import (
    RAISED_RECOIL,
    USUAL_RECOIL,
    WIDE_BALLOON,
    AtCenter,
    Balloon,
    Device,
    Stent,
    balloon_by_rule,
)
from ..validation import as_number
from .lesions import TreatedLesion, placement_at
from .value import TreatedStent

SEEN_RATIO = (0.66, 1.02)
"""Stent over the vessel beside it, as sources had it.

0.66 at first in growing children and 0.85 (descending aorta) and 0.86 (distal pulmonary artery)
after redilation (Heart 2003;89:905); coarctation over descending aorta 0.84 +- 0.18 after stenting
(COAST, Catheter Cardiovasc Interv 2013;82:503), and 0.92 (J Am Coll Cardiol 2001;38:1518).
"""

RATIOS = (0.2, 2.0)
"""The least and the most that may be asked for, lumen over the vessel beside the lesion."""

LONGEST_MARGIN = 100.0
"""The most that may be asked for beyond each end of a lesion, mm."""

WHOLE = 1e-9
"""Share of a millimeter by which a length may be above a whole one."""


@dataclass(frozen=True)
class SizingWishes:
    """What a stent that is proposed shall be.

    Attributes
    ----------
    ratio : float
        Lumen over the smaller healthy vessel beside the lesion, 0.2 to 2.
    margin : float
        How far it goes beyond the lesion on both sides, mm.
    device : Device, optional
        Its length is taken where it has one.
    foreshortening_fraction : float, optional
        As of `Stent`.
    """

    ratio: float = 1.0
    margin: float = 0.0
    device: Device | None = None
    foreshortening_fraction: float | None = None

    def __post_init__(self) -> None:
        low, high = RATIOS
        as_number(self.ratio, "ratio to the adjacent vessel", minimum=low, maximum=high)
        as_number(self.margin, "margin", unit="mm", minimum=0, maximum=LONGEST_MARGIN)

    @property
    def own_length(self) -> float | None:
        """Nominal length of the device, mm, where it has one."""
        return None if self.device is None else self.device.nominal_length

    @property
    def rule(self) -> str:
        """By which the sizes are chosen, in words."""
        times = "" if self.ratio == 1 else f"{self.ratio:g} times "
        length = "that of the device"
        if self.own_length is None:
            beyond = f" and {self.margin:g} mm beyond both of its ends" if self.margin else ""
            lost = "longer by what shortening takes, rounded up to whole mm"
            length = f"that of the lesion{beyond}, {lost}"
        return (
            f"lumen {times}as wide as the smaller healthy vessel beside the lesion, balloon wider "
            f"by its recoil, rounded to the nearest 0.1 mm, length {length}"
        )


@dataclass(frozen=True)
class SizeRatios:
    """How a stent compares with the vessel of a lesion.

    Attributes
    ----------
    adjacent_diameter : float
        Of the healthy vessel beside the lesion, the smaller side, mm.
    stent_to_adjacent : float
        Lumen over that.
    stenosis_diameter : float
        Smallest inscribed diameter of the lesion, mm.
    balloon_to_stenosis : float
        Balloon over that; NaN without a balloon.
    """

    adjacent_diameter: float
    stent_to_adjacent: float
    stenosis_diameter: float
    balloon_to_stenosis: float

    def cautions(self) -> Iterator[Caution]:
        """Where a ratio is beyond what its source saw."""
        low, high = SEEN_RATIO
        if not low <= self.stent_to_adjacent <= high:
            numbers = {"ratio": self.stent_to_adjacent, "low": low, "high": high}
            yield Caution("ratio-adjacent", {**numbers, "adjacent_mm": self.adjacent_diameter})
        if self.balloon_to_stenosis > WIDE_BALLOON:
            ratios = {"ratio": self.balloon_to_stenosis, "high": WIDE_BALLOON}
            yield Caution("ratio-stenosis", {**ratios, "stenosis_mm": self.stenosis_diameter})


@dataclass(frozen=True)
class Suggestion:
    """A stent for a lesion.

    Attributes
    ----------
    number : int
        Of the lesion among those of the vessel, from 1.
    lesion : Lesion
    stent : Stent
    ratios : SizeRatios
    rule : str
        By which its sizes were chosen, in words.
    """

    number: int
    lesion: Lesion
    stent: Stent
    ratios: SizeRatios
    rule: str

    @property
    def deployed_length(self) -> float:
        """After foreshortening, mm."""
        assert self.stent.length is not None
        return self.stent.length * (1.0 - self.stent.foreshortening)

    def cautions(self) -> Iterator[Caution]:
        """What there is to say of its sizes."""
        yield from self.ratios.cautions()
        if self.deployed_length < self.lesion.length:
            lengths = {"deployed_mm": self.deployed_length, "lesion_mm": self.lesion.length}
            yield Caution("shorter-than-lesion", lengths)


def adjacent_diameter(lesion: Lesion) -> float:
    """Diameter of the healthy vessel beside a lesion, mm: of the smaller side that is known."""
    return min(side.diameter for side in (lesion.proximal, lesion.distal) if side is not None)


def size_ratios(lesion: Lesion, lumen: float, balloon: float = math.nan) -> SizeRatios:
    """How the diameters, mm, of a stent's lumen and of its balloon compare with a lesion's."""
    adjacent, stenosis = adjacent_diameter(lesion), lesion.minimum_diameter
    return SizeRatios(adjacent, lumen / adjacent, stenosis, balloon / stenosis)


def stent_ratios(stent: Stent, lesion: Lesion) -> SizeRatios:
    """How a stent compares with a lesion that it covers."""
    balloon = math.nan if stent.balloon is None else stent.balloon.diameter
    return size_ratios(lesion, stent.diameter, balloon)


def ratio_cautions(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion],
    label: Callable[[int], str] = "".format,
) -> Iterator[Caution]:
    """Where a stent's ratio to the tightest lesion that it covers is beyond what its source saw.

    `label` names a stent by its number.
    """
    for one in stents:
        covered = [lesion.before for lesion in lesions if one.number in lesion.stents]
        for lesion in covered[:1]:
            for caution in stent_ratios(one.stent, lesion).cautions():
                yield replace(caution, stent=one.number).labeled(label(one.number))


def suggested(
    lesion: Lesion, number: int, centerline: Centerline, wishes: SizingWishes
) -> Suggestion:
    """A stent for a lesion of a vessel.

    Parameters
    ----------
    lesion : Lesion
    number : int
        Of the lesion, from 1.
    centerline : Centerline
        Of the vessel in which it was found.
    wishes : SizingWishes

    Raises
    ------
    InputError
        Sizes that the device rules out.
    """
    balloon = _balloon(wishes.ratio * adjacent_diameter(lesion), lesion.minimum_diameter)
    stent = _sized(balloon, lesion.length + 2 * wishes.margin, wishes)
    assert stent.length is not None
    place = placement_at(lesion, centerline, stent.length, stent.foreshortening)
    return Suggestion(
        number,
        lesion,
        replace(stent, placement=place, name=f"lesion {number}"),
        size_ratios(lesion, balloon.lumen_diameter, balloon.diameter),
        wishes.rule,
    )


def _balloon(lumen: float, native: float) -> Balloon:
    """The balloon that leaves about a lumen, to a tenth of a millimeter."""
    usual = balloon_by_rule(round(lumen / (1.0 - USUAL_RECOIL), 1), native)
    if usual.recoil_fraction == USUAL_RECOIL:
        return usual
    # A wider one recoils no less.
    return balloon_by_rule(round(lumen / (1.0 - RAISED_RECOIL), 1), native)


def _sized(balloon: Balloon, wanted: float, wishes: SizingWishes) -> Stent:
    """A stent at no place yet that is about so long once it has shortened, in whole mm."""
    own = wishes.own_length
    stent = Stent(
        balloon.lumen_diameter,
        placement=AtCenter(np.zeros(3)),
        length=own or wanted,
        foreshortening_fraction=wishes.foreshortening_fraction,
        device=wishes.device,
        balloon=balloon,
    )
    if own is not None:
        return stent
    return replace(stent, length=float(math.ceil(wanted / (1.0 - stent.foreshortening) - WHOLE)))
