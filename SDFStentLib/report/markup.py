"""Pages of HTML from their parts: self-contained, no scripts; every text is escaped here."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from ..validation import printable
from .facts import Facts

PAGE_STYLE = """
body{font:15px/1.45 system-ui,sans-serif;color:#1a1a1a;max-width:860px;margin:24px auto;
padding:0 16px}
h1{font-size:23px;margin:0 0 2px}h3{font-size:14px;margin:12px 0 2px}
h2{font-size:17px;margin:28px 0 6px;border-bottom:1px solid #ccc}
.sub{color:#555;margin:0 0 12px}.notice{font-weight:600;border-left:5px solid #b30000;
padding:4px 10px;background:#fff4f2}table{border-collapse:collapse;width:100%;margin:6px 0}
th,td{text-align:left;padding:5px 10px;border-bottom:1px solid #e4e4e4;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}td.n{white-space:nowrap}
td.n.degree{white-space:normal}td.covered{font-weight:bold}
.head{font-weight:bold}.place{min-width:9em}.first td{font-size:17px}
.good{border-left:5px solid #777;background:#f4f4f4;padding:6px 10px}
.bad{border-left:5px solid #b30000;background:#fff0ee;padding:6px 10px}
.warn{border-left:5px solid #b37400;background:#fff8e8;padding:6px 10px;margin:4px 0}
.words td:first-child{width:36%}
.small{font-size:13px;color:#444}table.file td{word-break:break-all}
svg,img{width:100%;height:auto;object-fit:contain}
@page{margin:14mm}@media print{body{margin:0;padding:0;max-width:none;font-size:12.5px}
h2{margin-top:16px}h2,h3{break-after:avoid}section,tr,p,img,svg{break-inside:avoid}
th,td{padding:3px 8px}.first td{font-size:13.5px}.small{font-size:11px}
img,svg{max-height:82mm}.details{break-before:page}}
"""


Moments = Sequence[tuple[str, Facts]]
"""Headings, each with its facts."""


class Cell(NamedTuple):
    """A cell of a table, with a class of its own in place of its column's."""

    text: str
    look: str


def page(title: str, parts: Iterable[str], style: str = PAGE_STYLE) -> str:
    """A whole page."""
    lines = (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width'>",
        f"<title>{escape(title)}</title><style>{style}</style></head><body>",
        *parts,
        "</body></html>\n",
    )
    return printable("\n".join(lines))


def beginning(title: str, document: Mapping[str, Any], of: str = "") -> list[str]:
    """Head of a page: title, its file and time, and that it is for research."""
    parts = [f"<h1>{escape(title)}</h1>"]
    if of:
        when = document["created"].replace("T", " ").replace("+00:00", " UTC").replace("Z", " UTC")
        told = (of, when, f"sdfstent {document['sdfstent_version']}")
        parts.append(paragraph(" \N{MIDDLE DOT} ".join(told), "sub"))
    return [*parts, paragraph(document["notice"], "notice")]


def heading(text: str, level: int = 2) -> str:
    """A heading."""
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str, look: str = "") -> str:
    """A paragraph."""
    return f"<p{_class(look)}>{escape(text)}</p>"


def picture(png: bytes, words: str) -> str:
    """A PNG within the page, with the words for who cannot see it."""
    data = b64encode(png).decode("ascii")
    return f"<img alt='{escape(words)}' src='data:image/png;base64,{data}'>"


def table(
    rows: Iterable[Sequence[str | Cell]],
    head: Sequence[str] = (),
    looks: Sequence[str] = (),
    look: str = "",
    row_look: str = "",
) -> str:
    """A table; `looks` are the classes of its columns. A row of one cell is a heading within."""
    classes = [*looks, *[""] * 20]
    titles = "".join(
        f"<th{_class('n' if one.startswith('n') else '')}>{escape(text)}</th>"
        for text, one in zip(head, classes, strict=False)
    )
    lines = [f"<tr>{titles}</tr>"] if head else []
    for row in rows:
        cells = "".join(
            f"<td{_class(one.look)}>{escape(one.text)}</td>"
            if isinstance(one, Cell)
            else f"<td{_class(usual)}>{escape(one)}</td>"
            for one, usual in zip(row, classes, strict=False)
        )
        if len(row) == 1:
            cells = f"<th colspan='2'>{escape(str(row[0]))}</th>"
        lines.append(f"<tr{_class(row_look)}>{cells}</tr>")
    return f"<table{_class(look)}>{''.join(lines)}</table>"


def facts_table(facts: Sequence[Facts], looks: Mapping[str, str]) -> str:
    """A row per subject; `looks` are the classes of columns by label."""
    head = [label for label, _ in facts[0].rows()]
    rows = [[words for _, words in one.rows()] for one in facts]
    return table(rows, head, [looks.get(label, "") for label in head])


def moments_table(moments: Moments) -> str:
    """Headings, each with its rows."""
    rows: list[tuple[str, ...]] = []
    for at, facts in moments:
        rows += [(at,), *((one.label, one.change) for one in facts)]
    return table(rows, look="words")


def notes_part(document: Mapping[str, Any]) -> list[str]:
    """Notes that a reader of the numbers needs."""
    return [paragraph(note, "small") for note in document["notes"]]


def _class(look: str) -> str:
    return f" class='{look}'" if look else ""
