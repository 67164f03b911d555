"""Where a stent does not touch the wall all round, in documents and words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..vessel import Apposition
from .words import millimeters, number_text


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
    number = stent.get("number", document["stents"].index(stent) + 1)
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
    rows = "".join(
        f"<tr><td>{one['stent']}</td><td class='n'>{millimeters(one['start_mm'], 1)}</td>"
        f"<td class='n'>{millimeters(one['end_mm'], 1)}</td>"
        f"<td class='n'>{one['percent_free']:.0f} %</td></tr>"
        for one in stretches
    )
    return [
        "<h2>Not in contact all round</h2><table><tr><th>stent</th><th class='n'>from</th>"
        "<th class='n'>to</th><th class='n'>of the circumference is free</th></tr>"
        f"{rows}</table><p class='small'>From the proximal end of the stent. Across "
        "the ostium of a branch there is no wall to touch.</p>"
    ]
