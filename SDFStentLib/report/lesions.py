"""Facts on lesions, before and after treatment."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..treatment import Residual, TreatedLesion
from ..units import MILLIMETERS
from ..validation import coordinates
from ..vessel import SMALL_VESSEL, SMALLEST_DEGREE, HealthyPlace, Lesion
from .facts import LINES, Fact, Facts, size
from .markup import facts_table, heading, paragraph
from .words import UNKNOWN, degree_text, degree_word, degrees_text, millimeters, point_words

SHOWN = 5
"""Number of lesions that are listed where there are many."""

LEAST = f"{100 * SMALLEST_DEGREE:.0f} % or more"
NO_LESION = f"No lesion of {LEAST} was found."
COVERS_NONE = f"This stent covers no lesion of {LEAST}."
LEFT_BEYOND = " What is left is narrowest beyond the stent's ends."
NOT_LOOKED_FOR = "Lesions were not looked for: that takes a centerline of the vessel."
LEFT = "Left in the treated vessel"
LINE_LOST = "the wall was moved past the line along which it is measured"

COLUMNS = (
    *("lesion", "branch", "branch_name", "along_branch_mm", "x", "y", "z", "units", "length_mm"),
    *("minimum_diameter_mm", "reference_diameter_mm", "percent_diameter", "minimum_area_mm2"),
    *("reference_area_mm2", "percent_area", "proximal_diameter_mm", "distal_diameter_mm"),
    "reference",
)
"""Columns of the table of lesions; x, y, z are in the unit and frame of the surface's file."""


def lesion_facts(number: int, lesion: Lesion, units: str = "mm") -> Facts:
    """Facts on a lesion; branches count from 1, places are in mm and as filed."""
    return Facts(_facts(number, lesion, units))


def treated_lesion_facts(treated: TreatedLesion, units: str = "mm") -> Facts:
    """Facts on a lesion before and after treatment, and on the stents that cover it."""
    before, after, stents = treated.before, treated.after, treated.stents
    degree = degree_text(after.percent_diameter)
    against = f"Lesion {treated.number} against {before.reference}.{_left_note(treated)}"
    return Facts(
        (
            *_facts(treated.number, before, units, after),
            Fact("after.minimum.diameter_mm", after=after.minimum_diameter),
            Fact("after.minimum.area_mm2", after=after.minimum_area),
            Fact("after.percent_diameter", "after", after=after.percent_diameter, words=degree),
            Fact("after.percent_area", after=after.percent_area),
            Fact("after.limbs", after=[_limb(one) for one in after.limbs]),
            Fact("stents", "stent", after=stents, words=", ".join(map(str, stents)) or "none"),
            Fact("is_left_beyond", after=treated.is_left_beyond),
            degree_fact(treated),
            degree_fact(treated, "area"),
            Fact("_against", words=against),
            Fact("_left", words=_left_words(treated)),
        )
    )


def _left_words(treated: TreatedLesion) -> str:
    """Words for a lesion's residual stenosis, beside that of other plans."""
    after, covered = treated.after, "" if treated.stents else "; not stented"
    degrees = degrees_text(after.percent_diameter, after.percent_area)
    return f"{degrees}{covered}.{_left_note(treated)}"


def _facts(number: int, one: Lesion, units: str, after: Lesion | None = None) -> Iterator[Fact]:
    place, branch = np.array(one.point), one.branch + 1
    along = f"{one.branch_name}, {millimeters(one.branch_arc_length, 1)} along it"
    where = f"{along}; {point_words(one.point, units)}"
    yield Fact("number", "lesion", after=number, words=str(number), column="lesion")
    yield Fact("branch", after=branch, column="branch")
    yield Fact("branch_name", after=one.branch_name, column="branch_name")
    yield Fact("along_branch_mm", after=one.branch_arc_length, column="along_branch_mm")
    yield Fact("arc_length_mm", after=one.arc_length)
    yield Fact("vessel", after=one.vessel + 1)
    yield Fact("generation", after=one.generation)
    yield Fact("place_mm", "narrowest at (x, y, z)", after=place, words=where)
    yield Fact("place", after=place / MILLIMETERS[units], column="{}")
    yield Fact("units", after=units, column="units")
    yield Fact("extent.start_mm", after=one.start)
    yield Fact("extent.end_mm", after=one.end)
    few = f"{one.length:.0f} mm"
    yield size("extent.length_mm", "length", one.length, 1, column="length_mm", few=few)
    yield Fact("path_mm", after=one.line.points)
    minimum, reference = one.minimum_diameter, one.reference_diameter
    column = "minimum_diameter_mm"
    yield size("minimum.diameter_mm", "minimum diameter", minimum, column=column)
    column = "reference_diameter_mm"
    yield size("reference.diameter_mm", "reference diameter", reference, column=column)
    yield Fact(
        "percent_diameter",
        "diameter stenosis before",
        after=one.percent_diameter,
        words=degree_text(one.percent_diameter),
        column="percent_diameter",
        few=degree_word(one.percent_diameter),
    )
    yield Fact("minimum.area_mm2", after=one.minimum_area, column="minimum_area_mm2")
    yield Fact("reference.area_mm2", after=one.reference_area, column="reference_area_mm2")
    yield Fact("percent_area", after=one.percent_area, column="percent_area")
    for name, side in (("proximal", one.proximal), ("distal", one.distal)):
        yield Fact(f"reference.{name}", after=_healthy(side))
        width = side.diameter if side else math.nan
        yield Fact(after=width, column=f"{name}_diameter_mm")
    yield Fact("reference.words", after=one.reference, column="reference")
    limbs = ", ".join(degree_word(limb.percent_diameter) for limb in one.limbs)
    beside = f"; other vessels in its throat: {limbs}" if limbs else ""
    words = (
        f"Lesion {number}: {degrees_text(one.percent_diameter, one.percent_area)}; "
        f"{one.branch_name}, {one.arc_length:.1f} mm from the proximal end, at "
        f"{coordinates(place / MILLIMETERS[units])} {units}; {one.length:.1f} mm long; minimum "
        f"{minimum:.2f} mm against {reference:.2f} mm{beside}."
    )
    yield Fact("_whole", words=words, level=LINES)
    yield Fact("_reference", words=f"Reference: {one.reference}.", level=LINES)
    yield Fact("limbs", after=[_limb(limb) for limb in one.limbs])
    yield Fact("_limbs", words=_limb_words(one, after), level=LINES)


def _limb(limb: Lesion) -> dict[str, Any]:
    """A narrowing of another vessel in the same throat, for a document."""
    return {
        "branch": limb.branch + 1,
        "branch_name": limb.branch_name,
        "place_mm": limb.point,
        "minimum_mm": limb.minimum_diameter,
        "reference_mm": limb.reference_diameter,
        "percent_diameter": limb.percent_diameter,
    }


def _limb_words(one: Lesion, after: Lesion | None = None) -> str:
    """A sentence on each limb of a lesion, before and after treatment."""
    return " ".join(
        f"In its throat, {was.branch_name}: "
        f"{' -> '.join(dict.fromkeys((_limb_degree(was), _limb_degree(left))))}."
        for was, left in zip(one.limbs, (after or one).limbs, strict=True)
    )


def _limb_degree(limb: Lesion) -> str:
    if math.isnan(limb.percent_diameter):
        return UNKNOWN
    sizes = f"{limb.minimum_diameter:.2f} of {millimeters(limb.reference_diameter)}"
    return degree_text(limb.percent_diameter, sizes)


def _healthy(place: HealthyPlace | None) -> dict[str, Any] | None:
    if place is None:
        return None
    return {
        "place_mm": place.point,
        "arc_length_mm": place.arc_length,
        "diameter_mm": place.diameter,
        "area_mm2": place.area,
    }


def residual_facts(residual: Residual) -> Facts:
    """Facts on the residual stenosis of the treated vessels, and its place."""
    sizes = f"{residual.minimum:.2f} of {residual.reference:.2f} mm"
    words = f"{degree_text(residual.percent, sizes)}, {residual.place()}"
    if math.isnan(residual.percent):
        words = f"{UNKNOWN}, as in lesion {residual.lesion}, {residual.place()}: {LINE_LOST}"
    return Facts(
        (
            Fact("words", LEFT, after=words, words=words),
            Fact("percent_diameter", after=residual.percent),
            Fact("minimum_mm", after=residual.minimum),
            Fact("reference_mm", after=residual.reference),
            Fact("place_mm", after=residual.point),
            Fact("lesion", after=residual.lesion),
            Fact("side", after=residual.side),
            Fact("stent", after=residual.stent),
            Fact("distance_mm", after=residual.distance),
        )
    )


def degree_fact(treated: TreatedLesion, kind: str = "diameter") -> Fact:
    """Fact on a lesion's stenosis in percent, by `diameter` or by `area`."""
    was, left = (getattr(one, f"percent_{kind}") for one in (treated.before, treated.after))
    label = f"Lesion {treated.number}, {kind} stenosis"
    return Fact("", label, was, left, "", degree_text(left), degree_text(was))


def lesion_lines(
    lesions: Sequence[Lesion],
    units: str = "mm",
    smallest: float = SMALL_VESSEL,
    remedies: tuple[str, str] = ("", ""),
    most: int | None = None,
) -> list[str]:
    """Lines on lesions for the shell, or that there is none; those in small vessels are counted.

    Where that takes `most` lines or more, only what the first ones are. `remedies` say how small
    ones are listed, and how all.
    """
    large, small = lesions_by_size(lesions, smallest)
    below = f"in vessels below {smallest:g} mm"
    # Sections are cut for every sentence, so only those that are told are made.
    if most is not None and 2 * len(large) + bool(small) >= most:
        told = [lesion_facts(one, lesions[one - 1], units).sentences[0] for one in large[:SHOWN]]
        count = len(large[SHOWN:]) + len(small)
        of_them = f", {len(small)} of them {below}" if small else ""
        more = f"{count} more{of_them}: " if count else ""
        return [*told, more + remedies[1]]
    lines = []
    for number in large:
        first, *others = lesion_facts(number, lesions[number - 1], units).sentences
        lines += [first, *(f"  {other}" for other in others)]
    if small:
        more = "more " if large else ""
        lines.append(f"{len(small)} {more}{below}{remedies[0]}.")
    return lines or [NO_LESION]


def lesions_by_size(lesions: Sequence[Lesion], smallest: float) -> tuple[list[int], list[int]]:
    """The numbers of the lesions in vessels of at least some diameter, mm, and of the others."""
    numbers: tuple[list[int], list[int]] = ([], [])
    for number, lesion in enumerate(lesions, start=1):
        numbers[lesion.reference_diameter < smallest].append(number)
    return numbers


def stent_lesion_sentences(lesions: Sequence[TreatedLesion] | None, stent: int) -> list[str]:
    """Sentences on the lesions that a stent covers, or that it covers none."""
    if lesions is None:
        return [NOT_LOOKED_FOR]
    covered = [one for one in lesions if stent in one.stents]
    if not covered:
        return [COVERS_NONE]
    return [
        f"{degree_fact(one)}, by area {degree_fact(one, 'area').change}, against "
        f"{one.before.reference}.{_left_note(one)}"
        for one in covered
    ]


def _left_note(treated: TreatedLesion) -> str:
    """Further sentence on the rest of a covered lesion, after a full stop; empty without one."""
    if math.isnan(treated.after.percent_diameter):
        return f" What is left of it is {UNKNOWN}: {LINE_LOST}."
    beyond = LEFT_BEYOND if treated.is_left_beyond and treated.stents else ""
    limbs = _limb_words(treated.before, treated.after) if treated.stents else ""
    return f"{beyond} {limbs}".rstrip()


def degree_change(treated: TreatedLesion) -> str:
    """A lesion's stenosis by diameter, before and after, in few words."""
    return f"lesion {treated.number} {degree_fact(treated).change}"


def stent_lesions(lesions: Sequence[Facts] | None, stent: Mapping[str, Any]) -> list[Facts] | None:
    """The lesions that a stent of a document covers; None when none were looked for."""
    if lesions is None or stent["lesions"] is None:
        return None
    return [one for one in lesions if one.named("number").after in stent["lesions"]]


def covered_words(lesions: Sequence[Facts] | None) -> str:
    """Words for the reference of a stent's lesions, or why there is no percentage."""
    if lesions is None:
        return NOT_LOOKED_FOR
    return " ".join(one.named("_against").words for one in lesions) or COVERS_NONE


def lesion_table(lesions: Sequence[Facts] | None, *, whole_tree: bool = True) -> list[str]:
    """Table of the lesions of a report, with the residual stenosis of each, and whether those of
    other vessels may be missing."""
    if lesions is None:
        return []
    title = heading("Lesions of the vessel")
    if not lesions:
        return [title, paragraph(NO_LESION)]
    numbers = ("length", "minimum diameter", "reference diameter", "diameter stenosis before")
    looks = {"narrowest at (x, y, z)": "place", "after": "n degree", **dict.fromkeys(numbers, "n")}
    limbs = [(one.named("number").words, one.named("_limbs").words) for one in lesions]
    said = [paragraph(f"Lesion {number}: {words}", "small") for number, words in limbs if words]
    if not whole_tree:
        said.append(paragraph("Lesions of other vessels, if any, are not listed.", "small"))
    return [title, facts_table(lesions, looks), *said]


def lesions_csv(lesions: Sequence[Lesion], units: str = "mm") -> str:
    """The lesions as a table with one row each; an empty cell where a number is not known."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for number, lesion in enumerate(lesions, start=1):
        row = lesion_facts(number, lesion, units).columns()
        writer.writerow({name: _cell(value) for name, value in row.items()})
    return text.getvalue()


def _cell(value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return f"{value:.6g}" if math.isfinite(value) else ""
