"""Diameters along a line, and what a stent did to them: table, document, sentence and page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..geometry import Line
from ..lumen import DiameterProfile
from ..treatment import TreatedStent, prescribed_diameters
from ..units import MILLIMETERS
from ..validation import Floats, Points, coordinates
from .facts import BEYOND, MINIMUM
from .lesions import covered_words, lesion_rows
from .markup import paragraph, table
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
    """As values of JSON."""
    profile = line.profile
    return {
        "title": line.title,
        "start_mm": line.line.points[0],
        "end_mm": line.line.points[-1],
        "length_mm": line.line.length,
        "arc_length_mm": profile.arc_length,
        "inscribed_mm": profile.inscribed_diameter,
        "equivalent_mm": profile.equivalent_diameter,
        "minimum_mm": profile.minimum,
        "mean_mm": profile.mean,
        "maximum_mm": profile.maximum,
    }


def filed_point(point: Points, units: str) -> str:
    """A point, mm, as a file in that unit has it."""
    return coordinates(point / MILLIMETERS[units])


def _cell(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


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
        ("Mean lumen diameter \N{PLUS-MINUS SIGN} SD", _mean_sd(before), _mean_sd(after)),
        ("Smallest to largest", _range(before), _range(after)),
        (
            "Mean equivalent diameter",
            millimeters(before["equivalent_mean_mm"]),
            millimeters(after["equivalent_mean_mm"]),
        ),
    ]
    wanted = _span([one for one in diameters["along"]["prescribed_mm"] if one is not None])
    error = millimeters(over["mean_after_minus_prescribed_mm"], signed=True)
    head = ("over the stented length", "before", "after")
    return "".join(
        [
            table(rows, head, ("", "n", "n"), row_look="first"),
            paragraph(
                f"Prescribed lumen diameter: {wanted}. Mean after minus prescribed: {error}.",
                "small",
            ),
            paragraph(covered_words(lesions), "small"),
        ]
    )


def _mean_sd(statistics: Mapping[str, Any]) -> str:
    if statistics["mean_mm"] is None:
        return UNKNOWN
    return f"{statistics['mean_mm']:.2f} \N{PLUS-MINUS SIGN} {statistics['sd_mm']:.2f} mm"


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


def stent_diameters(stent: TreatedStent) -> dict[str, Any]:
    """The diameters of a stent as a report has them."""
    before, after = stent.before, stent.after
    own = before.arc_length
    error = after.inscribed_diameter - prescribed_diameters(stent.stent, stent.axis, own)
    return {
        "along": _along(stent),
        "stent_ends_mm": own[[0, -1]],
        "over_stented_length": {
            "before": _statistics(before),
            "after": _statistics(after),
            "mean_after_minus_prescribed_mm": _mean(error),
        },
        "minimum_lumen": {
            "before_mm": before.minimum,
            "before_at_mm": before.minimum_arc_length,
            "after_mm": after.minimum,
            "after_at_mm": after.minimum_arc_length,
            "beyond_before_mm": _beyond(own, stent.around_before),
            "beyond_after_mm": _beyond(own, stent.around_after),
        },
    }


def _along(stent: TreatedStent) -> dict[str, Any]:
    """The curves of the plot: nothing is prescribed beyond the ends of the stent."""
    before, after, own = stent.around_before, stent.around_after, stent.before.arc_length
    prescribed = prescribed_diameters(stent.stent, stent.axis, own)
    return {
        "arc_length_mm": before.arc_length,
        "mis_before_mm": before.inscribed_diameter,
        "mis_after_mm": after.inscribed_diameter,
        "equivalent_before_mm": before.equivalent_diameter,
        "equivalent_after_mm": after.equivalent_diameter,
        "prescribed_mm": np.interp(before.arc_length, own, prescribed, left=np.nan, right=np.nan),
    }


def _beyond(own: Floats, around: DiameterProfile) -> float:
    """The narrowest of the measured vessel before and behind the stent; NaN where there is none."""
    is_beyond = (around.arc_length < own[0]) | (around.arc_length > own[-1])
    return around.taken(is_beyond).minimum


def _statistics(profile: DiameterProfile) -> dict[str, float]:
    return {
        "minimum_mm": profile.minimum,
        "maximum_mm": profile.maximum,
        "mean_mm": profile.mean,
        "sd_mm": profile.sd,
        "equivalent_mean_mm": _mean(profile.equivalent_diameter),
    }


def _mean(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan
