"""Lesions as a report, a table and the command line tell them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..treatment import Residual, TreatedLesion
from ..units import MILLIMETERS
from ..validation import coordinates
from ..vessel import SMALL_VESSEL, SMALLEST_DEGREE, HealthyPlace, Lesion
from .facts import LINE_LOST, residual_fact, stenosis_fact
from .markup import heading, paragraph, table
from .words import UNKNOWN, degree_text, degrees_text, millimeters, point_words

LEAST = f"{100 * SMALLEST_DEGREE:.0f} % or more"
NO_LESION = f"No lesion of {LEAST} was found."
COVERS_NONE = f"This stent covers no lesion of {LEAST}."
LEFT_BEYOND = " What is left is narrowest beyond the stent's ends."
NOT_LOOKED_FOR = "Lesions were not looked for: that takes a centerline of the vessel."

Section = Mapping[str, Any]


def lesion_section(number: int, lesion: Lesion, units: str = "mm") -> dict[str, Any]:
    """One lesion as a report has it; branches count from 1, coordinates are in mm and as filed."""
    return {
        "number": number,
        "branch": lesion.branch + 1,
        "branch_name": lesion.branch_name,
        "along_branch_mm": lesion.branch_arc_length,
        "arc_length_mm": lesion.arc_length,
        "vessel": lesion.vessel + 1,
        "generation": lesion.generation,
        "place_mm": lesion.point,
        "place": _filed(lesion.point, units),
        "units": units,
        "extent": {
            "start_mm": lesion.start,
            "end_mm": lesion.end,
            "length_mm": lesion.length,
        },
        "path_mm": lesion.line.points,
        **_degrees(lesion),
        "reference": {
            "words": lesion.reference,
            "diameter_mm": lesion.reference_diameter,
            "area_mm2": lesion.reference_area,
            "proximal": _healthy_section(lesion.proximal),
            "distal": _healthy_section(lesion.distal),
        },
    }


def treated_lesion_section(treated: TreatedLesion, units: str = "mm") -> dict[str, Any]:
    """The same with what is left of it after treatment, and the stents that cover it."""
    return {
        **lesion_section(treated.number, treated.before, units),
        "after": _degrees(treated.after),
        "stents": treated.stents,
        "is_left_beyond": treated.is_left_beyond,
    }


def residual_section(residual: Residual | None) -> dict[str, Any] | None:
    """What is narrowest in the treated vessels, as a report has it."""
    if residual is None:
        return None
    return {
        "words": residual_fact(residual).words,
        "percent_diameter": residual.percent,
        "minimum_mm": residual.minimum,
        "reference_mm": residual.reference,
        "place_mm": residual.point,
        "lesion": residual.lesion,
        "side": residual.side,
        "stent": residual.stent,
        "distance_mm": residual.distance,
    }


def lesion_sentences(number: int, lesion: Lesion, units: str = "mm") -> tuple[str, str]:
    """A lesion in two sentences: what it is, and what it is measured against."""
    place = coordinates(_filed(lesion.point, units))
    return (
        f"Lesion {number}: {degrees_text(lesion.percent_diameter, lesion.percent_area)}; "
        f"{lesion.branch_name}, "
        f"{lesion.arc_length:.1f} mm from the proximal end, at {place} {units}; "
        f"{lesion.length:.1f} mm long; minimum {lesion.minimum_diameter:.2f} mm against "
        f"{lesion.reference_diameter:.2f} mm.",
        f"Reference: {lesion.reference}.",
    )


def lesion_list(
    lesions: Sequence[Lesion],
    units: str = "mm",
    smallest: float = SMALL_VESSEL,
    remedy: str = "",
) -> list[str]:
    """The lesions as lines of text, or that there is none; those in small vessels are counted.

    `remedy` says how they are listed.
    """
    lines = []
    large, small = lesions_by_size(lesions, smallest)
    for number in large:
        first, second = lesion_sentences(number, lesions[number - 1], units)
        lines += [first, f"  {second}"]
    if small:
        more = "more " if large else ""
        lines.append(f"{len(small)} {more}in vessels below {smallest:g} mm{remedy}.")
    return lines or [NO_LESION]


def lesions_by_size(lesions: Sequence[Lesion], smallest: float) -> tuple[list[int], list[int]]:
    """The numbers of the lesions in vessels of at least some diameter, mm, and of the others."""
    numbers: tuple[list[int], list[int]] = ([], [])
    for number, lesion in enumerate(lesions, start=1):
        numbers[lesion.reference_diameter < smallest].append(number)
    return numbers


def stent_lesion_sentences(lesions: Sequence[TreatedLesion] | None, stent: int) -> list[str]:
    """What a stent did to the lesions that it covers, or that it covers none."""
    if lesions is None:
        return [NOT_LOOKED_FOR]
    covered = [one for one in lesions if stent in one.stents]
    if not covered:
        return [COVERS_NONE]
    return [
        f"{stenosis_fact(one.number, one.before.percent_diameter)} -> "
        f"{degree_text(one.after.percent_diameter)}, by area "
        f"{degree_text(one.before.percent_area)} -> {degree_text(one.after.percent_area)}, "
        f"against {one.before.reference}."
        f"{left_note(one.after.percent_diameter, one.is_left_beyond)}"
        for one in covered
    ]


def left_note(percent: float | None, is_left_beyond: bool) -> str:
    """What else there is to say of what is left of a covered lesion, after a full stop."""
    if percent is None or math.isnan(percent):
        return f" What is left of it is {UNKNOWN}: {LINE_LOST}."
    return LEFT_BEYOND if is_left_beyond else ""


def degree_change(treated: TreatedLesion) -> str:
    """A lesion's stenosis by diameter, before and after, in few words."""
    before, after = treated.before.percent_diameter, treated.after.percent_diameter
    return f"lesion {treated.number} {degree_text(before)} -> {degree_text(after)}"


def stent_lesions(document: Section, stent: Section) -> list[Section] | None:
    """The lesions that a stent covers; None when none were looked for."""
    if stent["lesions"] is None or document["lesions"] is None:
        return None
    return [one for one in document["lesions"] if one["number"] in stent["lesions"]]


def lesion_rows(lesions: Sequence[Section]) -> list[tuple[str, str, str]]:
    """Name, before and after of the degrees of lesions."""
    return [
        (before.label, before.words, degree_text(one["after"][f"percent_{kind}"]))
        for one in lesions
        for kind in ("diameter", "area")
        for before in [stenosis_fact(one["number"], one[f"percent_{kind}"], kind)]
    ]


def covered_words(lesions: Sequence[Section] | None) -> str:
    """What a stent's lesions are measured against, or why there is no percentage."""
    if lesions is None:
        return NOT_LOOKED_FOR
    if not lesions:
        return COVERS_NONE
    return " ".join(
        f"Lesion {one['number']} against {one['reference']['words']}."
        f"{left_note(one['after']['percent_diameter'], one['is_left_beyond'])}"
        for one in lesions
    )


def lesion_table(lesions: Sequence[Section] | None) -> list[str]:
    """All lesions of the vessel, with what is left of each."""
    if lesions is None:
        return []
    title = heading("Lesions of the vessel")
    if not lesions:
        return [title, paragraph(NO_LESION)]
    columns = {
        "lesion": "",
        "narrowest at (x, y, z)": "place",
        **dict.fromkeys(
            ("length", "minimum diameter", "reference diameter", "diameter stenosis before"), "n"
        ),
        "after": "n degree",
        "stent": "",
    }
    rows = [
        (
            str(one["number"]),
            f"{one['branch_name']}, {millimeters(one['along_branch_mm'], 1)} along it; "
            f"{point_words(one['place_mm'], one['units'])}",
            millimeters(one["extent"]["length_mm"], 1),
            millimeters(one["minimum"]["diameter_mm"]),
            millimeters(one["reference"]["diameter_mm"]),
            degree_text(one["percent_diameter"]),
            degree_text(one["after"]["percent_diameter"]),
            ", ".join(map(str, one["stents"])) or "none",
        )
        for one in lesions
    ]
    return [title, table(rows, [*columns], [*columns.values()])]


def lesions_csv(lesions: Sequence[Lesion], units: str = "mm") -> str:
    """The lesions as a table with one row each; an empty cell where a number is not known."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for number, lesion in enumerate(lesions, start=1):
        writer.writerow([_cell(value(number, lesion, units)) for value in COLUMNS.values()])
    return text.getvalue()


def _side(place: HealthyPlace | None) -> float:
    return place.diameter if place else math.nan


COLUMNS: dict[str, Callable[[int, Lesion, str], Any]] = {
    "lesion": lambda number, one, units: number,
    "branch": lambda number, one, units: one.branch + 1,
    "branch_name": lambda number, one, units: one.branch_name,
    "along_branch_mm": lambda number, one, units: one.branch_arc_length,
    "x": lambda number, one, units: _filed(one.point, units)[0],
    "y": lambda number, one, units: _filed(one.point, units)[1],
    "z": lambda number, one, units: _filed(one.point, units)[2],
    "units": lambda number, one, units: units,
    "length_mm": lambda number, one, units: one.length,
    "minimum_diameter_mm": lambda number, one, units: one.minimum_diameter,
    "reference_diameter_mm": lambda number, one, units: one.reference_diameter,
    "percent_diameter": lambda number, one, units: one.percent_diameter,
    "minimum_area_mm2": lambda number, one, units: one.minimum_area,
    "reference_area_mm2": lambda number, one, units: one.reference_area,
    "percent_area": lambda number, one, units: one.percent_area,
    "proximal_diameter_mm": lambda number, one, units: _side(one.proximal),
    "distal_diameter_mm": lambda number, one, units: _side(one.distal),
    "reference": lambda number, one, units: one.reference,
}
"""Of the table of lesions; x, y, z are in the unit and frame of the surface's file."""


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f"{value:.6g}" if math.isfinite(value) else ""


def _degrees(lesion: Lesion) -> Mapping[str, Any]:
    return {
        "minimum": {
            "diameter_mm": lesion.minimum_diameter,
            "area_mm2": lesion.minimum_area,
        },
        "percent_diameter": lesion.percent_diameter,
        "percent_area": lesion.percent_area,
    }


def _healthy_section(place: HealthyPlace | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {
        "place_mm": place.point,
        "arc_length_mm": place.arc_length,
        "diameter_mm": place.diameter,
        "area_mm2": place.area,
    }


def _filed(point: Sequence[float], units: str) -> tuple[float, ...]:
    return tuple(value / MILLIMETERS[units] for value in point)
