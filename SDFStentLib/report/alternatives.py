"""Reports of several plans as rows of one table, in the words that each report has itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from .branches import NONE_NEAR, again_words, branch_lumen_words, stretch_sentence, stretches_of
from .changes import stretch_words
from .devices import device_words
from .facts import ALL_ROUND, BEYOND, CONTACT, LEFT, MINIMUM
from .flow import flow_rows, stents_in
from .html import certificate_sentence
from .lesions import NO_LESION, NOT_LOOKED_FOR, left_note
from .sizing import DIAMETERS
from .stents import stent_titles, stent_words
from .words import degree_text, degrees_text, millimeters

Section = Mapping[str, Any]
Lines = tuple[str, ...]


class Row(NamedTuple):
    """One line of the table: plain text, nothing escaped."""

    title: str
    note: str
    """Below the title: what is the same for all plans, such as the state before treatment."""
    cells: tuple[Lines, ...]
    """Per plan, what there is to say; nothing of a plan that could not be carried out."""
    is_good: tuple[bool, ...] | None = None
    """Per plan, in the row with the verdicts."""

    @property
    def is_empty(self) -> bool:
        """Whether it says nothing of any plan."""
        return not any(self.cells)


def comparison_rows(alternatives: Sequence[Section]) -> list[Row]:
    """The table of a comparison document: a row per thing to compare, a cell per alternative."""
    documents = [one["report"] for one in alternatives]
    rows = [
        _verdicts(alternatives),
        _of_each("Warnings", documents, lambda document: tuple(document["warnings"])),
        _of_each("Stents", documents, _stents),
        _of_each(LEFT, documents, _left_in_vessel),
        *_lesions(documents),
        _per_stent(MINIMUM, documents, partial(_change, "")),
        _per_stent(BEYOND, documents, partial(_change, "beyond_")),
        *_branches(documents),
        _per_stent_of(CONTACT, documents, _contact),
        _of_each("Pressure and flow", documents, _flow),
        _per_stent("Device", documents, _device),
        *(_per_stent(title, documents, partial(_size, key)) for key, title in DIAMETERS.items()),
        _of_each("Stretch of the wall, area after over before", documents, _stretch),
    ]
    return [row for row in rows if not row.is_empty]


def _verdicts(alternatives: Sequence[Section]) -> Row:
    """The certificate of each plan, or why it could not be carried out."""
    found = [
        (False, f"Could not be carried out: {one['failure']}")
        if one["report"] is None
        else certificate_sentence(one["report"]["certificate"])
        for one in alternatives
    ]
    cells = tuple((sentence,) for _, sentence in found)
    return Row("Certificate", "", cells, tuple(passed for passed, _ in found))


def _of_each(
    title: str,
    documents: Iterable[Section | None],
    told: Callable[[Section], Lines],
    note: str = "",
) -> Row:
    """A row of which every report tells its part."""
    return Row(title, note, tuple(told(one) if one is not None else () for one in documents))


def _per_stent(
    title: str, documents: Iterable[Section | None], told: Callable[[Section], str]
) -> Row:
    """A row with a line for every stent of which there is something to say."""
    return _per_stent_of(title, documents, lambda _, stent: told(stent))


def _per_stent_of(
    title: str, documents: Iterable[Section | None], told: Callable[[Section, Section], str]
) -> Row:
    def lines(document: Section) -> Lines:
        stents = document["stents"]
        named = zip(_labels(stents), stents, strict=True)
        return tuple(label + said for label, stent in named if (said := told(document, stent)))

    return _of_each(title, documents, lines)


def _labels(stents: Sequence[Section]) -> list[str]:
    """In front of what is said of a stent: its name or number; one stent alone needs none."""
    if len(stents) == 1:
        return [""]
    return [f"{stent.get('name') or 'Stent {}'.format(stent['number'])}: " for stent in stents]


def _stents(document: Section) -> Lines:
    """What they are, under their whole titles."""
    stents = document["stents"]
    titles = ["" if title == "Stent" else f"{title}. " for title in stent_titles(stents)]
    return tuple(title + stent_words(one) for title, one in zip(titles, stents, strict=True))


def _device(stent: Section) -> str:
    device = stent["device"]
    return "" if device is None else device_words(device)


def _size(key: str, stent: Section) -> str:
    value = stent[key]
    return "" if value is None else millimeters(value)


def _change(prefix: str, stent: Section) -> str:
    """A lumen after treatment, which is what is compared, and before."""
    lumen = stent["diameters"]["minimum_lumen"]
    after, before = (lumen[f"{prefix}{when}_mm"] for when in ("after", "before"))
    return f"{millimeters(after)} (before {millimeters(before)})"


def _lesions(documents: Sequence[Section | None]) -> list[Row]:
    """What is left of every lesion that a plan changes, and that the others stay."""
    known = [one["lesions"] for one in documents if one is not None and one["lesions"] is not None]
    if not known:
        return [_of_each("Lesions", documents, lambda _: (NOT_LOOKED_FOR,))]
    if not known[0]:
        return [Row("Lesions", NO_LESION, tuple(() for _ in documents))]
    rows, left = [], []
    for place, lesion in enumerate(known[0]):
        if any(_is_changed(lesions[place]) for lesions in known):
            note = f"{lesion['branch_name']}; before: {_degrees(lesion)}"
            title = f"Stenosis left of lesion {lesion['number']}"
            told = _left_of(place)
            rows.append(_of_each(title, documents, told, note))
        else:
            left.append(f"lesion {lesion['number']} {degree_text(lesion['percent_diameter'])}")
    if left:
        cells = tuple(() if one is None else ("as before",) for one in documents)
        rows.append(Row("Other lesions, by diameter", ", ".join(left), cells))
    return rows


def _left_in_vessel(document: Section) -> Lines:
    left = document["left"]
    return () if left is None else (left["words"],)


def _left_of(place: int) -> Callable[[Section], Lines]:
    def told(document: Section) -> Lines:
        if document["lesions"] is None:
            return (NOT_LOOKED_FOR,)
        lesion = document["lesions"][place]
        is_beyond = bool(lesion["is_left_beyond"] and lesion["stents"])
        note = left_note(lesion["after"]["percent_diameter"], is_beyond)
        covered = "" if lesion["stents"] else "; not stented"
        return (f"{_degrees(lesion['after'])}{covered}.{note}",)

    return told


def _is_changed(lesion: Section) -> bool:
    same = all(lesion[key] == lesion["after"][key] for key in ("percent_diameter", "percent_area"))
    return bool(lesion["stents"]) or not same


def _degrees(lesion: Section) -> str:
    return degrees_text(lesion["percent_diameter"], lesion["percent_area"])


def _branches(documents: Sequence[Section | None]) -> list[Row]:
    """Every side branch beside a stent of one of the plans."""
    near = [branch for one in documents if one is not None for branch in one["branches"]]
    if not near:
        return [_of_each("Branches", documents, lambda _: (NONE_NEAR,))]
    names = dict.fromkeys(branch["name"] for branch in near)
    return [_of_each(f"Ostium of {name}", documents, _beside(name)) for name in names]


def _beside(name: str) -> Callable[[Section], Lines]:
    def told(document: Section) -> Lines:
        stents = document["stents"]
        labels = dict(zip((one["number"] for one in stents), _labels(stents), strict=True))
        lines = tuple(
            f"{labels[one['stent']]}{one['coverage']}; its lumen {branch_lumen_words(one)}"
            for one in document["branches"]
            if one["name"] == name
        )
        return lines or ("no stent is near",)

    return told


def _contact(document: Section, stent: Section) -> str:
    if "dilated_again_as" in stent:
        return again_words(stent["dilated_again_as"])
    free = stretches_of(document, stent)
    return "; ".join(map(stretch_sentence, free)) or ALL_ROUND


def _stretch(document: Section) -> Lines:
    return (stretch_words(document["changes"]),)


def _flow(document: Section) -> Lines:
    section = document["flow"]
    return () if section is None else tuple(map(": ".join, flow_rows(section, stents_in(section))))
