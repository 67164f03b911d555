"""A picture for the heart-team meeting: the vessel before and after, seen by one camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import point_at
from ...measure import DiameterProfile
from ...plan import PlanResult
from ...treatment import TreatedStent
from ...validation import Floats, Points, check_is_a
from ..drawing import GRAY, INK, Box, Drawing, Line, Mark, Words
from .process import painted
from .shapes import (
    Bars,
    Lumen,
    Panel,
    Wall,
    diameter_colors,
    section_ring,
    stent_lattice,
    wall_colors,
)
from .view import View, best_view, label_side

WIDTH, HEIGHT = 1200, 700
"""Of the picture, pixels."""

TOP, BOTTOM = 105, 602
"""Rows between which the vessel is; words are above, scales below."""

LABEL = np.array([90.0, 28.0])
"""Width and height of the label with a diameter, pixels."""

STEEL, RED = "#4d5766", "#cc0d33"


def before_after_picture(result: PlanResult, title: str = "") -> bytes:
    """A PNG with two panels, before and after, seen by the same camera.

    The stented wall is colored by the local lumen diameter, the rest is drawn like glass in a
    tissue color; a stent is a lattice of diamonds; rings mark where each was narrowest.

    Parameters
    ----------
    result : PlanResult
        A plan that was carried out.
    title : str
        A line on top, such as the patient's pseudonym.

    Raises
    ------
    InputError
        Something else than such a result.
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    check_is_a(result, PlanResult, "result")
    drawing, panels = before_after_scene(result, title)
    return painted(drawing, panels)


class _Moment(NamedTuple):
    """The vessel before or after: its points and the lumen along every stent."""

    points: Points
    lumens: list[Lumen]

    @property
    def minimum(self) -> str:
        values = np.concatenate([lumen.diameter for lumen in self.lumens])
        return f"{values.min():.1f} mm" if len(values) else "not known"


def before_after_scene(result: PlanResult, title: str) -> tuple[Drawing, list[Panel]]:
    """What `before_after_picture` paints: words and scales, and the panels under them."""
    stents, surface = result.treatment.stents, result.inputs.surface
    moments = [
        _Moment(surface.points, [_lumen(stent, stent.before) for stent in stents]),
        _Moment(result.treatment.points, [_lumen(stent, stent.after) for stent in stents]),
    ]
    cloud = np.concatenate([moment.points for moment in moments])
    axes = [stent.axis.points for stent in stents]
    radius = max(stent.stent.radius for stent in stents)
    view = best_view(axes, radius, cloud, WIDTH / 2 / (BOTTOM - TOP), surface.frame)
    limits = _limits(stents, moments)
    places = [_narrowest(lumen) for lumen in moments[0].lumens]
    marks = [*_headings(stents, moments, title), *_scales(view, limits)]
    marks += _labels(view, moments, places)
    panels = []
    for number, moment in enumerate(moments):
        known = [lumen for lumen in moment.lumens if len(lumen.diameter)]
        colors = wall_colors(moment.points, surface.triangles, view, known, limits)
        rings = _rings(moment, places, 0.045 * radius)
        steel = [
            Bars(stent_lattice(stent.axis.points, 1.06 * stent.stent.radius), 0.032 * radius, STEEL)
            for stent in stents
        ]
        lines = [Bars(axis[None], 0.042 * radius, INK) for axis in axes]
        panels.append(
            Panel(
                (number / 2, 1 - BOTTOM / HEIGHT, (number + 1) / 2, 1 - TOP / HEIGHT),
                view,
                Wall(moment.points, surface.triangles, colors),
                (*rings, *(steel if number else lines)),
            )
        )
    return Drawing(WIDTH, HEIGHT, tuple(marks), title), panels


def _lumen(stent: TreatedStent, profile: DiameterProfile) -> Lumen:
    known = np.isfinite(profile.inscribed_diameter)
    diameter = profile.inscribed_diameter[known]
    widest = max(stent.stent.diameter, *diameter) if known.any() else 0.0
    return Lumen(stent.axis.points, profile.arc_length[known], diameter, 1.15 * widest / 2)


def _limits(stents: Sequence[TreatedStent], moments: Sequence[_Moment]) -> tuple[float, float]:
    """Ends of the color scale: half millimeters around all diameters there are."""
    values = [stent.stent.diameter for stent in stents]
    values += [value for moment in moments for lumen in moment.lumens for value in lumen.diameter]
    # What is printed as 6.0 mm does not push the scale to 6.5.
    lower = np.floor(2 * min(values) + 0.1) / 2
    return float(lower), float(max(np.ceil(2 * max(values) - 0.1) / 2, lower + 0.5))


def _narrowest(lumen: Lumen) -> float | None:
    """Where a stent's lumen is narrowest; None where nothing is known."""
    if not len(lumen.diameter):
        return None
    return float(lumen.arc_length[np.argmin(lumen.diameter)])


def _rings(moment: _Moment, places: Sequence[float | None], width: float) -> Iterator[Bars]:
    for lumen, place in zip(moment.lumens, places, strict=True):
        if place is not None and len(lumen.diameter):
            across = np.interp(place, lumen.arc_length, lumen.diameter)
            yield Bars(section_ring(lumen.axis, place, across / 2)[None], width, RED)


def _headings(
    stents: Sequence[TreatedStent], moments: Sequence[_Moment], title: str
) -> Iterator[Mark]:
    sizes = [f"{one.stent.diameter:.1f} x {one.axis.deployed_length:.0f} mm" for one in stents]
    many = f"{len(stents)} stents"
    if len(stents) <= 3:
        many = ("stent " if len(stents) == 1 else "stents ") + " and ".join(sizes)
    notes = ("with the planned stent axis", many)
    yield Words(title, WIDTH / 2, 28, 17)
    for number, (moment, note) in enumerate(zip(moments, notes, strict=True)):
        middle = (number + 0.5) * WIDTH / 2
        heading = f"{('Before', 'After')[number]}: minimum lumen {moment.minimum}"
        yield Words(heading, middle, 65, 23, is_bold=True)
        yield Words(note, middle, 93, 15, GRAY)
    yield Line([(WIDTH / 2, 50), (WIDTH / 2, BOTTOM)], "#d9dee3", 1.5)
    yield Words("Research use only. Not for clinical decisions.", 984, 674, 12, GRAY)


def _scales(view: View, limits: tuple[float, float]) -> Iterator[Mark]:
    per_mm = (BOTTOM - TOP) / 2 / view.half_height
    steps = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
    nice = max(step for step in steps if step <= max(190 / per_mm, 0.5))
    left, right, y = 60, 60 + nice * per_mm, 654
    yield Line([(left, y), (right, y)], width=2.5)
    yield from (Line([(x, y - 7), (x, y + 7)], width=2.5) for x in (left, right))
    yield Words(f"{nice:g} mm", (left + right) / 2, 683, 16)

    lower, upper = limits
    left, width, y, colors = 408, 384, 644, 96
    for number, color in enumerate(diameter_colors((np.arange(colors) + 0.5) / colors)):
        code = "#" + bytes((255 * color).astype(int).tolist()).hex()
        yield Box(left + width * number / colors, y, width / colors, 20, code)
    halves = round(2 * (upper - lower))
    every = next(each for each in (1, 2, 4, 10, 20, 50, 100) if halves / each <= 7)
    for tick in range(0, halves + 1, every):
        x = left + width * tick / halves
        yield Line([(x, y + 20), (x, y + 26)], width=1.5)
        yield Words(f"{lower + tick / 2:g}", x, 686, 14)
    yield Words("Lumen diameter (mm)", WIDTH / 2, 637, 15)


def _labels(
    view: View, moments: Sequence[_Moment], places: Sequence[float | None]
) -> Iterator[Mark]:
    """The diameter at every marked section beside it, at the same place in both panels."""
    per_mm = (BOTTOM - TOP) / 2 / view.half_height
    middle = np.array([WIDTH / 4, (TOP + BOTTOM) / 2])

    def pixels(points: Points) -> Floats:
        return middle + per_mm * view.flat(points) * (1, -1)

    covered = pixels(np.concatenate([moment.points for moment in moments]))
    for stent, place in enumerate(places):
        if place is None:
            continue
        lumens = [moment.lumens[stent] for moment in moments]
        center = pixels(point_at(lumens[0].axis, [place]))[0]
        widest = max(max(lumen.diameter, default=0.0) for lumen in lumens)
        side = label_side(covered, center, 0.7 * per_mm * widest, LABEL)
        leader = side * (1 - np.min(LABEL / 2 / np.maximum(np.abs(side), 1e-9)))
        # The next label covers this one less gladly than any vessel.
        covered = np.concatenate([covered, np.tile(center + side, (len(covered), 1))])
        for number, lumen in enumerate(lumens):
            if not len(lumen.diameter):
                continue
            shift = (number * WIDTH / 2, 0)
            value = np.interp(place, lumen.arc_length, lumen.diameter)
            ends = np.array([center, center + leader]) + shift
            x, y = center + side + shift
            yield Line([(float(a), float(b)) for a, b in ends], RED, 1.5)
            yield Words(f"{value:.1f} mm", x, y + 6, 18, RED, is_bold=True)
