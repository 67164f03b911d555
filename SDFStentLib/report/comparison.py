"""Plans side by side: one document, and from it a page for the heart-team meeting."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from html import escape
from typing import Any

from ..plan import PlanComparison
from ..validation import DeploymentError, check_is_a
from ..version import VERSION
from .alternatives import ComparedRow, comparison_rows
from .flow import FLOW_NOTE
from .markup import beginning, page, paragraph, picture
from .picture import alternatives_picture
from .report import DEFINITIONS, plan_report
from .words import RESEARCH_USE

SCHEMA = "sdfstent-comparison"
SCHEMA_VERSION = 1

SIDE_BY_SIDE = 4
"""Plans on one sheet; more go on further sheets, each with the vessel before treatment."""

EXPLAINED = (
    "inscribed diameter",
    "minimum lumen diameter",
    "beyond the ends",
    "reference",
    "percent diameter stenosis",
    "percent area stenosis",
)
"""Definitions of the report that the page repeats."""

_STYLE = """
body{font:13px/1.35 system-ui,sans-serif;color:#1a1a1a;max-width:1200px;margin:16px auto;
padding:0 16px}h1{font-size:20px;margin:0}.sub{color:#555;margin:0 0 4px}
.notice{font-weight:600;border-left:5px solid #b30000;padding:3px 10px;background:#fff4f2;
margin:4px 0}table{border-collapse:collapse;width:100%;table-layout:fixed;margin:2px 0}
th,td{text-align:left;padding:3px 8px;border-bottom:1px solid #e4e4e4;vertical-align:top;
overflow-wrap:anywhere}thead th{font-size:15px;border-bottom:2px solid #999}
td+td,th+th{border-left:1px solid #e4e4e4}p{margin:0}.note{color:#555;font-weight:400}
.good{background:#eef8f0;box-shadow:inset 4px 0 #1a7f37}
.bad{background:#fff0ee;box-shadow:inset 4px 0 #b30000}
.small,.small td,.note{font-size:11px}.small{color:#444;margin-top:6px}
img{width:100%;height:auto;object-fit:contain}section+section{break-before:page}
@page{size:A4 landscape;margin:9mm}@media print{body{margin:0;padding:0;max-width:none;
font-size:10.5px}h1{font-size:16px}.sub,.notice{font-size:10.5px}thead th{font-size:12px}
tr,img{break-inside:avoid}img{max-height:74mm}th,td{padding:2px 6px}
.small,.small td,.note{font-size:9px}
td,th,p{-webkit-print-color-adjust:exact;print-color-adjust:exact}}
"""


def comparison_document(comparison: PlanComparison) -> dict[str, Any]:
    """A comparison, for `document_json` and the page: of every plan the whole report.

    Raises
    ------
    InputError
        Something else than a comparison.
    """
    check_is_a(comparison, PlanComparison, "comparison")
    return {
        "schema": SCHEMA,
        "schema_version": SCHEMA_VERSION,
        "notice": RESEARCH_USE,
        "sdfstent_version": VERSION,
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "alternatives": [
            {
                "name": one.name,
                "certified": one.is_certified,
                "failure": one.failure or None,
                "report": one.result and plan_report(one.result, whole_tree=True),
            }
            for one in comparison.alternatives
        ],
        "outputs": [],
    }


def comparison_pictures(
    comparison: PlanComparison, *, hides_device: bool = False
) -> list[bytes] | str:
    """Pictures of the page's sheets, or the sentence that says why there are none.

    Empty for a sheet on which no plan could be carried out. `hides_device` as of
    `alternatives_picture`.
    """
    sheets = [
        {one.name: one.result for one in sheet if one.result is not None}
        for sheet in _sheets(comparison.alternatives)
    ]
    try:
        return [
            alternatives_picture(results, hides_device=hides_device) if results else b""
            for results in sheets
        ]
    except DeploymentError as error:
        return str(error)


def comparison_page(document: Mapping[str, Any], pictures: Sequence[bytes] | str = ()) -> str:
    """A self-contained page, for paper A4 across: pictures by one camera, and a table.

    Parameters
    ----------
    document : mapping
        As of `comparison_document`.
    pictures : sequence of bytes, or str
        As of `comparison_pictures`.
    """
    alternatives = document["alternatives"]
    sheets = _sheets(alternatives)
    shown = [] if isinstance(pictures, str) else [*pictures]
    names = ", ".join(str(one["name"]) for one in alternatives)
    parts = beginning("Virtual stenting: plans compared", document, _of_which_vessel(alternatives))
    if isinstance(pictures, str):
        parts.append(paragraph(pictures, "small"))
    for place, sheet in enumerate(sheets):
        images = "".join(
            picture(one, "The vessel before and after each plan")
            for one in shown[place : place + 1]
            if one
        )
        parts.append(f"<section>{images}{_table(sheet)}</section>")
    return page(f"Plans compared: {names}", [*parts, _footnotes(alternatives)], _STYLE)


def _sheets(things: Sequence[Any]) -> list[Sequence[Any]]:
    """The sheets, as few as it takes, with about as many plans on each."""
    sheets = -(-len(things) // SIDE_BY_SIDE)
    width = -(-len(things) // max(sheets, 1))
    return [things[start : start + width] for start in range(0, len(things), max(width, 1))]


def _of_which_vessel(alternatives: Iterable[Mapping[str, Any]]) -> str:
    """The file of the surface."""
    report = next(one["report"] for one in alternatives if one["report"] is not None)
    return str(report.sections["inputs"][0].value("file")).replace("\\", "/").split("/")[-1]


def _table(alternatives: Sequence[Mapping[str, Any]]) -> str:
    names = "".join(f"<th>{escape(str(one['name']))}</th>" for one in alternatives)
    rows = "".join(map(_row, comparison_rows(alternatives)))
    return f"<table><thead><tr><th>Plan</th>{names}</tr></thead>{rows}</table>"


def _row(row: ComparedRow) -> str:
    note = paragraph(row.note, "note") if row.note else ""
    looks = [""] * len(row.cells)
    if row.is_good is not None:
        looks = [f" class='{'good' if one else 'bad'}'" for one in row.is_good]
    cells = "".join(
        f"<td{look}>{''.join(map(paragraph, lines))}</td>"
        for look, lines in zip(looks, row.cells, strict=True)
    )
    return f"<tr><td><b>{escape(row.title)}</b>{note}</td>{cells}</tr>"


def _footnotes(alternatives: Sequence[Mapping[str, Any]]) -> str:
    """Meaning of the words, and the note on pressure where there is some."""
    said = [f"<b>{name}</b>: {escape(DEFINITIONS[name])}" for name in EXPLAINED]
    reports = [one["report"] for one in alternatives if one["report"] is not None]
    if any(report.sections["flow"] for report in reports):
        said.append(f"<b>pressure and flow</b>: {escape(FLOW_NOTE)}")
    return f"<p class='small'>{'. '.join(said)}</p>"
