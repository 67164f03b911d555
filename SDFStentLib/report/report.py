"""The report of a deployment: one JSON document, from which the page and the figure are made."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

from ..cautions import Caution
from ..files import atomic_path, check_suffix, write_bytes
from ..lumen import REACH
from ..plan import PlanResult
from ..scan import VoxelRange
from ..treatment import lumen_into
from ..validation import as_path, check_is_a
from ..version import VERSION
from ..vessel import SMALLEST_DEGREE
from .branches import branch_facts, stretch_facts
from .changes import change_facts, input_facts, output_list, setting_facts
from .flow import flow_section
from .lesions import residual_facts, treated_lesion_facts
from .segments import voxel_facts
from .stents import stent_facts
from .summary import today_facts
from .views import PlannedViews, planned_views
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
        "tapers; where one side is a junction or an end the other one stands alone"
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
    """Report of a plan that was carried out, as `plan_report` makes it."""

    sections: Mapping[str, Any]
    """Sections by name, as facts and plain values, for documents and pages."""
    picture: bytes | str | None = None
    """Picture of the page: a PNG, or the reason for none in a sentence."""

    def with_outputs(self, files: Mapping[str, str]) -> Report:
        """Report with the files that were written, as seen from its folder, and their SHA-256."""
        return self._replace(sections={**self.sections, "outputs": output_list(files)})

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

        text = html_page(report.sections, report.picture)
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


def plan_report(
    result: PlanResult,
    *,
    lost: tuple[Caution, ...] = (),
    timings: Mapping[str, float] | None = None,
    picture: bytes | str | None = None,
    views: PlannedViews | None = None,
    voxels: VoxelRange | None = None,
    whole_tree: bool = False,
) -> Report:
    """The report, ready to be written as JSON, page and figure.

    Parameters
    ----------
    result : PlanResult
    lost : tuple of Caution
        Cautions of the writers on arrays that an output format cannot keep.
    timings : mapping, optional
        More seconds by name, such as that for writing.
    picture : bytes or str, optional
        For the page: a PNG as of `before_after_picture`, or why there is none.
    views : PlannedViews, optional
        As of `planned_views`, where these are known already.
    voxels : VoxelRange, optional
        Ranges of the result within half a voxel, where these were asked for.
    whole_tree : bool
        Whether it has all lesions of the tree: without, `lesions_of_treated`.

    Raises
    ------
    InputError
        Something else than a result.
    """
    check_is_a(result, PlanResult, "result")
    units = result.inputs.surface.units
    cautions = (*result.warnings, *result.size_warnings, *lost)
    seconds = {"read": result.inputs.seconds, **result.treatment.timings, **(timings or {})}
    sections = {
        "schema": SCHEMA,
        "schema_version": SCHEMA_VERSION,
        "notice": RESEARCH_USE,
        "sdfstent_version": VERSION,
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "inputs": input_facts(result),
        **_lesions(result, units, whole_tree, voxels),
        **_subjects(result, units, arrays_kept=not lost),
        "views": planned_views(result) if views is None else views,
        "warnings": [caution.sentence(units=units) for caution in cautions],
        "settings": setting_facts(result),
        "changes": change_facts(result),
        "timings": {f"{name}_s": taken for name, taken in seconds.items()},
        "definitions": DEFINITIONS,
        "outputs": [],
    }
    return Report(sections, picture)


def _lesions(
    result: PlanResult, units: str, whole_tree: bool, voxels: VoxelRange | None
) -> dict[str, Any]:
    """Facts on lesions and their ranges, and whether these are all of the tree."""
    told = result.lesions if whole_tree else result.told_lesions
    ranges = voxels and voxels.of_lesions(one.number for one in told or ())
    return {
        "lesions": None if told is None else [treated_lesion_facts(one, units) for one in told],
        "whole_tree": whole_tree,
        **({"voxel_range": voxel_facts(ranges)} if ranges else {}),
    }


def _subjects(result: PlanResult, units: str, *, arrays_kept: bool) -> dict[str, Any]:
    """Facts on the result, subject by subject."""
    judged = result.treatment.certificate
    treated, frame = result.told.stents, result.inputs.surface.frame
    stents = [stent_facts(one, result.told_lesions, units, frame) for one in treated]
    return {
        "stents": stents,
        "diameters": stents[0].as_dict()["diameters"],
        "today": result.today and today_facts(result.today),
        "left": result.residual and residual_facts(result.residual),
        "flow": None if result.flow is None else flow_section(result.flow),
        "certificate": judged and {**judged.as_dict(units), "arrays_kept": arrays_kept},
        "branches": [
            branch_facts(stent.number, branch, lumen_into(branch, stent), units)
            for stent in treated
            for branch in stent.branches
        ],
        "apposition": [one for stent in treated for one in stretch_facts(stent)],
    }
