"""The report of a deployment: one JSON document, from which the page and the figure are made."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..files import atomic_path, check_suffix, write_bytes
from ..lumen import REACH
from ..validation import InputError, as_path, check_is_a
from ..vessel import SMALLEST_DEGREE
from .branches import branch_section, free_stretches
from .diameters import StentResult, stent_section
from .words import RESEARCH_USE, document_json, plain

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


@dataclass(frozen=True)
class Report:
    """Everything that is told about a run; `as_dict` gives the document."""

    inputs: tuple[Mapping[str, Any], ...]
    """Per file: file, sha256, points, triangles, units, frame."""
    stents: tuple[StentResult, ...]
    certificate: Any = None
    """A mapping, or an object with `as_dict()`."""
    lesions: tuple[Mapping[str, Any], ...] | None = None
    """Of the vessel, by number; None when none were looked for."""
    left: Mapping[str, Any] | None = None
    """What is narrowest in the treated vessels; None where no stent covers a lesion."""
    flow: Mapping[str, Any] | None = None
    """Pressures and flows before and after; None where no flow is known."""
    today: Mapping[str, Any] | None = None
    """Before a stent is dilated again, where the plan does that later; None where it does not."""
    warnings: tuple[str, ...] = ()
    timings: Mapping[str, float] = field(default_factory=dict)
    """Seconds by name; the document calls them `<name>_s`."""
    settings: Mapping[str, Any] | None = None
    """Parameters of the method, with units in the keys."""
    changes: Mapping[str, Any] | None = None
    """What became of the points and triangles of the surface."""
    created: str = ""
    """Date and time, ISO 8601."""
    version: str = ""
    """Of the program."""
    picture: bytes | str | None = None
    """For the page: a PNG, or the sentence that says why there is none."""

    def as_dict(self) -> dict[str, Any]:
        """The document: plain values only, None where a number is not known.

        Raises
        ------
        InputError
            A value that has no place in JSON.
        """
        stents = [stent_section(stent) for stent in self.stents]
        document = {
            "schema": SCHEMA,
            "schema_version": SCHEMA_VERSION,
            "notice": RESEARCH_USE,
            "sdfstent_version": self.version,
            "created": self.created,
            "inputs": self.inputs,
            "stents": stents,
            "diameters": stents[0]["diameters"] if stents else None,
            "lesions": self.lesions,
            "today": self.today,
            "left": self.left,
            "flow": self.flow,
            "certificate": self.certificate,
            "branches": [
                {
                    "stent": stent.description.get("number", place),
                    **branch_section(branch, stent.neighbors, stent.units),
                }
                for place, stent in enumerate(self.stents, start=1)
                for branch in stent.branches
            ],
            "apposition": [
                {"stent": stent.description.get("number", place), **stretch}
                for place, stent in enumerate(self.stents, start=1)
                for stretch in free_stretches(stent.apposition)
            ],
            "warnings": self.warnings,
            "settings": self.settings,
            "changes": self.changes,
            "timings": {f"{name}_s": seconds for name, seconds in self.timings.items()},
            "definitions": DEFINITIONS,
        }
        return {key: plain(value, key) for key, value in document.items()}


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
        The suffix is another, there is nothing to draw, or the file cannot be written.
    DeploymentError
        A PNG is wanted and nothing here can render; the message names what to install.
    """
    check_suffix(path, "a figure", FIGURE_SUFFIXES)
    if not report.stents:
        raise InputError("figure: expected a report with at least one stent, got none.")
    from .picture.drawing import svg
    from .picture.painting import painted
    from .picture.plot import figure

    drawing = figure(report.as_dict())
    write_bytes(
        path, svg(drawing).encode() if Path(path).suffix.lower() == ".svg" else painted(drawing)
    )
