"""A deployment in a few lines, as a cardiologist reads it; the report has the rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from ..plan import PlanResult, Today
from ..treatment import (
    BranchBeside,
    Residual,
    TreatedLesion,
    TreatedStent,
    branches_beside,
    label_of,
)
from .branches import NONE_NEAR, again_words, stent_branch_sentences
from .devices import stent_device_sentences
from .diameters import lumen_sentence
from .facts import CONTACT, MINIMUM, contact_fact, lumen_fact, residual_fact
from .flow import flow_line, flow_section, flow_sentences
from .lesions import (
    COVERS_NONE,
    NOT_LOOKED_FOR,
    degree_change,
    stent_lesion_sentences,
)
from .sizing import stent_balloon_sentences, stent_ratio_sentences
from .stents import deployed_words, prescribed_words
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
    lines = [
        *today_sentences(result.today),
        f"{MINIMUM}: {_of_each(_final(stents), _narrowest, len(stents) > 1)}.",
        _stenosis(result.lesions, result.residual),
        *_told(stents, result),
    ]
    certificate = result.treatment.certificate
    if certificate is not None:
        lines.append(certificate.sentence(result.inputs.surface.units))
    return Summary(f"Deployed: {_of_each(stents, _deployed)}.", lines)


def deployment_sentences(result: PlanResult) -> Iterator[str]:
    """All that is known of every stent, as the report has it."""
    yield from today_sentences(result.today)
    for stent in result.told.stents:
        label = label_of(result.plan.stents, stent.number)
        for sentence in (
            lumen_sentence(stent),
            *stent_device_sentences(stent),
            *stent_balloon_sentences(stent, result.lesions),
            *stent_ratio_sentences(stent, result.lesions),
            *stent_branch_sentences(stent),
            *stent_lesion_sentences(result.lesions, stent.number),
        ):
            yield label + sentence
    if result.flow is not None:
        yield from flow_sentences(flow_section(result.flow))
    if result.treatment.certificate is not None:
        yield result.treatment.certificate.sentence(result.inputs.surface.units)


def _told(stents: Sequence[TreatedStent], result: PlanResult) -> list[str]:
    """Branches and contact, in one line where pressures, which were asked for, need the other."""
    contact = _of_each([one for one in stents if _loose(one)], _loose, len(stents) > 1)
    beside = [_branches(stents), *([f"{CONTACT}: {contact}."] if contact else [])]
    if result.flow is None:
        return beside
    return [" ".join(beside), flow_line(flow_section(result.flow))]


def _of_each(
    stents: Sequence[TreatedStent],
    fact: Callable[[TreatedStent], str],
    is_numbered: bool | None = None,
) -> str:
    is_numbered = len(stents) > 1 if is_numbered is None else is_numbered
    return _listed(
        [f"stent {one.number}: {fact(one)}" if is_numbered else fact(one) for one in stents], "; "
    )


def _final(stents: Sequence[TreatedStent]) -> list[TreatedStent]:
    """Those that lie in the vessel in the end; one dilated again does as the later one."""
    return [one for one in stents if one.again is None]


def _listed(words: Sequence[str], between: str = ", ") -> str:
    more = len(words) - LISTED
    return between.join([*words[:LISTED], *([f"and {more} more"] if more > 0 else [])])


def _deployed(one: TreatedStent) -> str:
    again = "" if one.again is None else f", {again_words(one.again)}"
    return f"{deployed_words(one)}{again}"


def _narrowest(one: TreatedStent) -> str:
    return f"{lumen_fact(one.before, one.after).words}, prescribed {prescribed_words(one)}"


def _stenosis(lesions: Sequence[TreatedLesion] | None, residual: Residual | None) -> str:
    if lesions is None:
        return NOT_LOOKED_FOR
    covered = [one for one in lesions if one.stents]
    if not covered:
        return COVERS_NONE
    left = "" if residual is None else f" {residual_fact(residual)}."
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


def _loose(one: TreatedStent) -> str:
    """How much of a stent does not touch the wall; empty where all of it does."""
    found = one.apposition
    return contact_fact(found).words if found is not None and found.stretches else ""


def today_sentences(today: Today | None) -> list[str]:
    """Lumen and stenosis before a stent is dilated again; none for a plan without a redilation."""
    if today is None:
        return []
    lumens = [
        f"stent {number} {UNKNOWN if math.isnan(width) else f'{width:.2f} mm'}"
        for number, width in today.minimum_lumen.items()
    ]
    degrees = [degree_change(one) for one in today.lesions or () if one.stents]
    stenosis = f"; stenosis by diameter: {'; '.join(degrees)}" if degrees else ""
    return [
        f"Today, before the redilation as stent {today.redilation}: narrowest lumen "
        f"{', '.join(lumens)}{stenosis}. All else is of the later result."
    ]


def today_section(today: Today | None) -> dict[str, Any] | None:
    """The same as values of JSON; null for a plan without a redilation."""
    if today is None:
        return None
    return {
        "before_stent": today.redilation,
        "stents": [
            {"number": number, "minimum_lumen_mm": width}
            for number, width in today.minimum_lumen.items()
        ],
        "lesions": None
        if today.lesions is None
        else [
            {
                "number": one.number,
                "stents": list(one.stents),
                "minimum_diameter_mm": one.after.minimum_diameter,
                "percent_diameter": one.after.percent_diameter,
            }
            for one in today.lesions
            if one.stents
        ],
        "sentences": today_sentences(today),
    }
