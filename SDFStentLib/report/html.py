"""The report as one self-contained page: no scripts, nothing loaded from elsewhere."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import Any

from ..validation import printable
from .branches import apposition_table, branch_table, stretches_of
from .changes import change_rows, setting_rows
from .diameters import first_numbers
from .facts import LEFT
from .flow import flow_part
from .lesions import lesion_table, stent_lesions
from .picture.drawing import svg
from .picture.plot import diameter_plot
from .stents import stent_rows, stent_titles, stent_words
from .words import input_rows, number_text, plain_label

_STYLE = """
body{font:15px/1.45 system-ui,sans-serif;color:#1a1a1a;max-width:860px;margin:24px auto;
padding:0 16px}
h1{font-size:23px;margin:0 0 2px}h3{font-size:14px;margin:12px 0 2px}
h2{font-size:17px;margin:28px 0 6px;border-bottom:1px solid #ccc}
.sub{color:#555;margin:0 0 12px}.notice{font-weight:600;border-left:5px solid #b30000;
padding:4px 10px;background:#fff4f2}table{border-collapse:collapse;width:100%;margin:6px 0}
th,td{text-align:left;padding:5px 10px;border-bottom:1px solid #e4e4e4;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}td.n{white-space:nowrap}
td.n.degree{white-space:normal}td.covered{font-weight:bold}
.place{min-width:9em}.first td{font-size:17px}
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


def html_page(document: Mapping[str, Any], picture: bytes | str | None = None) -> str:
    """The page made from a report document (`Report.as_dict()`, or its JSON read back).

    `picture` is a PNG that is put into the page, or the sentence that says why there is none.
    """
    stents = document["stents"]
    files = ", ".join(str(entry.get("file", "")).split("/")[-1] for entry in document["inputs"])
    surface: Mapping[str, Any] = next(iter(document["inputs"]), {})
    named = [*zip(stent_titles(stents), stents, strict=True)]
    parts = [
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width'>",
        f"<title>Virtual stenting report</title><style>{_STYLE}</style></head><body>",
        "<h1>Virtual stenting report</h1>",
        f"<p class='sub'>{escape(files)} &middot; {escape(in_words(document['created']))}"
        f" &middot; sdfstent {escape(str(document['sdfstent_version']))}</p>",
        f"<p class='notice'>{escape(document['notice'])}</p>",
        # For the clinician: what was done, what came of it, and what to be careful of.
        *_warnings_and_certificate(document),
        *_headline(document["left"]),
        *_picture(picture),
        *_today(document.get("today")),
        *lesion_table(document["lesions"]),
        *(_lumen(document, title, stent) for title, stent in named),
        *branch_table(document["branches"]),
        *apposition_table(document["apposition"]),
        *_flow(document.get("flow")),
        # To check and to repeat it.
        "<div class='details'>",
        *(_stent(title, stent, surface) for title, stent in named),
        *_table("Surface", change_rows, document["changes"]),
        *_table("Method", setting_rows, document["settings"]),
        _inputs(document["inputs"], document["timings"]),
        _definitions(document["definitions"]),
        "</div></body></html>\n",
    ]
    return printable("\n".join(parts))


def _flow(section: Mapping[str, Any] | None) -> list[str]:
    return [] if section is None else ["<h2>Pressure and flow</h2>", *flow_part(section)]


def flow_page(document: Mapping[str, Any]) -> str:
    """The page made from a document of `flow_document`."""
    files = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(str(file))}</td></tr>"
        for name, file in document["inputs"].items()
    )
    body = (
        f"<h1>Flow before and after</h1><p class='notice'>{escape(document['notice'])}</p>"
        f"{''.join(flow_part(document))}"
        f"<h2>Files</h2><table class='file'>{files}</table>"
    )
    return page("Flow before and after", body)


def page(title: str, body: str) -> str:
    """A page of its own in the same style, loading nothing from elsewhere."""
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width'>"
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>{body}</body></html>\n"
    )


def in_words(created: str) -> str:
    """A time of ISO 8601 as one reads it."""
    return created.replace("T", " ").replace("+00:00", " UTC").replace("Z", " UTC")


def certificate_sentence(certificate: Mapping[str, Any] | None) -> tuple[bool, str]:
    """Whether the surface may be used as it is, and the sentence that says so."""
    if not certificate:
        return False, "The deployed surface was not checked."
    return bool(certificate["passed"]), str(certificate["sentence"])


def _lumen(document: Mapping[str, Any], title: str, stent: Mapping[str, Any]) -> str:
    """A stent in one line, its numbers, and its plot: they stay on one sheet."""
    heading = "Lumen" if title == "Stent" else f"{title}, lumen"
    again = stent.get("dilated_again_as")
    plot = diameter_plot(stent["diameters"], stretches_of(document, stent), again)
    return (
        f"<section><h2>{escape(heading)} before and after</h2><p>{escape(stent_words(stent))}</p>"
        f"{first_numbers(stent['diameters'], stent_lesions(document, stent))}"
        f"{svg(plot) if plot else '<p>No diameter could be measured.</p>'}</section>"
    )


def _headline(left: Mapping[str, Any] | None) -> list[str]:
    """What counts most of a treatment: the narrowest place left in the treated vessels."""
    return [] if left is None else [f"<p><b>{LEFT}: {escape(left['words'])}.</b></p>"]


def _warnings_and_certificate(document: Mapping[str, Any]) -> list[str]:
    """That a surface can be meshed stands below the warnings, that it cannot above them."""
    passed, sentence = certificate_sentence(document["certificate"])
    line = f"<p class='{'good' if passed else 'bad'}'>{escape(sentence)}</p>"
    warnings = _warnings(document["warnings"])
    return [*warnings, line] if passed else [line, *warnings]


def _warnings(warnings: Sequence[str]) -> list[str]:
    if not warnings:
        return []
    lines = "".join(f"<p class='warn'>{escape(sentence)}</p>" for sentence in warnings)
    return [f"<h2>Warnings</h2>{lines}"]


def _picture(picture: bytes | str | None) -> list[str]:
    if not picture:
        return []
    if isinstance(picture, str):
        return [f"<p class='small'>This page has no picture of the vessel. {escape(picture)}</p>"]
    data = b64encode(picture).decode("ascii")
    return [f"<img alt='The vessel before and after' src='data:image/png;base64,{data}'>"]


def _today(today: Mapping[str, Any] | None) -> list[str]:
    return [] if today is None else [f"<p>{escape(one)}</p>" for one in today["sentences"]]


def _stent(title: str, stent: Mapping[str, Any], surface: Mapping[str, Any]) -> str:
    return f"<h2>{escape(title)}, as planned</h2>{_rows(stent_rows(stent, surface))}"


def _table(
    title: str,
    rows: Callable[[Mapping[str, Any]], list[tuple[str, str]]],
    values: Mapping[str, Any] | None,
) -> list[str]:
    return [] if values is None else [f"<h2>{title}</h2>{_rows(rows(values), ' small')}"]


def _rows(rows: Iterable[tuple[str, str]], style: str = "") -> str:
    lines = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in rows
    )
    return f"<table class='words{style}'>{lines}</table>"


def _definitions(definitions: Mapping[str, str]) -> str:
    rows = "".join(
        f"<tr><td>{escape(term)}</td><td>{escape(text)}</td></tr>"
        for term, text in definitions.items()
    )
    return f"<h2>Definitions</h2><table class='small'>{rows}</table>"


def _inputs(inputs: Sequence[Mapping[str, Any]], timings: Mapping[str, Any]) -> str:
    tables = "".join(
        f"<h3>{escape(str(entry.get('role', 'file')).capitalize())}</h3>"
        f"{_rows(input_rows(entry), ' small file')}"
        for entry in inputs
    )
    times = ", ".join(
        f"{escape(plain_label(key).lower())} {number_text(value, 2)} s"
        for key, value in timings.items()
    )
    return f"<h2>Input files</h2>{tables}<p class='small'>Time: {times or 'not measured'}.</p>"
