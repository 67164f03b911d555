"""The report as one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .branches import apposition_table, branch_table, stretches_of
from .changes import change_rows, setting_rows
from .diameters import first_numbers
from .facts import LEFT
from .flow import flow_part
from .lesions import lesion_table, stent_lesions
from .markup import beginning, heading, page, paragraph, picture, table
from .picture.drawing import svg
from .picture.plot import diameter_plot
from .stents import stent_rows, stent_titles, stent_words
from .words import input_rows, number_text, plain_label

Section = Mapping[str, Any]


def html_page(document: Section, image: bytes | str | None = None) -> str:
    """The page made from a report document (`Report.as_dict()`, or its JSON read back).

    `image` is a PNG that is put into the page, or the sentence that says why there is none.
    """
    stents = document["stents"]
    files = ", ".join(entry["file"].split("/")[-1] for entry in document["inputs"])
    named = [*zip(stent_titles(stents), stents, strict=True)]
    left, today, flow = (document[key] for key in ("left", "today", "flow"))
    title = "Virtual stenting report"
    parts = [
        *beginning(title, document, files),
        # For the clinician: what was done, what came of it, and what to be careful of.
        *_warnings_and_certificate(document),
        *([paragraph(f"{LEFT}: {left['words']}.", "head")] if left else []),
        *_picture(image),
        *map(paragraph, today["sentences"] if today else ()),
        *lesion_table(document["lesions"]),
        *(_lumen(document, title, stent) for title, stent in named),
        *branch_table(document["branches"]),
        *apposition_table(document["apposition"]),
        *([heading("Pressure and flow"), *flow_part(flow)] if flow else []),
        # To check and to repeat it.
        "<div class='details'>",
        *(part for title, stent in named for part in _planned(title, stent, document)),
        heading("Surface"),
        table(change_rows(document["changes"]), look="words small"),
        heading("Method"),
        table(setting_rows(document["settings"]), look="words small"),
        *_inputs(document["inputs"], document["timings"]),
        heading("Definitions"),
        table(document["definitions"].items(), look="small"),
        "</div>",
    ]
    return page(title, parts)


def flow_page(document: Section) -> str:
    """The page made from a document of `flow_document`."""
    title = "Flow before and after"
    parts = [*beginning(title, document), *flow_part(document), *file_part(document["inputs"])]
    return page(title, parts)


def file_part(inputs: Section) -> list[str]:
    """The files by name."""
    rows = [(name, str(file)) for name, file in inputs.items()]
    return [heading("Files"), table(rows, look="file")]


def certificate_sentence(certificate: Section | None) -> tuple[bool, str]:
    """Whether the surface may be used as it is, and the sentence that says so."""
    if not certificate:
        return False, "The deployed surface was not checked."
    return bool(certificate["passed"]), str(certificate["sentence"])


def _lumen(document: Section, title: str, stent: Section) -> str:
    """A stent in one line, its numbers, and its plot: they stay on one sheet."""
    name = "Lumen" if title == "Stent" else f"{title}, lumen"
    again = stent.get("dilated_again_as")
    plot = diameter_plot(stent["diameters"], stretches_of(document, stent), again)
    return (
        f"<section>{heading(f'{name} before and after')}{paragraph(stent_words(stent))}"
        f"{first_numbers(stent['diameters'], stent_lesions(document, stent))}"
        f"{svg(plot) if plot else paragraph('No diameter could be measured.')}</section>"
    )


def _warnings_and_certificate(document: Section) -> list[str]:
    """That a surface can be meshed stands below the warnings, that it cannot above them."""
    passed, sentence = certificate_sentence(document["certificate"])
    line = paragraph(sentence, "good" if passed else "bad")
    warnings = [paragraph(one, "warn") for one in document["warnings"]]
    if warnings:
        warnings.insert(0, heading("Warnings"))
    return [*warnings, line] if passed else [line, *warnings]


def _picture(image: bytes | str | None) -> list[str]:
    if not image:
        return []
    if isinstance(image, str):
        return [paragraph(f"This page has no picture of the vessel. {image}", "small")]
    return [picture(image, "The vessel before and after")]


def _planned(title: str, stent: Section, document: Section) -> list[str]:
    rows = stent_rows(stent, document["inputs"][0])
    return [heading(f"{title}, as planned"), table(rows, look="words")]


def _inputs(inputs: Sequence[Section], timings: Section) -> list[str]:
    parts = [heading("Input files")]
    for entry in inputs:
        parts += [heading(entry["role"].capitalize(), 3)]
        parts += [table(input_rows(entry), look="words small file")]
    times = ", ".join(
        f"{plain_label(key).lower()} {number_text(value, 2)} s" for key, value in timings.items()
    )
    return [*parts, paragraph(f"Time: {times}.", "small")]
