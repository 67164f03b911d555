"""Lesions on the report's page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from .facts import stenosis_fact
from .lesions import COVERS_NONE, NO_LESION, NOT_LOOKED_FOR, left_note
from .words import degree_text, millimeters, point_words

Section = Mapping[str, Any]


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
        f"{left_note(one['after']['percent_diameter'], one.get('is_left_beyond', False))}"
        for one in lesions
    )


def lesion_table(lesions: Sequence[Section] | None) -> list[str]:
    """All lesions of the vessel, with what is left of each."""
    if lesions is None:
        return []
    title = "<h2>Lesions of the vessel</h2>"
    if not lesions:
        return [f"{title}<p>{escape(NO_LESION)}</p>"]
    rows = "".join(
        f"<tr><td>{one['number']}</td><td class='place'>{escape(one['branch_name'])}, "
        f"{millimeters(one['along_branch_mm'], 1)} along it; "
        f"{point_words(one['place_mm'], one['units'])}</td>"
        f"<td class='n'>{millimeters(one['extent']['length_mm'], 1)}</td>"
        f"<td class='n'>{millimeters(one['minimum']['diameter_mm'])}</td>"
        f"<td class='n'>{millimeters(one['reference']['diameter_mm'])}</td>"
        f"<td class='n'>{degree_text(one['percent_diameter'])}</td>"
        f"<td class='n degree'>{degree_text(one['after']['percent_diameter'])}</td>"
        f"<td>{', '.join(map(str, one['stents'])) or 'none'}</td></tr>"
        for one in lesions
    )
    return [
        f"{title}<table><tr><th>lesion</th><th>narrowest at (x, y, z)</th>"
        "<th class='n'>length</th><th class='n'>minimum diameter</th>"
        "<th class='n'>reference diameter</th><th class='n'>diameter stenosis before</th>"
        "<th class='n'>after</th><th>stent</th></tr>"
        f"{rows}</table>"
    ]
