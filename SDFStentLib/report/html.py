"""The report as one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .branches import apposition_table, branch_table
from .diameters import ERROR
from .facts import LEVELS, LINES, Facts
from .flow import flow_part
from .lesions import LEFT, covered_words, lesion_table, stent_lesions
from .markup import beginning, heading, page, paragraph, picture, table
from .picture.drawing import svg
from .picture.plot import stent_plot
from .stents import stent_titles
from .views import views_part
from .words import number_text, plain, plain_label

Section = Mapping[str, Any]


def html_page(sections: Section, image: bytes | str | None = None) -> str:
    """The page made from the sections of a report.

    `image` is a PNG that is put into the page, or the sentence that says why there is none.
    """
    stents, lesions = sections["stents"], sections["lesions"]
    document = plain(sections)
    files = ", ".join(entry["file"].split("/")[-1] for entry in document["inputs"])
    named = [*zip(stent_titles(document["stents"]), stents, strict=True)]
    left, today, flow = (document[key] for key in ("left", "today", "flow"))
    title = "Virtual stenting report"
    parts = [
        *beginning(title, document, files),
        # For the clinician: what was done, what came of it, and what to be careful of.
        *_warnings_and_certificate(document),
        *([paragraph(f"{LEFT}: {left['words']}.", "head")] if left else []),
        *_picture(image),
        *map(paragraph, today["sentences"] if today else ()),
        *lesion_table(lesions, whole_tree=sections["whole_tree"]),
        *map(paragraph, document.get("voxel_range", {}).get("sentences", ())),
        *(_lumen(document, lesions, title, stent) for title, stent in named),
        *branch_table(sections["branches"]),
        *apposition_table(sections["apposition"]),
        *views_part(sections["views"]),
        *([heading("Pressure and flow"), *flow_part(flow)] if flow else []),
        # To check and to repeat it.
        "<div class='details'>",
        *(part for title, stent in named for part in _planned(title, stent)),
        heading("Surface"),
        table(sections["changes"].rows(), look="words small"),
        heading("Method"),
        table(sections["settings"].rows(), look="words small"),
        *_inputs(sections["inputs"], document["timings"]),
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
    """Verdict on the surface's use as it is, and the sentence for it."""
    if not certificate:
        return False, "The deployed surface was not checked."
    return bool(certificate["passed"]), str(certificate["sentence"])


def _lumen(document: Section, lesions: Sequence[Facts] | None, title: str, stent: Facts) -> str:
    """A stent in one line, its numbers, and its plot: they stay on one sheet."""
    name = "Lumen" if title == "Stent" else f"{title}, lumen"
    values = plain(stent)
    covered = stent_lesions(lesions, values)
    plot = stent_plot(document, values)
    degrees = (row for one in covered or () for row in one.changes())
    rows = [*stent.changes(LEVELS[:LINES]), *degrees, *stent.changes(LEVELS[LINES:])]
    head = ("over the stented length", "before", "after")
    parts = [
        heading(f"{name} before and after"),
        paragraph(stent.named("_whole").words),
        table(rows, head, ("", "n", "n"), row_look="first"),
        paragraph(stent.named(ERROR).words, "small"),
        paragraph(covered_words(covered), "small"),
        svg(plot) if plot else paragraph("No diameter could be measured."),
    ]
    return f"<section>{''.join(parts)}</section>"


def _warnings_and_certificate(document: Section) -> list[str]:
    """Warnings and certificate: that a surface can be meshed stands below the warnings, that it
    cannot above them.
    """
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


def _planned(title: str, stent: Facts) -> list[str]:
    return [heading(f"{title}, as planned"), table(stent.rows(), look="words")]


def _inputs(inputs: Sequence[Facts], timings: Section) -> list[str]:
    parts = [heading("Input files")]
    for one in inputs:
        parts += [heading(one.value("role").capitalize(), 3)]
        parts += [table(one.rows(), look="words small file")]
    times = ", ".join(
        f"{plain_label(key).lower()} {number_text(value, 2)} s" for key, value in timings.items()
    )
    return [*parts, paragraph(f"Time: {times}.", "small")]
