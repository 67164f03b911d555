"""Diameters along a line, and what a stent did to them: table, document, sentence and page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from ..geometry import Line
from ..lumen import DiameterProfile
from ..treatment import TreatedStent
from ..units import MILLIMETERS
from ..validation import Points
from .facts import BEYOND, MINIMUM
from .lesions import covered_words, lesion_rows
from .stents import prescribed_words
from .words import UNKNOWN, millimeters


class MeasuredLine(NamedTuple):
    """A line along which diameters were measured."""

    title: str
    line: Line
    profile: DiameterProfile


def diameter_table(line: MeasuredLine, units: str) -> str:
    """Lines of text; the ends are in the unit of the file."""
    profile = line.profile
    ends = " to ".join(filed_point(line.line.points[end], units) for end in (0, -1))
    rows = [
        f"{line.title}: {line.line.length:.1f} mm, from {ends} {units}",
        "  at (mm)  inscribed (mm)  equivalent (mm)",
    ]
    for at, *diameters in zip(
        profile.arc_length, profile.inscribed_diameter, profile.equivalent_diameter, strict=True
    ):
        inscribed, equivalent = map(_cell, diameters)
        rows.append(f"{at:9.1f}  {inscribed:>14}  {equivalent:>15}")
    if math.isfinite(profile.minimum):
        rows.append(
            f"  inscribed: narrowest {profile.minimum:.2f} mm at {profile.minimum_arc_length:.1f} "
            f"mm, mean {profile.mean:.2f} mm, widest {profile.maximum:.2f} mm"
        )
    return "\n".join([*rows, ""])


def diameter_section(line: MeasuredLine) -> dict[str, Any]:
    """Plain values; None where a diameter is not known."""
    profile = line.profile
    return {
        "title": line.title,
        "start_mm": line.line.points[0].tolist(),
        "end_mm": line.line.points[-1].tolist(),
        "length_mm": line.line.length,
        "arc_length_mm": profile.arc_length.tolist(),
        "inscribed_mm": [_known(value) for value in profile.inscribed_diameter],
        "equivalent_mm": [_known(value) for value in profile.equivalent_diameter],
        "minimum_mm": _known(profile.minimum),
        "mean_mm": _known(profile.mean),
        "maximum_mm": _known(profile.maximum),
    }


def filed_point(point: Points, units: str) -> str:
    """A point, mm, as a file in that unit has it."""
    return "(" + ", ".join(f"{value / MILLIMETERS[units]:.4g}" for value in point) + ")"


def _cell(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


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
