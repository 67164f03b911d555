"""Branches beside a stent, and wall that it does not touch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ..treatment import BranchBeside, TreatedStent, branches_beside
from ..units import MILLIMETERS
from ..vessel import FREE, LISTED, Apposition, NeighborLumen, Ostium
from .facts import GLANCE, LINES, Fact, Facts, listed, size
from .markup import Cell, facts_table, heading, paragraph, table
from .words import UNKNOWN, millimeters, number_text

BRANCHES = "Branches"
CONTACT, ALL_ROUND = "Contact with the wall", "all round"
FREE_PART = "of the circumference is free"
NONE_NEAR = f"No side branch was found within {LISTED:.0f} mm of the stent."


def again_words(number: int | None) -> str:
    """Words for a stent that a later one of the plan is once more."""
    return f"dilated again as stent {number}"


def again_as(stent: TreatedStent) -> str:
    """Words for such a treated stent, by the rows of who reads of it; "" for another one."""
    if stent.again is None:
        return ""
    return "dilated again at once" if stent.again_row == stent.row else again_words(stent.again_row)


def beside_facts(stent: TreatedStent) -> Iterator[Fact]:
    """Facts on the branches beside a stent, of which a table has the one that is covered most and
    the one that lost most, and on the wall that the stent does not touch."""
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
        words = f"It is {again_as(stent)}, and lies in the vessel as that."
        yield Fact(words=words, level=LINES)
    elif found.stretches:
        yield Fact(words=found.sentence(), level=LINES)


def _largest(values: Iterable[float]) -> float:
    """Largest known value."""
    return float(max(filter(math.isfinite, values), default=math.nan))


def contact_words(found: Apposition | None) -> str:
    """The length over which a stent does not touch the wall all round; "" where it touches."""
    if found is None or not found.stretches:
        return ""
    if found.is_loose:
        return f"none over all of {found.length:.1f} mm"
    return f"not {ALL_ROUND} over {found.free_length:.1f} of {found.length:.1f} mm"


def branch_facts(
    number: int, branch: Ostium, lumen: NeighborLumen | None, units: str = "mm"
) -> Facts:
    """Facts on an ostium beside a stent, and on the branch's lumen where its wall has moved."""
    before, after = (None, None) if lumen is None else (lumen.before, lumen.after)
    start, end = (millimeters(one, 1, signed=True) for one in (branch.start, branch.end))
    return Facts(
        (
            Fact("stent", "stent", after=number, words=str(number)),
            Fact("name", "branch", after=branch.name, words=branch.name),
            Fact("ostium_mm", after=branch.center),
            Fact("ostium", after=branch.center / MILLIMETERS[units]),
            Fact("units", after=units),
            Fact("ostium_start_mm", "ostium from", after=branch.start, words=start),
            Fact("ostium_end_mm", "to", after=branch.end, words=end),
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
    """Words for a branch's lumen before and after treatment."""
    if before is None or after is None or math.isnan(before) or math.isnan(after):
        return "unchanged or not followed"
    return f"{millimeters(before)} before, {millimeters(after)} after"


def stretch_facts(stent: TreatedStent) -> Iterator[Facts]:
    """The stretches of a stent without contact; a gap over an open end is not known."""
    for one in () if stent.apposition is None else stent.apposition.stretches:
        free = f"{100 * one.share:.0f} %"
        where = f"{number_text(one.start, 1)} to {millimeters(one.end, 1)}"
        yield Facts(
            (
                Fact("stent", "stent", after=stent.number, words=str(stent.number)),
                size("start_mm", "from", one.start, 1),
                size("end_mm", "to", one.end, 1),
                Fact("percent_free", FREE_PART, after=100 * one.share, words=free),
                Fact("largest_gap_mm", after=one.largest_gap),
                Fact("_whole", words=f"{where}: {free} {FREE_PART}"),
            )
        )


def apposition_table(stretches: Sequence[Facts]) -> list[str]:
    """A part of the page; nothing where the stent touches all along."""
    if not stretches:
        return []
    note = (
        "From the proximal end of the stent. Across the ostium of a branch there is no wall to "
        "touch."
    )
    looks = dict.fromkeys(("from", "to", FREE_PART), "n")
    title = heading("Not in contact all round")
    return [title, facts_table(stretches, looks), paragraph(note, "small")]


def branches_fact(stents: Sequence[TreatedStent]) -> Fact:
    """Fact on the side branches that are covered or narrowed, and their numbers."""
    every, several = branches_beside(stents), len(stents) > 1
    covered = [one for one in every if not one.ostium.is_free]
    narrowed = sum(one.lumen is not None and one.lumen.is_narrowed for one in every)
    counts = {"covered": len(covered), "narrowed": narrowed}
    changed = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return Fact(
        "branches",
        after=len(covered),
        words=_branch_sentence(stents, every, several),
        level=GLANCE,
        few=f"{len(covered)} of {len(every)} covered" if every else "none near",
        hand=changed and f"branches: {changed}",
        tile=BRANCHES,
        beneath=f"{narrowed or 'none'} narrowed" if every else "",
    )


def _branch_sentence(
    stents: Sequence[TreatedStent], every: Sequence[BranchBeside], several: bool
) -> str:
    lumens = [(_called(one, several), one.lumen) for one in every if one.lumen is not None]
    lumens += [(near.name, near) for one in stents for near in one.neighbors if not near.is_branch]
    covered = [
        _called(one, several, one.ostium.coverage.removesuffix(" covered"))
        for one in every
        if not one.ostium.is_free
    ]
    narrowed = [
        f"{name} {near.before:.2f} -> {near.after:.2f} mm"
        for name, near in lumens
        if near.is_narrowed
    ]
    lost = [name for name, near in lumens if math.isnan(near.after) and not math.isnan(near.before)]
    if not every and not narrowed and not lost:
        return NONE_NEAR
    words = [*_kind("covered", covered), *_kind("narrowed", narrowed)]
    words += _kind(f"with a lumen that is {UNKNOWN}", lost)
    return f"Branches: {'; '.join(words) or f'none of {len(every)} is covered or narrowed'}."


def _called(branch: BranchBeside, of_several: bool, coverage: str = "") -> str:
    """Branch, with the stent from which its place counts where there are several."""
    stent = f"stent {branch.nearest}" if of_several else ""
    said = ", ".join(filter(None, (stent, coverage)))
    return f"{branch.ostium.name} ({said})" if said else branch.ostium.name


def _kind(what: str, names: Sequence[str]) -> Iterable[str]:
    return [f"{len(names)} {what}: {listed(names)}"] if names else []


def contact_fact(stents: Sequence[TreatedStent]) -> Iterator[Fact]:
    """Fact on the length of stents off the wall; none where that was not looked for."""
    found = {one.number: one.apposition for one in stents if one.apposition is not None}
    if not found:
        return
    loose = {number: words for number, one in found.items() if (words := contact_words(one))}
    free, length = (
        sum(getattr(one, name) for one in found.values()) for name in ("free_length", "length")
    )
    yield Fact(
        "contact",
        after=free,
        unit="mm",
        words=f"{CONTACT}: {of_each(loose, len(stents) > 1)}." if loose else "",
        level=GLANCE,
        few=f"{free:.0f} mm off" if free > 0 else ALL_ROUND,
        hand=f"off the wall over {free:.0f} of {length:.0f} mm" if free > 0 else "",
        tile=CONTACT,
        beneath=f"of {length:.0f} mm",
    )


def of_each(words: Mapping[int, str], is_numbered: bool | None = None) -> str:
    """Words for stents by number; for one alone without it."""
    is_numbered = len(words) > 1 if is_numbered is None else is_numbered
    told = [f"stent {one}: {said}" if is_numbered else said for one, said in words.items()]
    return listed(told, "; ")
