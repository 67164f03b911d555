"""The way from the balloon to the lumen: a stent recoils when the balloon is let down.

Source of the rule: Palmaz stents in pulmonary arteries and veins, aorta and superior vena cava
(abstract, Cardiology in the Young): balloons of 8.2 +- 2.4 mm left lumens of 7.7 +- 2.3 mm, a
recoil of 7 +- 4 %, the same for all stents and vessels, and of more than 10 % where the lumen had
been below 3 mm or the balloon more than 3 times as wide as it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..parameter import check_parameters
from ..validation import InputError, as_number
from .device import MAXIMUM_DIAMETER, diameter_field, part_field

USUAL_RECOIL = 0.07
"""Usual recoil, as a part of the balloon's diameter: mean of the source, whose SD is 0.04."""

RAISED_RECOIL = 0.10
"""The recoil where the source saw more than this: its least."""

NARROW_LUMEN = 3.0
"""Native lumen below which the recoil is raised, mm."""

WIDE_BALLOON = 3.0
"""Diameter of the balloon over that of the native lumen above which the recoil is raised."""

MOST_RECOIL = 0.5
"""Largest plausible recoil."""

AS_GIVEN = "as given"
"""The reason for a recoil that no rule has chosen."""


@dataclass(frozen=True)
class Balloon:
    """The balloon that expands a stent, and where its recoil is from."""

    diameter: float = diameter_field(
        "of the balloon; the lumen is what recoil leaves of it",
        option="balloon",
        called="balloon diameter",
    )
    recoil_fraction: float = part_field(
        f"part of the balloon's diameter that is lost; by default {USUAL_RECOIL:g}, or "
        f"{RAISED_RECOIL:g} in a lumen below {NARROW_LUMEN:g} mm or of less than a third of "
        "the balloon",
        0,
        MOST_RECOIL,
        option="recoil",
        called="recoil",
    )
    reason: str = AS_GIVEN

    def __post_init__(self) -> None:
        check_parameters(self)

    @property
    def is_given(self) -> bool:
        """Whether its recoil was given, rather than found by the rule."""
        return self.reason == AS_GIVEN

    @property
    def lumen_diameter(self) -> float:
        """Lumen after its deflation, mm: the deployed diameter."""
        return self.diameter * (1.0 - self.recoil_fraction)


def balloon_by_rule(diameter: float, native_lumen: float) -> Balloon:
    """A balloon whose recoil follows the rule of the source.

    Parameters
    ----------
    diameter : float
        Diameter of the balloon, mm.
    native_lumen : float
        Smallest inscribed diameter where the stent will lie, before it, mm; NaN where not known.
    """
    as_number(diameter, "balloon diameter", unit="mm", above=0, maximum=MAXIMUM_DIAMETER)
    usual = "the mean in great vessels (7 \N{PLUS-MINUS SIGN} 4 %)"
    raised = "more than that was seen where"
    if math.isnan(native_lumen):
        return Balloon(diameter, USUAL_RECOIL, f"{usual}; the native lumen is not known")
    if native_lumen < NARROW_LUMEN:
        reason = f"{raised} the native lumen was below 3 mm; it is {native_lumen:.1f} mm"
        return Balloon(diameter, RAISED_RECOIL, reason)
    if diameter > WIDE_BALLOON * native_lumen:
        ratio = diameter / native_lumen
        reason = f"{raised} the balloon was over 3 times the native lumen; it is {ratio:.1f} times"
        return Balloon(diameter, RAISED_RECOIL, reason)
    return Balloon(diameter, USUAL_RECOIL, usual)


def balloon_of(
    diameter: float, recoil_fraction: float | None = None, native_lumen: float = math.nan
) -> Balloon:
    """Balloon of a diameter, mm, with a given recoil, or by the rule in a lumen."""
    if recoil_fraction is None:
        return balloon_by_rule(diameter, native_lumen)
    return Balloon(diameter, recoil_fraction)


def balloon_leaving(lumen: float, native_lumen: float, decimals: int | None = None) -> Balloon:
    """The balloon that leaves a lumen when it recoils by the rule.

    Parameters
    ----------
    lumen : float
        Lumen that it shall leave, mm.
    native_lumen : float
        As of `balloon_by_rule`.
    decimals : int, optional
        Decimals to which the balloon's diameter, mm, is rounded; it leaves about the lumen then.
    """

    def losing(recoil: float) -> Balloon:
        diameter = lumen / (1.0 - recoil)
        rounded = diameter if decimals is None else round(diameter, decimals)
        return balloon_by_rule(rounded, native_lumen)

    usual = losing(USUAL_RECOIL)
    # A wider one recoils no less.
    return usual if usual.recoil_fraction == USUAL_RECOIL else losing(RAISED_RECOIL)


def check_lumen(balloon: Balloon, diameter: float) -> None:
    """Refuse a lumen, mm, other than the balloon leaves; `InputError`."""
    left = balloon.lumen_diameter
    if not math.isclose(diameter, left, rel_tol=1e-9):
        raise InputError(
            f"stent diameter: expected {left:g} mm, the lumen that a balloon of "
            f"{balloon.diameter:g} mm leaves with a recoil of {100 * balloon.recoil_fraction:g} %, "
            f"got {diameter:g} mm; leave one of them out."
        )
