"""The angiogram of a plan that was carried out: its first stent, before and after."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ...files import check_suffix, write_bytes
from ...plan import PlanResult
from ...validation import InputError, check_is_a
from ...view import APART, arm_limits
from ..picture.drawing import svg
from ..picture.painting import painted
from ..picture.shapes import strut_curves
from .facts import Stretch, ToldViews, told_views
from .picture import views_drawing


def planned_stretch(result: PlanResult) -> Stretch:
    """The first stent, with the tightest lesion that it covers."""
    stents = result.told.final_stents
    if not stents:
        raise InputError("angiogram: expected a plan with a stent, got one without.")
    first = stents[0]
    line, half = first.axis.line, first.stent.diameter / 2
    title, radii = f"Stent {first.number}", np.full(len(line), half)
    for treated in result.lesions or ():
        if first.number in treated.stents:
            return Stretch(title, line, radii, line.length, treated.before, treated.after)
    return Stretch(title, line, radii, line.length)


def planned_views(result: PlanResult) -> ToldViews:
    """The views of its first stent, with the usual limits of the arm; errors as of `told_views`."""
    check_is_a(result, PlanResult, "result")
    frame = result.inputs.frame
    return told_views(planned_stretch(result), result.vessel, frame, arm_limits(), APART)


def write_angiogram(
    result: PlanResult, path: str | os.PathLike[str], *, hides_device: bool = False
) -> None:
    """Draw the first stent of a plan from its best view, before and after, to .png or .svg.

    Raises
    ------
    InputError
        Another suffix, a file that cannot be written; no frame, centerline or stent.
    DeploymentError
        A PNG is wanted and nothing here can render; the message names what to install.
    """
    check_suffix(path, "an angiogram", (".png", ".svg"))
    told = planned_views(result)
    walls = [result.inputs.surface.surface, result.treatment.surface]
    struts = () if hides_device else strut_curves(result.told.final_stents)
    drawing = views_drawing(told, walls, struts=struts, views=[told.found.best])
    is_svg = Path(path).suffix.lower() == ".svg"
    write_bytes(path, svg(drawing).encode() if is_svg else painted(drawing))
