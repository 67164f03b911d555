"""What lies beside a stent: side branches, and wall that it does not touch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ..treatment import TreatedStent
from ..units import MILLIMETERS
from ..vessel import FREE, LISTED, Apposition, NeighborLumen, Ostium
from .facts import LINES, Fact, Facts
from .markup import Cell, heading, paragraph, table
from .words import millimeters, number_text

CONTACT, ALL_ROUND = "Contact with the wall", "all round"
NONE_NEAR = f"No side branch was found within {LISTED:.0f} mm of the stent."


def again_words(number: int | None) -> str:
    """What became of a stent that a later one of the plan is once more."""
    return f"dilated again as stent {number}"


def beside_facts(stent: TreatedStent) -> Iterator[Fact]:
    """What lies beside a stent: of its branches the one that is covered most, and the one that
    lost most; and the wall that it does not touch."""
    names, found = [one.name for one in stent.branches], stent.apposition
    yield Fact(after=math.nan if found is None else found.free_length, column="free_length_mm")
    yield Fact(after="; ".join(names), column="branches")
    covered = _largest(100 * one.covered_share for one in stent.branches)
    yield Fact(after=covered, column="branch_covered_percent")
    lost = _largest(100 * one.loss for one in stent.neighbors if one.is_branch)
    yield Fact(after=lost, column="branch_loss_percent")
    for sentence in [one.sentence() for one in stent.branches] or [NONE_NEAR]:
        yield Fact(words=sentence, level=LINES)
    if found is None:
        words = f"It is {again_words(stent.again)}, and lies in the vessel as that."
        yield Fact(words=words, level=LINES)
    elif found.stretches:
        yield Fact(words=found.sentence(), level=LINES)


def _largest(values: Iterable[float]) -> float:
    """Of those that are known."""
    return float(max(filter(math.isfinite, values), default=math.nan))


def contact_words(found: Apposition | None) -> str:
    """Over which length a stent does not touch the wall all round; "" where it touches."""
    if found is None or not found.stretches:
        return ""
    if found.is_loose:
        return f"none over all of {found.length:.1f} mm"
    return f"not {ALL_ROUND} over {found.free_length:.1f} of {found.length:.1f} mm"


def branch_facts(
    number: int, branch: Ostium, lumen: NeighborLumen | None, units: str = "mm"
) -> Facts:
    """One ostium beside a stent of that number, and the branch's lumen where its wall has moved."""
    before, after = (None, None) if lumen is None else (lumen.before, lumen.after)
    places = (
        Fact(
            f"ostium_{end}_mm",
            name,
            after=place,
            words=millimeters(place, 1, signed=True),
        )
        for end, name, place in (("start", "ostium from", branch.start), ("end", "to", branch.end))
    )
    return Facts(
        (
            Fact("stent", "stent", after=number, words=str(number)),
            Fact("name", "branch", after=branch.name, words=branch.name),
            Fact("ostium_mm", after=branch.center),
            Fact("ostium", after=branch.center / MILLIMETERS[units]),
            Fact("units", after=units),
            *places,
            Fact("percent_covered", after=100 * branch.covered_share),
            Fact("coverage", "ostium", after=branch.coverage, words=branch.coverage),
            Fact("lumen_{}_mm", before=before, after=after),
            Fact("_lumen", "its lumen", words=_lumen_words(before, after)),
        )
    )


def branch_table(branches: Sequence[Facts]) -> list[str]:
    """A part of the page; that no branch is near is said as well."""
    title = heading("Branches")
    if not branches:
        return [title, paragraph(NONE_NEAR)]
    rows = [
        [
            Cell(words, "free" if words == FREE else "covered") if label == "ostium" else words
            for label, words in one.rows()
        ]
        for one in branches
    ]
    head = [label for label, _ in branches[0].rows()]
    note = "From the proximal end of the stent along its axis; negative: proximal of it."
    return [title, table(rows, head, ("", "", "n", "n")), paragraph(note, "small")]


def _lumen_words(before: float | None, after: float | None) -> str:
    """What became of its lumen."""
    if before is None or after is None or math.isnan(before) or math.isnan(after):
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


def stretches_of(document: Mapping[str, Any], number: int) -> list[Mapping[str, Any]]:
    """Those of one of the stents of a report."""
    return [one for one in document["apposition"] if one["stent"] == number]


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
