"""What a stent did to the lumen, in a sentence and as a part of the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ..treatment import TreatedStent
from .facts import BEYOND, MINIMUM
from .lesions import covered_words, lesion_rows
from .shapes import prescribed_words
from .words import UNKNOWN, millimeters


def lumen_sentence(stent: TreatedStent) -> str:
    """What one stent did to the lumen."""
    before, after = stent.before, stent.after
    return (
        f"Lumen over {stent.axis.deployed_length:.1f} mm: narrowest {before.minimum:.2f} mm "
        f"before, {after.minimum:.2f} mm after; mean {before.mean:.2f} mm "
        f"before, {after.mean:.2f} mm after; prescribed {prescribed_words(stent)}."
    )


def first_numbers(diameters: Mapping[str, Any], lesions: Sequence[Mapping[str, Any]] | None) -> str:
    """What a clinician reads first."""
    narrow, over = diameters["minimum_lumen"], diameters["over_stented_length"]
    before, after = over["before"], over["after"]
    rows = [
        (MINIMUM, *(millimeters(narrow[f"{when}_mm"]) for when in ("before", "after"))),
        (BEYOND, *(millimeters(narrow[f"beyond_{when}_mm"]) for when in ("before", "after"))),
        *lesion_rows(lesions or ()),
        ("Mean lumen diameter &plusmn; SD", _mean_sd(before), _mean_sd(after)),
        ("Smallest to largest", _range(before), _range(after)),
        (
            "Mean equivalent diameter",
            millimeters(before["equivalent_mean_mm"]),
            millimeters(after["equivalent_mean_mm"]),
        ),
    ]
    prescribed = [value for value in diameters["along"]["prescribed_mm"] if value is not None]
    wanted = _span(prescribed)
    lines = [
        f"<tr class='first'><td>{name}</td><td class='n'>{old}</td><td class='n'>{new}</td></tr>"
        for name, old, new in rows
    ]
    return (
        "<table><tr><th>over the stented length</th><th class='n'>before</th>"
        f"<th class='n'>after</th></tr>{''.join(lines)}</table><p class='small'>"
        f"Prescribed lumen diameter: {wanted}. Mean after minus prescribed: "
        f"{millimeters(over['mean_after_minus_prescribed_mm'], signed=True)}.<br>"
        f"{escape(covered_words(lesions))}</p>"
    )


def _mean_sd(statistics: Mapping[str, Any]) -> str:
    if statistics["mean_mm"] is None:
        return UNKNOWN
    return f"{statistics['mean_mm']:.2f} &plusmn; {statistics['sd_mm']:.2f} mm"


def _range(statistics: Mapping[str, Any]) -> str:
    ends = (statistics["minimum_mm"], statistics["maximum_mm"])
    return _span([value for value in ends if value is not None])


def _span(values: Sequence[float]) -> str:
    if not values:
        return UNKNOWN
    low, high = min(values), max(values)
    if round(low, 2) == round(high, 2):
        return f"{low:.2f} mm"
    return f"{low:.2f} to {high:.2f} mm"
