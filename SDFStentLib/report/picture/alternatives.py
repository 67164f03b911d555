"""One vessel before treatment and after each of several plans, all seen by one camera."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...plan import PlanResult
from ...treatment import TreatedStent
from ...validation import InputError, check_is_a
from ..words import millimeters
from .drawing import GRAY, INK, Drawing, Mark, Stroke, Words
from .marks import color_limits, color_scale, curve, length_scale, section_marks
from .painting import painted
from .shapes import Lumen, Panel, lumen_of, panel_of, strut_curves, wall_diameters
from .view import BOTTOM, HEIGHT, PANEL_WIDTH, TOP, best_view


def alternatives_picture(results: Mapping[str, PlanResult], *, hides_device: bool = False) -> bytes:
    """A PNG with the vessel before, and a panel for every plan, drawn as `before_after_picture`.

    Parameters
    ----------
    results : mapping of str to PlanResult
        By name: plans for one vessel that were carried out.
    hides_device : bool
        Whether to leave out the struts of the stents.

    Raises
    ------
    InputError
        Something else than such results, or none.
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    drawing, panels = alternatives_scene(results)
    if not hides_device:
        for column, result in enumerate(results.values(), start=1):
            stents = result.treatment.final_stents
            panels[column] = panels[column]._replace(struts=strut_curves(stents))
    return painted(drawing, panels)


def alternatives_scene(results: Mapping[str, PlanResult]) -> tuple[Drawing, list[Panel]]:
    """What `alternatives_picture` paints: all that is flat, and the walls under it."""
    if not results:
        raise InputError("picture: expected at least one plan that was carried out, got none.")
    for name, result in results.items():
        check_is_a(result, PlanResult, name)
    native = next(iter(results.values())).inputs.surface
    groups = [result.treatment.final_stents for result in results.values()]
    stents = [stent for group in groups for stent in group]
    walls = [native.surface, *(result.treatment.surface for result in results.values())]
    cloud = np.concatenate([wall.points for wall in walls])
    radii = [stent.stent.widest_diameter / 2 for stent in stents]
    view = best_view(
        [stent.axis.line for stent in stents],
        max(radii),
        cloud,
        PANEL_WIDTH / (BOTTOM - TOP),
        native.frame,
    )
    shown = [_lumens(stents), *map(_lumens, groups)]
    limits = color_limits(radii, shown[0])
    panels, marks = [], [*_headings(results), *length_scale(view)]
    marks += color_scale(*limits, len(walls) * PANEL_WIDTH / 2)
    marks += [curve(view, stent.axis.points, 0, INK, 2.5) for stent in stents]
    for column, (wall, lumens) in enumerate(zip(walls, shown, strict=True)):
        side = min(column, 1)
        diameters = wall_diameters(wall.points, lumens, side)
        panels.append(panel_of(column, view, wall, diameters, limits))
        told = lumens if column else _apart(lumens)
        marks += section_marks(view, cloud, told, ((column, side),))
    return Drawing(len(walls) * PANEL_WIDTH, HEIGHT, tuple(marks)), panels


def _lumens(stents: Sequence[TreatedStent]) -> list[Lumen]:
    """Of the stents along which something could be measured."""
    return [lumen for lumen in map(lumen_of, stents) if len(lumen.arc_length)]


def _apart(lumens: Sequence[Lumen]) -> list[Lumen]:
    """Without those whose narrowest place is marked already: plans share stretches of vessel."""
    kept: list[Lumen] = []
    for lumen in sorted(lumens, key=lambda one: float(one.diameters[0].min())):
        place = lumen.axis.at([lumen.narrowest])
        near = lumen.diameters.max()
        if all(np.linalg.norm(place - one.axis.at([one.narrowest])) > near for one in kept):
            kept.append(lumen)
    return kept


def _headings(results: Mapping[str, PlanResult]) -> Iterator[Mark]:
    bottom = HEIGHT - 26
    for column, (name, note) in enumerate(
        [("Before", "with the planned stent axes"), *((n, _note(r)) for n, r in results.items())]
    ):
        middle = (column + 0.5) * PANEL_WIDTH
        yield Words(name, middle, 58, 30, is_bold=True)
        yield Words(note, middle, 93, 20, GRAY)
        if column:
            edge = column * PANEL_WIDTH
            yield Stroke([(edge, 40), (edge, BOTTOM)], "#d9dee3", 1.5)
    words = "Research use only. Not for clinical decisions."
    yield Words(words, (len(results) + 1) * PANEL_WIDTH - 20, bottom, 15, GRAY, "end")


def _note(result: PlanResult) -> str:
    """The narrowest place within the stents of a plan, and how many they are."""
    stents = result.treatment.final_stents
    least = np.fmin.reduce([stent.after.minimum for stent in stents])
    number = "1 stent" if len(stents) == 1 else f"{len(stents)} stents"
    lumen = millimeters(float(least), 1) if np.isfinite(least) else millimeters(None)
    return f"{number}, minimum lumen {lumen}"
