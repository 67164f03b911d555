"""A proposal for a lesion, and how a stent compares with it, as they are told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..measure import HealthyPlace
from ..treatment import (
    SEEN_RATIO,
    SizeRatios,
    Suggestion,
    TreatedLesion,
    TreatedStent,
    stent_ratios,
)
from .words import UNKNOWN


def suggestion_sentences(suggestion: Suggestion) -> list[str]:
    """The lesion, the stent, the rule and the ratios, one line each."""
    lesion, stent = suggestion.lesion, suggestion.stent
    balloon = stent.balloon
    assert balloon is not None
    device = "" if stent.device is None else f" of {stent.device.name}"
    return [
        f"Lesion {suggestion.number}: {lesion.percent_diameter:.0f} % by diameter, minimum "
        f"{lesion.minimum_diameter:.2f} mm, {lesion.length:.1f} mm long; healthy vessel "
        f"{_side(lesion.proximal)} proximal, {_side(lesion.distal)} distal.",
        f"Proposed{device}: balloon {balloon.diameter:.1f} mm, lumen {stent.diameter:.2f} mm, "
        f"nominal length {stent.length:g} mm ({suggestion.deployed_length:.1f} mm deployed).",
        f"Rule: {suggestion.rule}. Recoil {100 * balloon.recoil_fraction:g} %: {balloon.reason}.",
        ratio_sentence(suggestion.ratios),
    ]


def ratio_sentence(ratios: SizeRatios) -> str:
    """The ratios with the ranges of their sources; that of the balloon where there is one."""
    low, high = SEEN_RATIO
    to_stenosis, balloon = ratios.balloon_to_stenosis, ""
    if to_stenosis == to_stenosis:
        balloon = (
            f"; balloon : stenosis {to_stenosis:.2f} (above 3.0 the recoil was more than 10 %)"
        )
    return (
        f"Stent : adjacent vessel {ratios.stent_to_adjacent:.2f} (sources {low:.2f} to "
        f"{high:.2f}){balloon}."
    )


def stent_ratio_sentences(
    treated: TreatedStent, lesions: Sequence[TreatedLesion] | None
) -> list[str]:
    """The ratios of a stent to the tightest lesion that it covers; none where it covers none."""
    covered = [one.before for one in lesions or () if treated.number in one.stents]
    return [ratio_sentence(stent_ratios(treated.stent, lesion)) for lesion in covered[:1]]


def suggestion_section(suggestion: Suggestion) -> dict[str, Any]:
    """A proposal as values of JSON."""
    lesion, stent = suggestion.lesion, suggestion.stent
    balloon = stent.balloon
    assert balloon is not None
    return {
        "lesion": suggestion.number,
        "lesion_length_mm": lesion.length,
        "minimum_diameter_mm": lesion.minimum_diameter,
        "proximal_diameter_mm": _diameter(lesion.proximal),
        "distal_diameter_mm": _diameter(lesion.distal),
        "device": None if stent.device is None else stent.device.name,
        "balloon_diameter_mm": balloon.diameter,
        "recoil_fraction": balloon.recoil_fraction,
        "lumen_diameter_mm": stent.diameter,
        "nominal_length_mm": stent.length,
        "deployed_length_mm": suggestion.deployed_length,
        "rule": suggestion.rule,
        "recoil_reason": balloon.reason,
        **ratio_section(suggestion.ratios),
        "warnings": [caution.sentence() for caution in suggestion.cautions()],
    }


def ratio_section(ratios: SizeRatios) -> dict[str, Any]:
    """The ratios as a report has them; null for one that is not known."""
    to_stenosis = ratios.balloon_to_stenosis
    return {
        "stent_to_adjacent": ratios.stent_to_adjacent,
        "balloon_to_stenosis": to_stenosis if to_stenosis == to_stenosis else None,
    }


def _diameter(side: HealthyPlace | None) -> float | None:
    return None if side is None else side.diameter


def _side(side: HealthyPlace | None) -> str:
    return UNKNOWN if side is None else f"{side.diameter:.2f} mm"
