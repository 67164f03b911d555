"""What lies beside a stent: side branches, and wall that it does not touch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..treatment import TreatedStent
from ..units import MILLIMETERS
from ..vessel import FREE, LISTED, Apposition, NeighborLumen, Ostium
from .facts import coverage_fact
from .markup import Cell, heading, paragraph, table
from .words import millimeters, number_text

NONE_NEAR = f"No side branch was found within {LISTED:.0f} mm of the stent."


def stent_branch_sentences(stent: TreatedStent) -> list[str]:
    """What a stent does to every branch near it, and where it touches no wall."""
    branches = [branch.sentence() for branch in stent.branches] or [NONE_NEAR]
    if stent.apposition is None:
        return [*branches, f"It is {again_words(stent.again)}, and lies in the vessel as that."]
    free = stent.apposition.sentence()
    return [*branches, free] if free else branches


def again_words(number: int | None) -> str:
    """What became of a stent that a later one of the plan is once more."""
    return f"dilated again as stent {number}"


def branch_section(
    branch: Ostium, lumen: NeighborLumen | None, units: str = "mm"
) -> dict[str, Any]:
    """One ostium as a report has it, and the branch's lumen where its wall has moved."""
    covered = coverage_fact(branch)
    return {
        "name": branch.name,
        "ostium_mm": branch.center,
        "ostium": branch.center / MILLIMETERS[units],
        "units": units,
        "ostium_start_mm": branch.start,
        "ostium_end_mm": branch.end,
        "percent_covered": covered.value,
        "coverage": covered.words,
        "lumen_before_mm": None if lumen is None else lumen.before,
        "lumen_after_mm": None if lumen is None else lumen.after,
    }


def branch_table(branches: Sequence[Mapping[str, Any]]) -> list[str]:
    """A part of the page; that no branch is near is said as well."""
    title = heading("Branches")
    if not branches:
        return [title, paragraph(NONE_NEAR)]
    rows = [
        (
            str(one["stent"]),
            one["name"],
            *(millimeters(one[f"ostium_{end}_mm"], 1, signed=True) for end in ("start", "end")),
            Cell(one["coverage"], "free" if one["coverage"] == FREE else "covered"),
            branch_lumen_words(one),
        )
        for one in branches
    ]
    head = ("stent", "branch", "ostium from", "to", "ostium", "its lumen")
    note = "From the proximal end of the stent along its axis; negative: proximal of it."
    return [title, table(rows, head, ("", "", "n", "n")), paragraph(note, "small")]


def branch_lumen_words(branch: Mapping[str, Any]) -> str:
    """What became of its lumen."""
    before, after = branch["lumen_before_mm"], branch["lumen_after_mm"]
    if before is None or after is None:
        return "unchanged or not followed"
    return f"{millimeters(before)} before, {millimeters(after)} after"


def free_stretches(found: Apposition | None) -> Iterator[dict[str, float]]:
    """The stretches without contact; a gap over an open end is not known."""
    for stretch in () if found is None else found.stretches:
        yield {
            "start_mm": stretch.start,
            "end_mm": stretch.end,
            "percent_free": 100 * stretch.share,
            "largest_gap_mm": stretch.largest_gap,
        }


def stretches_of(document: Mapping[str, Any], stent: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Those of one of the stents of a report document."""
    return [one for one in document["apposition"] if one["stent"] == stent["number"]]


def stretch_sentence(one: Mapping[str, Any]) -> str:
    """Where a stretch is, from the proximal end of the stent, and how much of it is free."""
    return (
        f"{number_text(one['start_mm'], 1)} to {millimeters(one['end_mm'], 1)}: "
        f"{one['percent_free']:.0f} % of the circumference is free"
    )


def apposition_table(stretches: Sequence[Mapping[str, Any]]) -> list[str]:
    """A part of the page; nothing where the stent touches all along."""
    if not stretches:
        return []
    rows = [
        (
            str(one["stent"]),
            *(millimeters(one[f"{end}_mm"], 1) for end in ("start", "end")),
            f"{one['percent_free']:.0f} %",
        )
        for one in stretches
    ]
    note = (
        "From the proximal end of the stent. Across the ostium of a branch there is no wall to "
        "touch."
    )
    return [
        heading("Not in contact all round"),
        table(rows, ("stent", "from", "to", "of the circumference is free"), ("", *"nnn")),
        paragraph(note, "small"),
    ]
