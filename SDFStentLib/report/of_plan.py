"""The report of a plan that was carried out."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

from ..cautions import Caution
from ..plan import PlanResult
from ..treatment import TreatedLesion, TreatedStent, prescribed_diameters
from ..units import MILLIMETERS
from ..validation import check_is_a
from ..version import VERSION
from .changes import change_section, settings_section
from .devices import device_section
from .diameters import StentResult
from .flow import flow_section
from .lesions import residual_section, treated_lesion_section
from .report import Report
from .sizing import diameters_section, redilation_section
from .stents import shape_section, shortening_reason
from .summary import today_section


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
    certificate, units = result.treatment.certificate, result.inputs.surface.units
    judged = None
    if certificate is not None:
        judged = {**certificate.as_dict(), "arrays_kept": not lost}
    return Report(
        inputs=tuple(_inputs(result)),
        stents=tuple(_stent_result(stent, result, units) for stent in result.treatment.stents),
        certificate=judged,
        lesions=None
        if result.lesions is None
        else tuple(treated_lesion_section(one, units) for one in result.lesions),
        left=residual_section(result.residual),
        flow=None if result.flow is None else flow_section(result.flow),
        today=today_section(result.today),
        warnings=tuple(
            caution.sentence(units=units)
            for caution in (*result.warnings, *result.size_warnings, *lost)
        ),
        timings={"read": result.inputs.seconds, **result.treatment.timings, **(timings or {})},
        settings=settings_section(result),
        changes=change_section(result),
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        version=VERSION,
        picture=picture,
    )


def _stent_result(stent: TreatedStent, result: PlanResult, units: str) -> StentResult:
    covered, lesions = None, result.lesions
    if lesions is not None:
        covered = [one for one in lesions if stent.number in one.stents]
    return StentResult(
        description=_description(stent, lesions, units),
        before=stent.before,
        after=stent.after,
        prescribed_diameter=prescribed_diameters(stent.stent, stent.axis, stent.before.arc_length),
        branches=stent.branches,
        neighbors=stent.neighbors,
        apposition=stent.apposition,
        around_before=stent.around_before,
        around_after=stent.around_after,
        lesions=None if covered is None else tuple(one.number for one in covered),
    )


def _description(
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
