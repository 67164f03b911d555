"""The picture of working views: angiograms before and after, and the map of all angles."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...files import check_suffix, write_bytes
from ...geometry import Surface
from ...validation import Floats, Points
from ...view import SOURCE, Angiogram, SeenView
from ..picture.drawing import GRAY, INK, Drawing, Mark, Photo, Stroke, Words, shifted, svg
from ..picture.painting import painted
from ..words import RESEARCH_USE
from .facts import ToldViews
from .film import scale_length, shot
from .map import map_height, map_marks

SIDE, GAP, TOP = 440, 24, 84
"""Sizes of a picture, between pictures, and above them, pixels."""

MAP, ROOM = 700, 60
"""Width of the map where it stands alone, and room for its angles beside it, pixels."""

RED = "#cc0d33"


class Look(NamedTuple):
    """Options of an angiogram."""

    source: float | None = SOURCE
    """Distance of the source from the isocenter, mm; None for parallel rays."""
    reach: float | None = None
    """Lumen farther than this from the middle of the stretch is left out, mm."""
    is_subtracted: bool = False
    """Whether gray is linear in the length, as in a subtraction."""


def write_views(
    path: str | os.PathLike[str],
    told: ToldViews,
    walls: Sequence[Surface],
    look: Look = Look(),  # noqa: B008
) -> None:
    """Write `views_drawing` as .png or .svg.

    Raises
    ------
    InputError
        Another suffix, or a file that cannot be written.
    DeploymentError
        A PNG is wanted and nothing here can render; the message names what to install.
    """
    check_suffix(path, "a picture", (".png", ".svg"))
    drawing = views_drawing(told, walls, look)
    is_svg = Path(path).suffix.lower() == ".svg"
    write_bytes(path, svg(drawing).encode() if is_svg else painted(drawing))


def views_drawing(
    told: ToldViews,
    walls: Sequence[Surface],
    look: Look = Look(),  # noqa: B008
    struts: Sequence[Floats] = (),
    views: Sequence[SeenView] | None = None,
) -> Drawing:
    """Angiograms from the chosen views, before and after one below the other, and the map.

    Parameters
    ----------
    told : ToldViews
    walls : sequence of Surface
        The vessel before treatment, and after it where it was treated.
    look : Look
    struts : sequence of (m, p, 3) arrays
        Curves of the stents in the treated vessel, mm.
    views : sequence of SeenView, optional
        Views to draw; by default the best and the second one, and those that were asked for.
    """
    if views is None:
        found = (told.found.best, told.found.second, *told.typed)
        views = [one for one in found if one is not None]
    marks: list[Mark] = []
    for column, seen in enumerate(views):
        left = GAP + column * (SIDE + GAP)
        marks += _headings(seen, left)
        places = [(left, TOP + row * (SIDE + GAP)) for row in range(len(walls))]
        marks += _photos(told, walls, seen, look, struts, places)
    left = GAP + len(views) * (SIDE + GAP) + 46
    marks.append(Words(f"{told.stretch.title}: all views", left, 34, 19, INK, "start", True))
    marks += map_marks(told, left, TOP, SIDE)
    height = TOP + len(walls) * (SIDE + GAP) + GAP
    marks.append(Words(_note(look), GAP, height - 14, 12, GRAY, "start"))
    width = left + SIDE + GAP
    return Drawing(width, height, tuple(marks), f"Working views of {told.stretch.title}")


def seen_drawing(
    told: ToldViews, walls: Sequence[Surface], seen: SeenView, struts: Sequence[Floats]
) -> Drawing:
    """Drawing of before and after, side by side, from one view; arguments as of `views_drawing`."""
    places = [(column * (SIDE + GAP), 0) for column in range(len(walls))]
    marks = _photos(told, walls, seen, Look(), struts, places)
    note = Words(_note(Look()), 0, SIDE + 20, 12, GRAY, "start")
    width = places[-1][0] + SIDE
    title = f"{told.stretch.title}: {seen.view.words}"
    return Drawing(width, SIDE + 28, (*marks, note), title)


def map_drawing(told: ToldViews) -> Drawing:
    """The map of all views alone."""
    marks = map_marks(told, ROOM, 4, MAP)
    height = map_height(told, MAP)
    return Drawing(ROOM + MAP + GAP, height, tuple(marks), f"{told.stretch.title}: all views")


def below_each_other(drawings: Sequence[Drawing]) -> Drawing:
    """Drawings as one."""
    marks: list[Mark] = []
    down = 0
    for one in drawings:
        marks += shifted(one.marks, down)
        down += one.height
    return Drawing(drawings[0].width, down, tuple(marks), drawings[0].title)


def _photos(
    told: ToldViews,
    walls: Sequence[Surface],
    seen: SeenView,
    look: Look,
    struts: Sequence[Floats],
    places: Sequence[tuple[int, int]],
) -> list[Mark]:
    """Angiograms of all walls from one view, each at its place."""
    marks: list[Mark] = []
    stretch, frame, how = told.stretch, told.frame, (look.source, look.reach)
    shots = [shot(stretch, wall, seen.view, frame, *how) for wall in walls]
    # One scale of gray for before and after.
    darkest = max(float(np.nanmax(one.lengths)) for one in shots) or 1.0
    for number, (one, place) in enumerate(zip(shots, places, strict=True)):
        gray = one.gray(darkest=darkest) if look.is_subtracted else one.gray()
        marks.append(Photo(gray, *place, SIDE, SIDE))
        if number:
            marks += _struts(one, struts, place)
        marks += [*_ends(told, one, place), *_scale(one, place)]
        state = ("before", "after")[number] if len(shots) > 1 else ""
        marks.append(Words(state, place[0] + 8, place[1] + 20, 15, INK, "start", is_bold=True))
    return marks


def _note(look: Look) -> str:
    rays = "parallel rays" if look.source is None else f"source {look.source:g} mm from isocenter"
    return (
        f"Simulated from the lumen alone: no table, ribs or motion; {rays}; scale at the "
        f"isocenter. {RESEARCH_USE}"
    )


def _headings(seen: SeenView, left: float) -> Iterator[Mark]:
    over = round(100 * seen.covered)
    told = f"{over} % under other vessels" if over else "nothing over it"
    lost = f"foreshortened {100 * seen.foreshortening:.0f} %"
    yield Words(seen.view.words, left, 34, 23, INK, "start", is_bold=True)
    yield Words(f"{lost}, {told}", left, 62, 15, GRAY, "start")


def _on_paper(made: Angiogram, points: Points, place: tuple[float, float]) -> Floats:
    return np.asarray(np.array(place) + made.pixels(points) * (SIDE / made.beam.size[0]))


def _ends(told: ToldViews, made: Angiogram, place: tuple[float, float]) -> Iterator[Mark]:
    """Two ticks at either end of the stretch, beside its lumen."""
    line, radii = told.stretch.line, told.stretch.radii
    known = radii[np.isfinite(radii)]
    for end, way, radius in (
        (line.points[0], line.directions[0], known[0]),
        (line.points[-1], line.directions[-1], known[-1]),
    ):
        side = np.cross(made.beam.axes[2], way)
        length = np.linalg.norm(side)
        if length == 0:
            continue
        for sign in (-1, 1):
            away = sign * side / length
            tick = np.stack([end + 1.3 * radius * away, end + 2.3 * radius * away])
            yield from _within(_on_paper(made, tick, place), place, RED, 2.0)


def _struts(
    made: Angiogram, struts: Sequence[Floats], place: tuple[float, float]
) -> Iterator[Mark]:
    for curves in struts:
        for curve in curves:
            yield from _within(_on_paper(made, curve, place), place, INK, 0.8)


def _within(
    corners: Floats, place: tuple[float, float], color: str, width: float
) -> Iterator[Mark]:
    """A curve, if it is in the picture as a whole."""
    away = corners - np.array(place)
    if ((away >= 0) & (away <= SIDE)).all():
        yield Stroke([(float(x), float(y)) for x, y in corners], color, width)


def _scale(made: Angiogram, place: tuple[float, float]) -> Iterator[Mark]:
    """Scale bar with its millimeters at the isocenter."""
    per_mm = SIDE / made.beam.size[0] / made.beam.pixel
    nice = scale_length(per_mm, SIDE)
    right, y = place[0] + SIDE - 14, place[1] + SIDE - 14
    left = right - nice * per_mm
    yield Stroke([(left, y), (right, y)], INK, 2.5)
    yield Words(f"{nice} mm", (left + right) / 2, y - 8, 14, INK, is_bold=True)
