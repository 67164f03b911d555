"""The report of a plan that was carried out."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

from ..cautions import Caution
from ..plan import PlanResult
from ..treatment import TreatedLesion, TreatedStent
from ..units import MILLIMETERS
from ..validation import check_is_a
from ..version import VERSION
from .branches import branch_section, free_stretches
from .changes import change_section, settings_section
from .devices import device_section
from .diameters import stent_diameters
from .flow import flow_section
from .lesions import residual_section, treated_lesion_section
from .report import DEFINITIONS, SCHEMA, SCHEMA_VERSION, Report
from .sizing import diameters_section, redilation_section
from .stents import shape_section, shortening_reason
from .summary import today_section
from .words import RESEARCH_USE


def plan_report(
    result: PlanResult,
    *,
    lost: tuple[Caution, ...] = (),
    timings: Mapping[str, float] | None = None,
    picture: bytes | str | None = None,
) -> Report:
    """The report, ready to be written as JSON, page and figure.

    Parameters
    ----------
    result : PlanResult
    lost : tuple of Caution
        What the writers say of arrays that an output format cannot keep.
    timings : mapping, optional
        More seconds by name, such as that for writing.
    picture : bytes or str, optional
        For the page: a PNG as of `before_after_picture`, or why there is none.

    Raises
    ------
    InputError
        Something else than a result.
    """
    check_is_a(result, PlanResult, "result")
    treatment, units = result.treatment, result.inputs.surface.units
    judged = None
    if treatment.certificate is not None:
        judged = {**treatment.certificate.as_dict(), "arrays_kept": not lost}
    stents = [_stent_section(stent, result.lesions, units) for stent in treatment.stents]
    seconds = {"read": result.inputs.seconds, **treatment.timings, **(timings or {})}
    sections = {
        "schema": SCHEMA,
        "schema_version": SCHEMA_VERSION,
        "notice": RESEARCH_USE,
        "sdfstent_version": VERSION,
        "created": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "inputs": _inputs(result),
        "stents": stents,
        "diameters": stents[0]["diameters"],
        "lesions": result.lesions
        and [treated_lesion_section(one, units) for one in result.lesions],
        "today": today_section(result.today),
        "left": residual_section(result.residual),
        "flow": None if result.flow is None else flow_section(result.flow),
        "certificate": judged,
        "branches": [
            {"stent": stent.number, **branch_section(branch, stent.neighbors, units)}
            for stent in treatment.stents
            for branch in stent.branches
        ],
        "apposition": [
            {"stent": stent.number, **stretch}
            for stent in treatment.stents
            for stretch in free_stretches(stent.apposition)
        ],
        "warnings": [
            caution.sentence(units=units)
            for caution in (*result.warnings, *result.size_warnings, *lost)
        ],
        "settings": settings_section(result),
        "changes": change_section(result),
        "timings": {f"{name}_s": taken for name, taken in seconds.items()},
        "definitions": DEFINITIONS,
    }
    return Report(sections, picture)


def _stent_section(
    stent: TreatedStent, lesions: Sequence[TreatedLesion] | None, units: str
) -> dict[str, Any]:
    chosen, axis = stent.stent, stent.axis
    name = {"name": chosen.name} if chosen.name else {}
    return {
        "number": stent.number,
        **name,
        "device": device_section(chosen.device),
        **redilation_section(chosen, stent.again),
        **diameters_section(stent, lesions),
        "shape": shape_section(stent),
        "nominal_length_mm": axis.nominal_length,
        "deployed_length_mm": axis.deployed_length,
        "foreshortening_fraction": chosen.foreshortening,
        "foreshortening_reason": shortening_reason(chosen),
        "placement": type(chosen.placement).__name__,
        "axis": {
            "start_mm": axis.points[0],
            "end_mm": axis.points[-1],
            # As in the file, to find them there.
            "start": axis.points[0] / MILLIMETERS[units],
            "end": axis.points[-1] / MILLIMETERS[units],
            "units": units,
            "length_mm": axis.deployed_length,
            "chord_mm": axis.chord,
            "min_bend_radius_mm": axis.minimum_bend_radius(chosen.radius),
        },
        "moved_points": stent.moved_points,
        "lesions": lesions and [one.number for one in lesions if stent.number in one.stents],
        "diameters": stent_diameters(stent),
    }


def _inputs(result: PlanResult) -> list[dict[str, Any]]:
    surface, line_file = result.inputs.surface, result.inputs.line_file
    found: list[dict[str, Any]] = [
        {
            "role": "surface",
            "file": os.fspath(surface.path),
            "sha256": surface.sha256,
            "points": len(surface.points),
            "triangles": len(surface.triangles),
            "units": surface.units,
            "frame": surface.frame,
        }
    ]
    if line_file is not None:
        found.append(
            {
                "role": "centerline",
                "file": os.fspath(line_file.path),
                "sha256": line_file.sha256,
                "points": len(line_file.points),
                "lines": len(line_file.lines),
                "units": line_file.units,
                "frame": line_file.file_frame,
                "root_mm": result.inputs.vessel.root,
            }
        )
    for stent in result.plan.stents:
        if (file := stent.axis_file) is not None:
            found.append({"role": "axis", "file": file.path, "sha256": file.sha256})
    return found
