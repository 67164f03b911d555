"""The diameters of balloon, lumen and reference, which are three, as they are told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..stent import OfStent, Stent
from ..treatment import TreatedLesion, TreatedStent, treated_ratios
from .facts import RATIOS, TO_HEALTHY
from .sizing import ratio_section
from .words import UNKNOWN, millimeters, number_text

DIAMETERS = {
    "balloon_diameter_mm": "Balloon diameter",
    "lumen_diameter_mm": "Prescribed lumen diameter",
    "reference_diameter_mm": "Reference diameter of the lesion",
}
"""The three of a stent, as its section has them."""

Covered = Sequence[TreatedLesion] | None


def diameters_section(treated: TreatedStent, lesions: Covered) -> dict[str, Any]:
    """The diameters of the lumen, of the balloon and of the healthy vessel, mm; null if unknown.

    The reference is that of the tightest of the lesions that the stent covers.
    """
    stent, balloon = treated.stent, treated.stent.balloon
    return {
        "lumen_diameter_mm": stent.diameter,
        "balloon_diameter_mm": None if balloon is None else balloon.diameter,
        "recoil_fraction": None if balloon is None else balloon.recoil_fraction,
        "recoil_reason": None if balloon is None else balloon.reason,
        "reference_diameter_mm": _reference(_covered(treated, lesions)),
        **ratio_section(treated_ratios(treated, lesions)),
    }


def redilation_section(stent: Stent, again: int | None) -> dict[str, Any]:
    """Which stent it is once more, and which later one is this once more, where there are."""
    placement = stent.placement
    earlier = {"redilates": placement.number} if isinstance(placement, OfStent) else {}
    return earlier if again is None else {**earlier, "dilated_again_as": again}


def stent_balloon_sentences(treated: TreatedStent, lesions: Covered) -> list[str]:
    """Balloon, lumen and reference in one sentence; none for a stent whose lumen was given."""
    return balloon_sentences(treated.stent, _reference(_covered(treated, lesions)))


def balloon_sentences(stent: Stent, reference: float | None) -> list[str]:
    """The same of a stent that is planned; `reference` in mm, None where it is not known."""
    balloon = stent.balloon
    if balloon is None:
        return []
    known = UNKNOWN if reference is None else f"{reference:.2f} mm"
    return [
        f"Balloon {balloon.diameter:g} mm, lumen {stent.diameter:.2f} mm after recoil of "
        f"{100 * balloon.recoil_fraction:g} % ({balloon.reason}), reference {known}."
    ]


def _covered(treated: TreatedStent, lesions: Covered) -> list[TreatedLesion]:
    return [one for one in lesions or () if treated.number in one.stents]


def _reference(covered: Sequence[TreatedLesion]) -> float | None:
    return covered[0].before.reference_diameter if covered else None


def balloon_rows(told: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and value of balloon, lumen and reference; takes them out of a stent's fields."""
    rows = []
    if "redilates" in told:
        rows.append(("Redilation", f"of stent {told.pop('redilates')}"))
    balloon, share = told.pop("balloon_diameter_mm", None), told.pop("recoil_fraction", None)
    reason = told.pop("recoil_reason", None)
    if balloon is not None:
        rows.append((DIAMETERS["balloon_diameter_mm"], millimeters(balloon)))
    if share is not None:
        rows.append(("Recoil", f"{100 * share:g} % of the balloon: {reason}"))
    if "lumen_diameter_mm" in told:
        digits = 1 if balloon is None else 2
        lumen = millimeters(told.pop("lumen_diameter_mm"), digits)
        rows.append((DIAMETERS["lumen_diameter_mm"], lumen))
    if "reference_diameter_mm" in told:
        reference = told.pop("reference_diameter_mm")
        if reference is not None:
            rows.append((DIAMETERS["reference_diameter_mm"], millimeters(reference)))
    labels = {key: f"{TO_HEALTHY} {where}" for key, where in RATIOS.items()}
    for key, words in {**labels, "balloon_to_stenosis": "Balloon : stenosis"}.items():
        ratio = told.pop(key, None)
        if ratio is not None:
            rows.append((words, number_text(ratio, 2)))
    return rows
