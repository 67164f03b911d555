"""Pictures for the heart-team meeting: the vessel before and after plans, by one camera."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import Surface
from ...plan import PlanResult
from ...treatment import TreatedStent
from ...units import Frame
from ...validation import InputError, Points, check_is_a
from ..words import millimeters
from .drawing import GRAY, INK, Box, Drawing, Mark, Stroke, Words
from .painting import painted
from .shapes import (
    Lumen,
    Panel,
    diameter_colors,
    lumen_of,
    panel_of,
    section_ring,
    strut_curves,
    wall_diameters,
)
from .view import BOTTOM, HEIGHT, PANEL_WIDTH, TOP, WIDTH, Viewpoint, best_view, label_side

LABEL = np.array([90.0, 28.0])
"""Width and height of the label with a diameter, pixels."""

RED = "#cc0d33"


def color_limits(radii: Sequence[float], lumens: Sequence[Lumen]) -> tuple[float, float]:
    """Ends of the color scale: half millimeters around all diameters there are."""
    values = np.concatenate([2 * np.array(radii), *(one.diameters.ravel() for one in lumens)])
    # What is printed as 6.0 mm does not push the scale to 6.5.
    lower = np.floor(2 * values.min() + 0.1) / 2
    return float(lower), float(max(np.ceil(2 * values.max() - 0.1) / 2, lower + 0.5))


def length_scale(view: Viewpoint) -> Iterator[Mark]:
    """Scale bar with its millimeters, at the left under the first panel."""
    steps = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
    nice = max(step for step in steps if step <= max(190 / view.per_mm, 0.5))
    left, right, y = 60, 60 + nice * view.per_mm, 654
    yield Stroke([(left, y), (right, y)], width=2.5)
    yield from (Stroke([(x, y - 7), (x, y + 7)], width=2.5) for x in (left, right))
    yield Words(f"{nice:g} mm", (left + right) / 2, 683, 16)


def color_scale(lower: float, upper: float, middle: float) -> Iterator[Mark]:
    """Color scale of the diameters, mm, around `middle`."""
    width, y, colors = 384, 644, 96
    left = middle - width / 2
    for number, color in enumerate(diameter_colors((np.arange(colors) + 0.5) / colors)):
        code = "#" + bytes((255 * color).astype(int).tolist()).hex()
        yield Box(left + width * number / colors, y, width / colors, 20, code)
    halves = round(2 * (upper - lower))
    every = next(each for each in (1, 2, 4, 10, 20, 50, 100) if halves / each <= 7)
    for tick in range(0, halves + 1, every):
        x = left + width * tick / halves
        yield Stroke([(x, y + 20), (x, y + 26)], width=1.5)
        yield Words(f"{lower + tick / 2:g}", x, 686, 14)
    yield Words("Lumen diameter (mm)", middle, 637, 15)


def section_marks(
    view: Viewpoint, cloud: Points, lumens: Sequence[Lumen], shown: Iterable[tuple[int, int]]
) -> Iterator[Mark]:
    """Rings where lumens were narrowest, and the diameters beside them.

    `shown` are the panels by their column, with 0 for the diameters before and 1 for those after;
    the labels lie alike in all of them.
    """
    covered, panels, labels = view.pixels(cloud), tuple(shown), np.empty((0, 2))
    for lumen in lumens:
        values = lumen.at(lumen.narrowest)
        center = view.pixels(lumen.axis.at([lumen.narrowest]))[0]
        gap = 0.7 * view.per_mm * lumen.diameters.max()
        away = label_side(covered, center, gap, LABEL, labels)
        leader = away * (1 - np.min(LABEL / 2 / np.maximum(np.abs(away), 1e-9)))
        labels = np.vstack([labels, center + away])
        for column, side in panels:
            yield curve(view, section_ring(lumen, side), column, RED, 2.5)
            start = center + np.array([column * PANEL_WIDTH, 0])
            yield Stroke([tuple(start), tuple(start + leader)], RED, 1.5)
            x, y = start + away
            yield Words(f"{values[side]:.1f} mm", x, y + 6, 18, RED, is_bold=True)


def curve(view: Viewpoint, points: Points, column: int, color: str, width: float) -> Stroke:
    """Curve on the vessel in the panel of a column, over the wall."""
    corners = view.pixels(points) + np.array([column * PANEL_WIDTH, 0])
    return Stroke([(float(x), float(y)) for x, y in corners], color, width)


def before_after_picture(
    result: PlanResult, title: str = "", *, hides_device: bool = False
) -> bytes:
    """A PNG with two panels, before and after, seen by the same camera.

    The stented wall is colored by the local lumen diameter, the rest is drawn like glass in a
    tissue color; rings mark where each stent was narrowest.

    Parameters
    ----------
    result : PlanResult
        A plan that was carried out.
    title : str
        A line on top, such as the patient's pseudonym.
    hides_device : bool
        Whether to leave out the struts of the stents, which are of no product's design.

    Raises
    ------
    InputError
        Something else than such a result.
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    check_is_a(result, PlanResult, "result")
    drawing, panels = before_after_scene(result, title)
    if not hides_device:
        panels[1] = panels[1]._replace(struts=strut_curves(result.told.final_stents))
    return painted(drawing, panels)


def before_after_scene(result: PlanResult, title: str) -> tuple[Drawing, list[Panel]]:
    """Scene of `before_after_picture`: all that is flat, and the walls under it."""
    surface, stents = result.inputs.surface, result.told.final_stents
    lumens = _lumens(stents)
    scene = _scene(
        [surface.surface, result.treatment.surface], [lumens, lumens], stents, surface.frame
    )
    marks = [*_sides(stents, title), *scene.marks]
    marks += section_marks(scene.view, scene.cloud, lumens, ((0, 0), (1, 1)))
    return Drawing(WIDTH, HEIGHT, tuple(marks), title), scene.panels


class _Scene(NamedTuple):
    """Common parts of pictures of a vessel before treatment and after."""

    view: Viewpoint
    cloud: Points
    panels: list[Panel]
    marks: list[Mark]


def _scene(
    walls: Sequence[Surface],
    shown: Sequence[Sequence[Lumen]],
    stents: Sequence[TreatedStent],
    frame: Frame | None,
) -> _Scene:
    """A panel for every wall, the first of them before treatment, with all of the lumens."""
    cloud = np.concatenate([wall.points for wall in walls])
    radii = [stent.stent.widest_diameter / 2 for stent in stents]
    axes = [stent.axis.line for stent in stents]
    view = best_view(axes, max(radii), cloud, PANEL_WIDTH / (BOTTOM - TOP), frame)
    limits = color_limits(radii, shown[0])
    panels = [
        panel_of(column, view, wall, wall_diameters(wall.points, lumens, min(column, 1)), limits)
        for column, (wall, lumens) in enumerate(zip(walls, shown, strict=True))
    ]
    marks = [*length_scale(view), *color_scale(*limits, len(walls) * PANEL_WIDTH / 2)]
    marks += [curve(view, stent.axis.points, 0, INK, 2.5) for stent in stents]
    return _Scene(view, cloud, panels, marks)


def _sides(stents: Sequence[TreatedStent], title: str) -> Iterator[Mark]:
    sizes = [f"{one.stent.diameter:.1f} x {one.axis.deployed_length:.0f} mm" for one in stents]
    many = f"stent{'s' * (len(stents) > 1)} {' and '.join(sizes)}"
    notes = "with the planned stent axis", many if len(stents) <= 3 else f"{len(stents)} stents"
    narrowest = [one.before.minimum for one in stents], [one.after.minimum for one in stents]
    yield Words(title, WIDTH / 2, 28, 17)
    for side, (note, values) in enumerate(zip(notes, narrowest, strict=True)):
        middle, least = (side + 0.5) * WIDTH / 2, np.fmin.reduce(values)
        minimum = f"{least:.1f} mm" if np.isfinite(least) else "not known"
        heading = f"{('Before', 'After')[side]}: minimum lumen {minimum}"
        yield Words(heading, middle, 65, 23, is_bold=True)
        yield Words(note, middle, 93, 15, GRAY)
    yield Stroke([(WIDTH / 2, 50), (WIDTH / 2, BOTTOM)], "#d9dee3", 1.5)
    yield Words("Research use only. Not for clinical decisions.", 984, 674, 12, GRAY)


def alternatives_picture(results: Mapping[str, PlanResult], *, hides_device: bool = False) -> bytes:
    """A PNG with the vessel before, and a panel for every plan, drawn as `before_after_picture`.

    Parameters
    ----------
    results : mapping of str to PlanResult
        Results by name: plans for one vessel that were carried out.
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
            stents = result.told.final_stents
            panels[column] = panels[column]._replace(struts=strut_curves(stents))
    return painted(drawing, panels)


def alternatives_scene(results: Mapping[str, PlanResult]) -> tuple[Drawing, list[Panel]]:
    """Scene of `alternatives_picture`: all that is flat, and the walls under it."""
    if not results:
        raise InputError("picture: expected at least one plan that was carried out, got none.")
    for name, result in results.items():
        check_is_a(result, PlanResult, name)
    native = next(iter(results.values())).inputs.surface
    groups = [result.told.final_stents for result in results.values()]
    stents = [stent for group in groups for stent in group]
    walls = [native.surface, *(result.treatment.surface for result in results.values())]
    shown = [_lumens(stents), *map(_lumens, groups)]
    scene = _scene(walls, shown, stents, native.frame)
    marks = [*_headings(results), *scene.marks]
    for column, lumens in enumerate(shown):
        told = lumens if column else _apart(lumens)
        marks += section_marks(scene.view, scene.cloud, told, ((column, min(column, 1)),))
    return Drawing(len(walls) * PANEL_WIDTH, HEIGHT, tuple(marks)), scene.panels


def _lumens(stents: Sequence[TreatedStent]) -> list[Lumen]:
    """Lumens of the stents along which something could be measured."""
    return [lumen for lumen in map(lumen_of, stents) if len(lumen.arc_length)]


def _apart(lumens: Sequence[Lumen]) -> list[Lumen]:
    """Marks without repeats: plans share stretches of vessel."""
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
    stents = result.told.final_stents
    least = np.fmin.reduce([stent.after.minimum for stent in stents])
    number = "1 stent" if len(stents) == 1 else f"{len(stents)} stents"
    lumen = millimeters(float(least), 1) if np.isfinite(least) else millimeters(None)
    return f"{number}, minimum lumen {lumen}"
