"""A deployment in a few lines, as a cardiologist reads it; the report has the rest."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from ..plan import PlanResult, Today
from ..treatment import (
    BranchBeside,
    Residual,
    TreatedLesion,
    TreatedStent,
    branches_beside,
    label_of,
)
from .branches import CONTACT, NONE_NEAR, contact_words
from .facts import GLANCE, LINES, Fact, Facts
from .flow import flow_line, flow_section, flow_sentences
from .lesions import (
    COVERS_NONE,
    NOT_LOOKED_FOR,
    degree_change,
    residual_facts,
    stent_lesion_sentences,
)
from .stents import stent_facts
from .words import UNKNOWN

LISTED = 4
"""Of stents, lesions and branches each; of more the number is told."""


class Summary(NamedTuple):
    """What is said at once of a deployment, without its warnings."""

    deployed: str
    results: list[str]
    """At most five lines, the certificate's last; one more where a stent is dilated again."""


def deployment_summary(result: PlanResult) -> Summary:
    """The stents, and what came of them: lumen, stenosis, branches and contact."""
    stents = result.told.stents
    facts = {one.number: stent_facts(one, result.lesions) for one in stents}
    lines = [
        *(today_facts(result.today).sentences if result.today else ()),
        *_at_a_glance([facts[one.number] for one in _final(stents)], len(stents) > 1),
        _stenosis(result.lesions, result.residual),
        *_told(stents, result),
    ]
    certificate = result.treatment.certificate
    if certificate is not None:
        lines.append(certificate.sentence(result.inputs.surface.units))
    deployed = {number: one.named("_deployed").words for number, one in facts.items()}
    return Summary(f"Deployed: {_of_each(deployed)}.", lines)


def deployment_sentences(result: PlanResult) -> Iterator[str]:
    """All that is known of every stent, as the report has it."""
    yield from today_facts(result.today).sentences if result.today else ()
    for stent in result.told.stents:
        label = label_of(result.plan.stents, stent.number)
        yield from (label + line for line in stent_lines(stent, result.lesions))
    if result.flow is not None:
        yield from flow_sentences(flow_section(result.flow))
    if result.treatment.certificate is not None:
        yield result.treatment.certificate.sentence(result.inputs.surface.units)


def stent_lines(stent: TreatedStent, lesions: Sequence[TreatedLesion] | None) -> list[str]:
    """What there is to say of a stent, a line per quantity: for shell and panel."""
    told = [
        f"{one}." if one.label else str(one)
        for one in stent_facts(stent, lesions).at(LINES)
        if not one.label or ((one.was or one.level == GLANCE) and one.is_known)
    ]
    return [*told, *stent_lesion_sentences(lesions, stent.number)]


def _at_a_glance(stents: Sequence[Facts], are_several: bool) -> Iterator[str]:
    """A line per fact that is told first, of all stents."""
    for label in dict.fromkeys(fact.label for one in stents for fact in one.at(GLANCE)):
        found = {
            one.value("number"): fact.change
            for one in stents
            for fact in one.at(GLANCE)
            if fact.label == label
        }
        yield f"{label}: {_of_each(found, are_several)}."


def _told(stents: Sequence[TreatedStent], result: PlanResult) -> list[str]:
    """Branches and contact, in one line where pressures, which were asked for, need the other."""
    loose = {one.number: words for one in stents if (words := contact_words(one.apposition))}
    contact = _of_each(loose, len(stents) > 1)
    beside = [_branches(stents), *([f"{CONTACT}: {contact}."] if contact else [])]
    if result.flow is None:
        return beside
    return [" ".join(beside), flow_line(flow_section(result.flow))]


def _of_each(words: Mapping[int, str], is_numbered: bool | None = None) -> str:
    """What there is of stents by number; of one alone without it."""
    is_numbered = len(words) > 1 if is_numbered is None else is_numbered
    told = [f"stent {one}: {said}" if is_numbered else said for one, said in words.items()]
    return _listed(told, "; ")


def _final(stents: Sequence[TreatedStent]) -> list[TreatedStent]:
    """Those that lie in the vessel in the end; one dilated again does as the later one."""
    return [one for one in stents if one.again is None]


def _listed(words: Sequence[str], between: str = ", ") -> str:
    more = len(words) - LISTED
    return between.join([*words[:LISTED], *([f"and {more} more"] if more > 0 else [])])


def _stenosis(lesions: Sequence[TreatedLesion] | None, residual: Residual | None) -> str:
    if lesions is None:
        return NOT_LOOKED_FOR
    covered = [one for one in lesions if one.stents]
    if not covered:
        return COVERS_NONE
    left = "" if residual is None else f" {residual_facts(residual).named('words')}."
    return f"Stenosis by diameter: {_listed([degree_change(one) for one in covered], '; ')}.{left}"


def _branches(stents: Sequence[TreatedStent]) -> str:
    """Which side branches are covered or narrowed."""
    every = branches_beside(stents)
    several = len(stents) > 1
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
    """A branch, with the stent from which its place counts where there are several."""
    stent = f"stent {branch.nearest}" if of_several else ""
    said = ", ".join(filter(None, (stent, coverage)))
    return f"{branch.ostium.name} ({said})" if said else branch.ostium.name


def _kind(what: str, names: Sequence[str]) -> Iterable[str]:
    return [f"{len(names)} {what}: {_listed(names)}"] if names else []


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
