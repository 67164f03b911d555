"""Facts on a whole deployment, and its few lines, as a cardiologist reads them; the report has the
rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..cautions import Caution, by_gravity
from ..certificate import (
    CERTIFIED,
    CERTIFIED_IN_PIECES,
    CERTIFIED_OPEN,
    NOT_CERTIFIED,
    NOT_READY,
    Certificate,
)
from ..plan import PlanResult, Today
from ..scan import Ranged, Span
from ..treatment import TreatedLesion, TreatedStent, label_of, nearest_lesion, residual_of
from .branches import branches_fact, contact_fact, of_each
from .facts import GLANCE, LINES, Fact, Facts, listed
from .flow import flow_line, flow_section, flow_sentences
from .lesions import (
    COVERS_NONE,
    NOT_LOOKED_FOR,
    degree_change,
    residual_facts,
    stent_lesion_sentences,
)
from .stents import stent_facts
from .words import UNKNOWN, degree_word, number_text

UNCOVERED = "no lesion covered"
WARNING = "warning: "
"""Beginning of a line with a warning: whoever colors lines goes by that."""

WARNINGS = "Warnings"
STENOSIS, SURFACE = "Stenosis left", "Surface"
"""Names on tiles."""

_OF_SURFACE = {
    CERTIFIED: (CERTIFIED, ""),
    CERTIFIED_OPEN: (CERTIFIED, "once its openings are closed"),
    CERTIFIED_IN_PIECES: (CERTIFIED, "once its points are merged"),
    NOT_READY: ("not ready for a mesher", "no worse than before"),
    NOT_CERTIFIED: (NOT_CERTIFIED, ""),
}
"""Value of the surface's tile, and what stands beneath, by the word of the certificate."""

_SHORT = {
    "hangs-free": "hangs free over {free_mm:.0f} of {length_mm:.0f} mm",
    "lesion-uncovered": "lesion {lesion} uncovered over {uncovered_mm:.1f} mm",
    "overdilated": "overdilated {times:.1f} x",
    "shortened": "shortened to {available_mm:.1f} mm",
    "narrower": "{percent:.0f} % narrower than prescribed",
    "narrowed": "narrowed to {minimum_mm:.1f} mm by later stents",
    "neighbor-narrowed": "{name} narrowed {before_mm:.1f} -> {after_mm:.1f} mm",
    "overlap": "overlap of {length_mm:.1f} mm",
    "ratio-stenosis": "balloon {ratio:.1f} x as wide as the stenosis",
}
"""Short words for a warning in a line; others are called by their kind."""


class Summary(NamedTuple):
    """The first lines about a deployment, without its warnings."""

    deployed: str
    results: list[str]
    """Lines, at most five, the certificate's last; one more where a stent is dilated again."""


def deployment_summary(result: PlanResult) -> Summary:
    """Summary of the stents and their results: lumen, stenosis, branches and contact."""
    stents = result.told.stents
    facts = {one.number: stent_facts(one, result.told_lesions) for one in stents}
    stenosis, *beside = (one.words for one in outcome_facts(stents, result.told_lesions))
    # In one line where pressures, which were asked for, need the other.
    flow = [] if result.flow is None else [flow_line(flow_section(result.flow))]
    lines = [
        *(today_facts(result.today).sentences if result.today else ()),
        *_at_a_glance([facts[one.number] for one in _final(stents)], len(stents) > 1),
        stenosis,
        *([" ".join(filter(None, beside))] if flow else beside),
        *flow,
        surface_fact(result.treatment.certificate, result.inputs.surface.units).words,
    ]
    deployed = {number: one.named("_deployed").words for number, one in facts.items()}
    return Summary(f"Deployed: {of_each(deployed)}.", [*filter(None, lines)])


def deployment_sentences(result: PlanResult) -> Iterator[str]:
    """Sentences on every stent and on the whole, as the report has them."""
    yield from today_facts(result.today).sentences if result.today else ()
    for stent in result.told.stents:
        label = label_of(result.plan.stents, stent.number)
        yield from (label + line for line in stent_lines(stent, result.told_lesions))
    if result.flow is not None:
        yield from flow_sentences(flow_section(result.flow))
    certificate = surface_fact(result.treatment.certificate, result.inputs.surface.units)
    yield from filter(None, [certificate.words])


def stent_lines(stent: TreatedStent, lesions: Sequence[TreatedLesion] | None) -> list[str]:
    """Lines on a stent, one per quantity: for shell and panel."""
    told = [
        f"{one}." if one.label else str(one)
        for one in stent_facts(stent, lesions).at(LINES)
        if not one.label or ((one.was or one.level == GLANCE) and one.is_known)
    ]
    return [*told, *stent_lesion_sentences(lesions, stent.number)]


def _at_a_glance(stents: Sequence[Facts], are_several: bool) -> Iterator[str]:
    """Lines on all stents, one per fact at a glance."""
    for label in dict.fromkeys(fact.label for one in stents for fact in one.at(GLANCE)):
        found = {
            one.value("number"): fact.change
            for one in stents
            for fact in one.at(GLANCE)
            if fact.label == label
        }
        yield f"{label}: {of_each(found, are_several)}."


def _final(stents: Sequence[TreatedStent]) -> list[TreatedStent]:
    """The stents that lie in the vessel in the end; one dilated again does as the later one."""
    return [one for one in stents if one.again is None]


def today_facts(today: Today) -> Facts:
    """Lumen and stenosis before a stent is dilated again, with a sentence on both."""
    covered = [one for one in today.lesions or () if one.stents]
    lumens = ", ".join(
        f"stent {number} {UNKNOWN if math.isnan(width) else f'{width:.2f} mm'}"
        for number, width in today.minimum_lumen.items()
    )
    degrees = "; ".join(map(degree_change, covered))
    stenosis = f"; stenosis by diameter: {degrees}" if degrees else ""
    sentence = (
        f"Today, before the redilation as stent {today.redilation}: narrowest lumen {lumens}"
        f"{stenosis}. All else is of the later result."
    )
    lesions = [
        {
            "number": one.number,
            "stents": list(one.stents),
            "minimum_diameter_mm": one.after.minimum_diameter,
            "percent_diameter": one.after.percent_diameter,
        }
        for one in covered
    ]
    stents = [
        {"number": number, "minimum_lumen_mm": width}
        for number, width in today.minimum_lumen.items()
    ]
    return Facts(
        (
            Fact("before_stent", after=today.redilation),
            Fact("stents", after=stents),
            Fact("lesions", after=None if today.lesions is None else lesions),
            Fact("sentences", after=[sentence], words=sentence, level=LINES),
        )
    )


def outcome_facts(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    every: Sequence[TreatedStent] = (),
    ranges: Sequence[Ranged] = (),
) -> Facts:
    """Facts on the outcome of some stents but their lumen; a sentence each, and its few words.

    Parameters
    ----------
    stents : sequence of TreatedStent
        At least one: those to summarize.
    lesions : sequence of TreatedLesion or None
        Lesions of the vessel; None where none were looked for.
    every : sequence of TreatedStent
        Stents of the whole treatment, where these are only some.
    ranges : sequence of Ranged
        Ranges of the stenoses of the lesions, where the vessel was made of voxels.
    """
    stenosis = _stenosis(stents, lesions, every or stents, ranges)
    return Facts((stenosis, branches_fact(stents), *contact_fact(stents)))


def _stenosis(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    every: Sequence[TreatedStent],
    ranges: Sequence[Ranged],
) -> Fact:
    """Fact on the worst lesion that the stents cover, and on the residual stenosis in its vessel,
    wherever that is; of stents that cover none on the lesion beside them."""
    if not lesions:
        words = NOT_LOOKED_FOR if lesions is None else COVERS_NONE
        return _left(math.nan, words, "", "no lesions are known")
    numbers = {one.number for one in stents}
    covered = [one for one in lesions if numbers.intersection(one.stents)]
    left = residual_of(lesions, every)
    if not covered or left is None:
        beside = nearest_lesion(stents, lesions)
        percent = beside.after.percent_diameter
        hand = f"{UNCOVERED}; lesion {beside.number}: {degree_word(percent)} left"
        beneath = f"{UNCOVERED}; that of lesion {beside.number}"
        fact = _left(percent, COVERS_NONE, hand, beneath)._replace(is_caution=True)
        return fact._replace(within=range_of(f"lesion {beside.number}", ranges))
    before = degree_word(max(one.before.percent_diameter for one in covered))
    words = listed([degree_change(one) for one in covered], "; ")
    words = f"Stenosis by diameter: {words}. {residual_facts(left).named('words')}."
    hand = f"stenosis {before} -> {degree_word(left.percent)}"
    beneath = f"before {before}, healthy {number_text(left.reference, 1)} mm"
    fact = _left(left.percent, words, hand, beneath)
    return fact._replace(within=range_of(f"lesion {left.lesion}", ranges))


def range_of(name: str, ranges: Sequence[Ranged]) -> Span | None:
    """The range after treatment, of all, of the thing with a name."""
    return next((one.after for one in ranges if one.name == name), None)


def _left(percent: float, words: str, hand: str, beneath: str) -> Fact:
    return Fact(
        "stenosis",
        after=percent,
        unit="%",
        words=words,
        level=GLANCE,
        few=degree_word(percent),
        hand=hand,
        tile=STENOSIS,
        beneath=beneath,
    )


def surface_fact(certificate: Certificate | None, units: str = "mm") -> Fact:
    """Fact on the surface as a mesher's input; `certificate` is None where none was asked for."""
    word = NOT_CERTIFIED if certificate is None else certificate.word
    is_certified = certificate is not None and certificate.passed
    few, beneath = _OF_SURFACE[word]
    return Fact(
        "surface",
        after=is_certified,
        words="" if certificate is None else certificate.sentence(units),
        level=GLANCE,
        few=few,
        hand=word,
        tile=SURFACE,
        beneath=beneath,
        is_caution=not is_certified,
    )


def warning_facts(cautions: Sequence[Caution]) -> Iterator[Fact]:
    """Fact on the number of warnings, and their topics, the gravest first; none without any."""
    if not cautions:
        return
    ordered = by_gravity(cautions)
    first, more = ordered[0], len(ordered) - 1
    words = _SHORT.get(first.kind, first.kind.replace("-", " ")).format_map(first.numbers)
    topics = dict.fromkeys(one.kind.replace("-", " ") for one in ordered)
    yield Fact(
        "warnings",
        after=len(ordered),
        level=GLANCE,
        few=str(len(ordered)),
        hand=f"{WARNING}{words}{f', {more} more' if more else ''}",
        tile=WARNINGS,
        beneath=", ".join(topics),
        is_caution=True,
    )
