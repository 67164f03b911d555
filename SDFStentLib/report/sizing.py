"""Ratios of the diameters of stent, balloon and vessel, and the stent proposed for a lesion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from ..stent import Device, Stent
from ..treatment import SEEN_RATIOS, RatioRange, SizeRatios, Suggestion
from .facts import LINES, Fact, Facts
from .words import UNKNOWN, number_text

TO_HEALTHY = "Stent : healthy vessel"
NARROWEST, PROXIMAL, DISTAL = "where that is narrowest", "at the proximal end", "at the distal end"


def suggestion_facts(suggestion: Suggestion, devices: Sequence[Device] = ()) -> Facts:
    """The lesion, the stent, the rule and the ratios, with a sentence on each.

    `devices` are the rows of the device table, among which a stent of that size is looked for.
    """
    return Facts((*_suggestion(suggestion, devices), *ratio_facts(suggestion.ratios)))


def _suggestion(suggestion: Suggestion, devices: Sequence[Device]) -> Iterator[Fact]:
    lesion, stent, balloon = suggestion.lesion, suggestion.stent, suggestion.stent.balloon
    assert balloon is not None
    sides = {"proximal": lesion.proximal, "distal": lesion.distal}
    healthy = ", ".join(
        f"{UNKNOWN if side is None else f'{side.diameter:.2f} mm'} {name}"
        for name, side in sides.items()
    )
    about = (
        f"Lesion {suggestion.number}: {lesion.percent_diameter:.0f} % by diameter, minimum "
        f"{lesion.minimum_diameter:.2f} mm, {lesion.length:.1f} mm long; healthy vessel {healthy}."
    )
    rule = f"Rule: {suggestion.rule}. Recoil {100 * balloon.recoil_fraction:g} %: {balloon.reason}."
    product = _product_sentences(stent, devices)
    values = {
        "lesion": suggestion.number,
        "lesion_length_mm": lesion.length,
        "minimum_diameter_mm": lesion.minimum_diameter,
        **{f"{name}_diameter_mm": side and side.diameter for name, side in sides.items()},
        "device": stent.device and stent.device.name,
        "balloon_diameter_mm": balloon.diameter,
        "recoil_fraction": balloon.recoil_fraction,
        "lumen_diameter_mm": stent.diameter,
        "nominal_length_mm": stent.length,
        "deployed_length_mm": suggestion.deployed_length,
        "rule": suggestion.rule,
        "recoil_reason": balloon.reason,
        "product": product,
        "warnings": [caution.sentence() for caution in suggestion.cautions()],
    }
    yield from (Fact(key, after=value) for key, value in values.items())
    ratios = ratio_sentence(suggestion.ratios)
    for sentence in (about, proposal_sentence(suggestion), rule, *product, ratios):
        yield Fact(words=sentence, level=LINES)


def proposal_sentence(suggestion: Suggestion) -> str:
    """Sentence on the proposed stent's sizes."""
    stent, balloon = suggestion.stent, suggestion.stent.balloon
    assert balloon is not None
    device = "" if stent.device is None else f" of {stent.device.name}"
    return (
        f"Proposed{device}: balloon {balloon.diameter:.1f} mm, lumen {stent.diameter:.2f} mm, "
        f"nominal length {stent.length:g} mm ({suggestion.deployed_length:.1f} mm deployed)."
    )


def _product_sentences(stent: Stent, devices: Sequence[Device]) -> list[str]:
    """Sentences that sizes are no product's, and which rows of the device table would have them."""
    device = stent.device
    if device is not None and not device.generic:
        if device.offered_lengths:
            return []
        return [
            f"The lengths in which {device.name} is sold are not in the device table: whether one "
            f"of {stent.length:g} mm is made is for its maker to say."
        ]
    told = "These are sizes that the lesion asks for, of no product"
    if not devices:
        return [f"{told}."]
    named = _named(stent, devices)
    found = f"such sizes are known of {', '.join(named)}" if named else "no row has such sizes"
    return [f"{told}; in the table {found}."]


def _named(stent: Stent, devices: Sequence[Device]) -> list[str]:
    """The rows that are known at the sizes of a stent."""
    return [
        row.name
        for row in devices
        if not row.generic
        and (row.nominal_diameters or row.reported_diameters or row.lengths)
        and (row.maximum_diameter is None or stent.inflated_diameter <= row.maximum_diameter)
        and not any(
            one.kind == "device-range" for one in row.cautions(stent.diameter, stent.length)
        )
        and _has_length(row, stent)
    ]


def _has_length(row: Device, stent: Stent) -> bool:
    """Whether a row is known to have a length that suffices."""
    assert stent.length is not None
    if row.lengths and not row.lengths[0][0] <= stent.diameter <= row.lengths[-1][0]:
        return False
    is_known = bool(row.lengths) or row.foreshortening_fraction is not None
    lost = row.foreshortening_at(stent.diameter) if is_known else stent.foreshortening
    wanted = stent.length * (1.0 - stent.foreshortening)
    if row.offered_lengths:
        return max(row.offered_lengths) * (1.0 - lost) >= wanted
    return row.reported_lengths is not None


def ratio_sentence(ratios: SizeRatios) -> str:
    """The ratios with medians and ranges of their sources; that of the balloon if there is one."""
    healthy = ratios.healthy
    told = [
        f"{ratios.diameter / width:.2f} {where} ({width:.1f} mm)"
        for where, width in zip(
            (NARROWEST, PROXIMAL, DISTAL),
            (healthy.narrowest, healthy.proximal, healthy.distal),
            strict=True,
        )
        if not math.isnan(width)
    ]
    to_stenosis, balloon = ratios.balloon_to_stenosis, ""
    if to_stenosis == to_stenosis:
        balloon = f" Balloon : stenosis {to_stenosis:.2f}; above 3.0 the recoil was more than 10 %."
    return f"{TO_HEALTHY} {', '.join(told) or UNKNOWN}. {SOURCES}{balloon}"


def _seen() -> str:
    told = [
        f"{one.vessel} {_range(one.before, 'median ')}, dilated again {_range(one.after)}"
        for one in SEEN_RATIOS
    ]
    return f"In its source: {'; '.join(told)}."


def _range(seen: RatioRange, named: str = "") -> str:
    return f"{seen.low:g} to {seen.high:g} ({named}{seen.median:g})"


SOURCES = _seen()
"""Ranges and medians."""


def ratio_facts(ratios: SizeRatios) -> Iterator[Fact]:
    """The ratios of a stent; none to no stenosis."""
    healthy = ratios.healthy
    for key, where, one in (
        ("adjacent", NARROWEST, ratios.stent_to_adjacent),
        ("proximal", PROXIMAL, ratios.diameter / healthy.proximal),
        ("distal", DISTAL, ratios.diameter / healthy.distal),
    ):
        yield _ratio(f"stent_to_{key}", f"{TO_HEALTHY} {where}", one)
    if not math.isnan(ratios.stenosis_diameter):
        yield _ratio("balloon_to_stenosis", "Balloon : stenosis", ratios.balloon_to_stenosis)


def _ratio(key: str, label: str, value: float) -> Fact:
    words = number_text(value, 2) if math.isfinite(value) else ""
    return Fact(key, label, after=value, words=words)


def balloon_sentences(stent: Stent, reference: float | None) -> list[str]:
    """Balloon, lumen and reference, mm, in one sentence; none for a stent whose lumen was given.

    `reference` is None where it is not known.
    """
    balloon = stent.balloon
    if balloon is None:
        return []
    known = UNKNOWN if reference is None else f"{reference:.2f} mm"
    return [
        f"Balloon {round(balloon.diameter, 2):g} mm, lumen {stent.diameter:.2f} mm after recoil of "
        f"{round(100 * balloon.recoil_fraction, 1):g} % ({balloon.reason}), reference {known}."
    ]
