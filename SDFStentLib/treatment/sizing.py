"""Diameter and length of a stent for a lesion: a proposal by a rule, and how it compares.

The lumen is made as wide as the healthy vessel beside the lesion, the smaller one of both sides, so
that neither is overstretched; the balloon is wider by its recoil. That is 1.08 of the vessel, and
1.11 in a tight lesion, where about 1.1 is advised (Palmaz stents in great vessels, abstract,
Cardiology in the Young). The stent covers the lesion's extent, or is not proposed: no source says
how far it should go beyond.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..cautions import Caution
from ..centerline import Centerline
from ..parameter import check_parameters, parameter
from ..stent import (
    Balloon,
    Device,
    Stent,
    StentAxis,
    balloon_leaving,
    stent_axis,
)
from ..validation import InputError, printable
from ..vessel import SMALLEST_DEGREE, Lesion
from .placing import NOTICED, HealthyVessel, beside_lesion, placement_at, uncovered_length
from .ratios import SizeRatios, size_ratios

RATIOS = (0.2, 2.0)
"""The least and the most that may be asked for, lumen over the vessel beside the lesion."""

LONGEST_MARGIN = 100.0
"""The most that may be asked for beyond each end of a lesion, mm."""

WHOLE = 1e-9
"""Share of a millimeter by which a length may be above a whole one."""


@dataclass(frozen=True)
class SizingWishes:
    """Options of a stent that is proposed.

    Attributes
    ----------
    ratio : float
        Lumen over the smaller healthy vessel beside the lesion, 0.2 to 2.
    margin : float
        Length beyond the lesion on both sides, mm.
    device : Device, optional
        Device, whose length is taken, or the shortest that it is sold in and that suffices.
    foreshortening_fraction : float, optional
        As of `Stent`.
    """

    ratio: float = parameter(
        "lumen over the smaller healthy vessel beside the lesion",
        default=1.0,
        least=RATIOS[0],
        most=RATIOS[1],
        called="ratio to the adjacent vessel",
    )
    margin: float = parameter(
        "how far beyond both ends of the lesion",
        default=0.0,
        unit="mm",
        least=0.0,
        most=LONGEST_MARGIN,
    )
    device: Device | None = None
    foreshortening_fraction: float | None = None

    def __post_init__(self) -> None:
        check_parameters(self)

    @property
    def own_length(self) -> float | None:
        """Nominal length of the device, mm, where it has one."""
        return None if self.device is None else self.device.nominal_length

    @property
    def rule(self) -> str:
        """The rule by which the sizes are chosen, in words."""
        times = "" if self.ratio == 1 else f"{self.ratio:g} times "
        length = "that of the device"
        if self.own_length is None:
            beyond = f" and {self.margin:g} mm beyond both of its ends" if self.margin else ""
            sold = self.device is not None and self.device.sold_lengths
            rounded = "the shortest that is sold" if sold else "rounded up to whole mm"
            length = f"that of the lesion{beyond}, longer by what shortening takes, {rounded}"
        return (
            f"lumen {times}as wide as the smaller healthy vessel beside the lesion, balloon wider "
            f"by its recoil, rounded to the nearest 0.1 mm, length {length}"
        )


@dataclass(frozen=True)
class Suggestion:
    """A stent for a lesion.

    Attributes
    ----------
    number : int
        Number of the lesion among those of the vessel, from 1.
    lesion : Lesion
    stent : Stent
    axis : StentAxis
        Axis of the stent in the vessel.
    ratios : SizeRatios
    rule : str
        Rule by which its sizes were chosen, in words.
    """

    number: int
    lesion: Lesion
    stent: Stent
    axis: StentAxis
    ratios: SizeRatios
    rule: str

    @property
    def deployed_length(self) -> float:
        """Length after foreshortening, mm."""
        assert self.stent.length is not None
        return self.stent.length * (1.0 - self.stent.foreshortening)

    def within(self, healthy: HealthyVessel) -> Suggestion:
        """The same suggestion, compared with the healthy vessel where it will lie."""
        return replace(self, ratios=replace(self.ratios, healthy=healthy))

    def cautions(self) -> Iterator[Caution]:
        """Cautions on its sizes."""
        yield from self.ratios.cautions()
        lumen, reference = self.stent.diameter, self.lesion.reference_diameter
        narrowest = beside_lesion(self.lesion).narrowest
        if max(narrowest, lumen) <= (1 - SMALLEST_DEGREE) * reference:
            widths = {"reference_mm": reference, "narrowest_mm": narrowest}
            left = 100 * (1 - lumen / reference)
            yield Caution("tapering-lesion", {"lumen_mm": lumen, "percent": left, **widths})
        yield from self.stent.device_cautions()


def suggested(
    lesion: Lesion, number: int, centerline: Centerline, wishes: SizingWishes
) -> Suggestion:
    """A stent for a lesion of a vessel.

    Parameters
    ----------
    lesion : Lesion
    number : int
        Number of the lesion, from 1.
    centerline : Centerline
        Centerline of the vessel in which it was found.
    wishes : SizingWishes

    Raises
    ------
    InputError
        Sizes that the device rules out, or one that would leave a part of the lesion uncovered.
    """
    lumen = wishes.ratio * beside_lesion(lesion).narrowest
    balloon = balloon_leaving(lumen, lesion.minimum_diameter, decimals=1)
    stent = _sized(balloon, lesion, number, wishes)
    assert stent.length is not None
    place = placement_at(lesion, centerline, stent.length, stent.foreshortening)
    stent = replace(stent, placement=place, name=f"lesion {number}")
    axis = stent_axis(stent, centerline)
    left = uncovered_length(lesion, [axis.line])
    if left > NOTICED:
        raise InputError(
            f"lesion {number}: expected a place where one stent covers all of its "
            f"{lesion.length:.1f} mm, got none, {left:.1f} mm stay uncovered; place stents "
            "between points of your own."
        )
    ratios = size_ratios(lesion, balloon.lumen_diameter, balloon.diameter)
    return Suggestion(number, lesion, stent, axis, ratios, wishes.rule)


def _sized(balloon: Balloon, lesion: Lesion, number: int, wishes: SizingWishes) -> Stent:
    """Unplaced stent that covers a lesion after its foreshortening."""
    wanted = lesion.length + 2 * wishes.margin
    offered = () if wishes.device is None else wishes.device.offered_lengths
    stent = Stent(
        balloon.lumen_diameter,
        length=min(offered, default=wanted),
        foreshortening_fraction=wishes.foreshortening_fraction,
        device=wishes.device,
        balloon=balloon,
    )
    left = 1.0 - stent.foreshortening
    if not offered:
        return replace(stent, length=float(math.ceil(wanted / left - WHOLE)))
    enough = [one for one in offered if one * left >= wanted - WHOLE]
    if not enough:
        assert wishes.device is not None
        raise InputError(
            f"device: expected one that is {wanted:.1f} mm long or more at {stent.diameter:.2f} mm "
            f"to cover lesion {number}, got {printable(wishes.device.name)}, which has "
            f"{max(offered) * left:.1f} mm; choose a longer one."
        )
    return replace(stent, length=min(enough))
