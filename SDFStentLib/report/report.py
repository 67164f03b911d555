"""The report of a deployment: one JSON document, from which the page and the figure are made."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..files import atomic_path, check_suffix, write_bytes
from ..lumen import REACH
from ..validation import as_path, check_is_a
from ..vessel import SMALLEST_DEGREE
from .words import document_json, plain

SCHEMA = "sdfstent-report"
SCHEMA_VERSION = 1
FIGURE_SUFFIXES = (".png", ".svg")

DEFINITIONS = {
    "inscribed diameter": (
        "diameter of the largest sphere that fits into the lumen, its center free in the plane "
        "across the stent axis (maximum inscribed sphere, MIS); flat caps of in- and outlets count "
        "as open"
    ),
    "equivalent diameter": (
        "diameter of the circle with the area of the lumen's cross-section in that plane, "
        "2 sqrt(area / pi); at an ostium the section is cut at the wall that would be there"
    ),
    "prescribed diameter": "lumen diameter that the stent was set to reach at that place",
    "minimum lumen diameter": (
        "smallest inscribed diameter over the stented length (MLD), at stations at most 1 mm "
        "apart; that of a lesion is looked for between stations, too"
    ),
    "beyond the ends": (
        f"of the stent: up to {REACH:.0f} mm along the vessel on either side, as far as it goes"
    ),
    "lesion": (
        f"part of the vessel that is at least {100 * SMALLEST_DEGREE:.0f} % narrower than the "
        "healthy vessel beside it; found before treatment, and the same whatever stent is tried"
    ),
    "reference": (
        "healthy vessel proximal and distal of the lesion, before treatment; between the two it "
        "tapers; where one side is a junction the other one stands alone"
    ),
    "percent diameter stenosis": (
        "100 (1 - smallest inscribed diameter of the lesion / that of the reference at that place)"
    ),
    "percent area stenosis": (
        "100 (1 - smallest cross-section area of the lesion / that of the reference at that "
        "place); 50 % by diameter are 75 % by area in a round lumen"
    ),
    "SD": "standard deviation over the stations, which are equally spaced along the axis",
}


class Report(NamedTuple):
    """What is told of a plan that was carried out, as `plan_report` makes it."""

    sections: Mapping[str, Any]
    """Of the document, by name."""
    picture: bytes | str | None = None
    """For the page: a PNG, or the sentence that says why there is none."""

    def as_dict(self) -> dict[str, Any]:
        """The document: plain values only, None where a number is not known.

        Raises
        ------
        InputError
            A value that has no place in JSON.
        """
        return {key: plain(value, key) for key, value in self.sections.items()}


def write_report(report: Report, path: str | os.PathLike[str]) -> None:
    """Write the report to `path`: JSON or HTML by its suffix, whole or not at all.

    Raises
    ------
    InputError
        No report, another suffix than .json, .html and .htm, or a file that cannot be written.
    """
    check_is_a(report, Report, "report")
    check_suffix(as_path(path), "a report", (".json", ".html", ".htm"))
    if Path(path).suffix.lower() == ".json":
        text = document_json(report.as_dict())
    else:
        # Late, as below: a document needs neither the page nor the drawing.
        from .html import html_page

        text = html_page(report.as_dict(), report.picture)
    with atomic_path(path) as temporary:
        # The name of a file need not be valid text; JSON reads the escape back.
        temporary.write_text(text, encoding="utf-8", errors="backslashreplace")


def write_report_figure(report: Report, path: str | os.PathLike[str]) -> None:
    """Draw the diameters along each stent to an SVG or PNG file.

    Raises
    ------
    InputError
        The suffix is another, or the file cannot be written.
    DeploymentError
        A PNG is wanted and nothing here can render; the message names what to install.
    """
    check_suffix(path, "a figure", FIGURE_SUFFIXES)
    from .picture.drawing import svg
    from .picture.painting import painted
    from .picture.plot import figure

    drawing = figure(report.as_dict())
    write_bytes(
        path, svg(drawing).encode() if Path(path).suffix.lower() == ".svg" else painted(drawing)
    )
