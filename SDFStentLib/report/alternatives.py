"""Reports of several plans as rows of one table, in the words that each report has itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from .branches import ALL_ROUND, CONTACT, NONE_NEAR, again_words
from .facts import COMPARED, Facts
from .flow import flow_rows, stents_in
from .html import certificate_sentence
from .lesions import LEFT, NO_LESION, NOT_LOOKED_FOR
from .stents import stent_titles
from .views import HEADING, NOT_TOLD, WORST
from .words import degrees_text

Section = Mapping[str, Any]
Lines = tuple[str, ...]


class ComparedRow(NamedTuple):
    """A line of the table: plain text, nothing escaped."""

    title: str
    note: str
    """Words below the title that hold for all plans, such as the state before treatment."""
    cells: tuple[Lines, ...]
    """Lines per plan; none for a plan that could not be carried out."""
    is_good: tuple[bool, ...] | None = None
    """Verdict per plan, in the row with the verdicts."""

    @property
    def is_empty(self) -> bool:
        """Whether it says nothing of any plan."""
        return not any(self.cells) and not self.note


def comparison_rows(alternatives: Sequence[Section]) -> list[ComparedRow]:
    """The table of a comparison: a row per thing to compare, a cell per alternative."""
    reports = [one["report"] for one in alternatives]
    documents = [None if one is None else one.sections for one in reports]
    rows = [
        _verdicts(alternatives),
        _of_each("Warnings", documents, lambda document: tuple(document["warnings"])),
        _of_each("Stents", documents, _stents),
        _of_each(LEFT, documents, _left_in_vessel),
        *_lesions(documents),
        *_facts(documents, are_changed=True),
        *_branches(documents),
        _per_stent(CONTACT, documents, _contact),
        _of_each("Pressure and flow", documents, _flow),
        *_views(documents),
        *_facts(documents, are_changed=False),
        _of_each("Stretch of the wall, area after over before", documents, _stretch),
    ]
    return [row for row in rows if not row.is_empty]


def _verdicts(alternatives: Sequence[Section]) -> ComparedRow:
    """The certificate of each plan, or why it could not be carried out."""
    found = [
        (False, f"Could not be carried out: {one['failure']}")
        if one["report"] is None
        else certificate_sentence(one["report"].sections["certificate"])
        for one in alternatives
    ]
    cells = tuple((sentence,) for _, sentence in found)
    return ComparedRow("Certificate", "", cells, tuple(passed for passed, _ in found))


def _of_each(
    title: str,
    documents: Iterable[Section | None],
    told: Callable[[Section], Lines],
    note: str = "",
) -> ComparedRow:
    """Row with a cell of every report."""
    return ComparedRow(
        title, note, tuple(told(one) if one is not None else () for one in documents)
    )


def _per_stent(
    title: str, documents: Iterable[Section | None], told: Callable[[Section, Facts], str]
) -> ComparedRow:
    """Row with a line for every stent that has one."""

    def lines(document: Section) -> Lines:
        stents = document["stents"]
        named = zip(_labels(stents), stents, strict=True)
        return tuple(label + said for label, stent in named if (said := told(document, stent)))

    return _of_each(title, documents, lines)


def _labels(stents: Sequence[Facts]) -> list[str]:
    """Label of a stent in a cell: name or number; one stent alone needs none."""
    if len(stents) == 1:
        return [""]
    return [f"{one.value('name') or 'Stent {}'.format(one.value('number'))}: " for one in stents]


def _stents(document: Section) -> Lines:
    """Words for the stents of a plan, under their whole titles."""
    stents = document["stents"]
    titles = stent_titles([one.as_dict() for one in stents])
    shown = ["" if title == "Stent" else f"{title}. " for title in titles]
    told = (one.named("_whole").words for one in stents)
    return tuple(title + words for title, words in zip(shown, told, strict=True))


def _facts(documents: Sequence[Section | None], *, are_changed: bool) -> list[ComparedRow]:
    """Rows for the facts on stents that are compared."""
    stents = [stent for one in documents if one is not None for stent in one["stents"]]
    found = [fact for stent in stents for fact in stent.at(COMPARED) if fact.label]
    labels = dict.fromkeys(one.label for one in found if bool(one.was) == are_changed)
    return [_per_stent(label, documents, partial(_cell, label)) for label in labels]


def _cell(label: str, _document: Section, stent: Facts) -> str:
    return next((one.cell for one in stent.at(COMPARED) if one.label == label), "")


def _lesions(documents: Sequence[Section | None]) -> list[ComparedRow]:
    """Rows with the stenosis left of every lesion that a plan changes, and one for all others."""
    known = [one["lesions"] for one in documents if one is not None and one["lesions"] is not None]
    if not known:
        return [_of_each("Lesions", documents, lambda _: (NOT_LOOKED_FOR,))]
    if not known[0]:
        return [ComparedRow("Lesions", NO_LESION, tuple(() for _ in documents))]
    rows, left = [], []
    for place, lesion in enumerate(known[0]):
        number = lesion.value("number")
        if any(_is_changed(lesions[place]) for lesions in known):
            percents = (lesion.value(f"percent_{kind}") for kind in ("diameter", "area"))
            note = f"{lesion.value('branch_name')}; before: {degrees_text(*percents)}"
            title = f"Stenosis left of lesion {number}"
            rows.append(_of_each(title, documents, partial(_left_of, place), note))
        else:
            left.append(f"lesion {number} {lesion.named('percent_diameter').words}")
    if left:
        cells = tuple(() if one is None else ("as before",) for one in documents)
        rows.append(ComparedRow("Other lesions, by diameter", ", ".join(left), cells))
    return rows


def _left_in_vessel(document: Section) -> Lines:
    left = document["left"]
    return () if left is None else (left.value("words"),)


def _left_of(place: int, document: Section) -> Lines:
    lesions = document["lesions"]
    return (NOT_LOOKED_FOR if lesions is None else lesions[place].named("_left").words,)


def _is_changed(lesion: Facts) -> bool:
    keys = ("percent_diameter", "percent_area")
    same = all(lesion.value(key) == lesion.value(f"after.{key}") for key in keys)
    return bool(lesion.value("stents")) or not same


def _branches(documents: Sequence[Section | None]) -> list[ComparedRow]:
    """Rows for the side branches beside a stent of one of the plans."""
    near = [branch for one in documents if one is not None for branch in one["branches"]]
    if not near:
        return [_of_each("Branches", documents, lambda _: (NONE_NEAR,))]
    names = dict.fromkeys(branch.value("name") for branch in near)
    return [_of_each(f"Ostium of {name}", documents, partial(_beside, name)) for name in names]


def _beside(name: str, document: Section) -> Lines:
    stents = document["stents"]
    labels = dict(zip((one.value("number") for one in stents), _labels(stents), strict=True))
    lines = tuple(
        f"{labels[one.value('stent')]}{one.value('coverage')}; its lumen "
        f"{one.named('_lumen').words}"
        for one in document["branches"]
        if one.value("name") == name
    )
    return lines or ("no stent is near",)


def _contact(document: Section, stent: Facts) -> str:
    again, number = stent.value("dilated_again_as"), stent.value("number")
    if again is not None:
        return again_words(again)
    free = (one for one in document["apposition"] if one.value("stent") == number)
    return "; ".join(one.named("_whole").words for one in free) or ALL_ROUND


def _views(documents: Sequence[Section | None]) -> list[ComparedRow]:
    """Rows for the views of the stents; or one that says why there are none."""
    known = [one["views"] for one in documents if one is not None]
    if all(views.reason for views in known):
        reasons = dict.fromkeys(views.reason for views in known)
        return [ComparedRow(HEADING, " ".join(reasons), tuple(() for _ in documents))]
    facts = [fact for views in known for stent in views.stents for fact in stent.told.facts]
    roles = dict.fromkeys(str(one.value("role")) for one in facts)
    return [
        _of_each(role.capitalize(), documents, partial(_seen_from, role))
        for role in roles
        if role != WORST.lower()
    ]


def _seen_from(role: str, document: Section) -> Lines:
    views, stents = document["views"], document["stents"]
    labels = dict(zip((one.value("number") for one in stents), _labels(stents), strict=True))
    lines = tuple(
        f"{labels[one.number]}{facts.named('_view').words}; {facts.named('_shown').words}"
        for one in views.stents
        for facts in one.told.facts
        if facts.value("role") == role
    )
    return lines or ((NOT_TOLD,) if views.reason else ())


def _stretch(document: Section) -> Lines:
    return (document["changes"].named("area_ratio").words,)


def _flow(document: Section) -> Lines:
    section = document["flow"]
    return () if section is None else tuple(flow_rows(section, stents_in(section)))
