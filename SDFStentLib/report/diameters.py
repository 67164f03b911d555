"""Diameters along a line, and what a stent did to them: table, document, sentence and page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import Line
from ..lumen import DiameterProfile
from ..treatment import TreatedStent
from ..units import MILLIMETERS
from ..validation import InputError, Points, read_only
from ..vessel import Apposition, NeighborLumen, Ostium
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
    return "(" + ", ".join(f"{value / MILLIMETERS[units]:.4g}" for value in point) + ")"


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


@dataclass(frozen=True)
class StentResult:
    """What one stent is, and what it did to the lumen.

    `before` and `after` are measured at the same stations, over the stented length; the two
    profiles around it at those and beyond both ends.
    """

    description: Mapping[str, Any]
    """Device, lengths, diameters, axis and profile, with units in the keys (`..._mm`)."""
    before: DiameterProfile
    after: DiameterProfile
    prescribed_diameter: NDArray[np.float64]
    """Per station, mm; one number for all is enough."""
    branches: tuple[Ostium, ...] = ()
    neighbors: tuple[NeighborLumen, ...] = ()
    apposition: Apposition | None = None
    around_before: DiameterProfile | None = None
    around_after: DiameterProfile | None = None
    lesions: tuple[int, ...] | None = None
    """Numbers of the lesions that it covers; None when none were looked for."""

    @property
    def units(self) -> str:
        """Of the surface's file."""
        return str(self.description.get("axis", {}).get("units", "mm"))

    def __post_init__(self) -> None:
        stations = self.before.arc_length.shape
        if self.after.arc_length.shape != stations or not np.allclose(
            self.after.arc_length, self.before.arc_length, rtol=0, atol=1e-6
        ):
            raise InputError(
                "after: expected the stations of the profile before, got "
                f"{len(self.after.arc_length)} others; measure both along the same axis."
            )
        prescribed = np.asarray(self.prescribed_diameter, dtype=np.float64)
        if prescribed.shape not in ((), stations):
            raise InputError(
                f"prescribed_diameter: expected one number or {stations[0]}, "
                f"got shape {prescribed.shape}."
            )
        whole = read_only(np.broadcast_to(prescribed, stations))
        object.__setattr__(self, "prescribed_diameter", whole)


def stent_section(stent: StentResult) -> dict[str, Any]:
    """A stent as a report has it."""
    return {
        **stent.description,
        "lesions": stent.lesions,
        "diameters": _diameter_section(stent),
    }


def _along(stent: StentResult) -> dict[str, Any]:
    """The curves of the plot: nothing is prescribed beyond the ends of the stent."""
    before, after = stent.around_before or stent.before, stent.around_after or stent.after
    at, own = before.arc_length, stent.before.arc_length
    prescribed = np.interp(at, own, stent.prescribed_diameter, left=np.nan, right=np.nan)
    return {
        "arc_length_mm": at,
        "mis_before_mm": before.inscribed_diameter,
        "mis_after_mm": after.inscribed_diameter,
        "equivalent_before_mm": before.equivalent_diameter,
        "equivalent_after_mm": after.equivalent_diameter,
        "prescribed_mm": prescribed,
    }


def _diameter_section(stent: StentResult) -> dict[str, Any]:
    before, after = stent.before, stent.after
    error = after.inscribed_diameter - stent.prescribed_diameter
    return {
        "along": _along(stent),
        "stent_ends_mm": before.arc_length[[0, -1]],
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
            **_beyond(stent),
        },
    }


def _beyond(stent: StentResult) -> dict[str, float]:
    """The narrowest of the measured vessel before and behind the stent; NaN where there is none."""
    ends = stent.before.arc_length[[0, -1]]
    found = {}
    for name, around in (("before", stent.around_before), ("after", stent.around_after)):
        least = math.nan
        if around is not None:
            is_beyond = (around.arc_length < ends[0]) | (around.arc_length > ends[1])
            values = around.inscribed_diameter[is_beyond]
            known = values[np.isfinite(values)]
            least = float(known.min()) if len(known) else math.nan
        found[f"beyond_{name}_mm"] = least
    return found


def _statistics(profile: DiameterProfile) -> dict[str, float]:
    return {
        "minimum_mm": profile.minimum,
        "maximum_mm": profile.maximum,
        "mean_mm": profile.mean,
        "sd_mm": profile.sd,
        "equivalent_mean_mm": _mean(profile.equivalent_diameter),
    }


def _mean(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan
