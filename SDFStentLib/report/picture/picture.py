"""A picture for the heart-team meeting: the vessel before and after, seen by one camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...geometry import point_at, vertex_normals
from ...plan import PlanResult
from ...treatment import TreatedStent, prescribed_diameters
from ...validation import Floats, Points, check_is_a
from ..drawing import GRAY, INK, Box, Drawing, Line, Mark, Words
from ..painting import painted
from .shapes import (
    Lumen,
    Panel,
    diameter_colors,
    lumen_of,
    section_ring,
    stent_lattice,
    wall_colors,
    wall_diameters,
)
from .view import BOTTOM, HEIGHT, TOP, WIDTH, View, best_view, label_side

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
    return painted(*before_after_scene(result, title))


def before_after_scene(result: PlanResult, title: str) -> tuple[Drawing, list[Panel]]:
    """What `before_after_picture` paints: all that is flat, and the walls under it."""
    surface, stents = result.inputs.surface, result.treatment.stents
    moments = surface.points, result.treatment.points
    cloud, axes = np.concatenate(moments), [stent.axis.points for stent in stents]
    radii = [stent.stent.widest_diameter / 2 for stent in stents]
    view = best_view(axes, max(radii), cloud, WIDTH / 2 / (BOTTOM - TOP), surface.frame)
    lumens = [lumen for lumen in map(lumen_of, stents) if len(lumen.arc_length)]
    limits = _limits(radii, lumens)
    panels = []
    for side, points in enumerate(moments):
        normals = vertex_normals(points, surface.triangles)
        facing = np.abs(normals @ view.toward_camera)
        colors = wall_colors(wall_diameters(points, lumens, side), limits, facing)
        panels.append(Panel(side, view, points, surface.triangles, colors))
    marks = [*_headings(stents, title), *_length_scale(view), *_color_scale(*limits)]
    for stent, radius in zip(stents, radii, strict=True):
        marks.append(_curve(view, stent.axis.points, 0, INK, 2.5))
        marks += [_curve(view, strut, 1, STEEL, 1.5) for strut in _struts(stent, radius)]
    marks += _sections(view, cloud, lumens)
    return Drawing(WIDTH, HEIGHT, tuple(marks), title), panels


def _struts(stent: TreatedStent, radius: float) -> Floats:
    """Struts of a drawn stent, as wide as it is everywhere, mm."""
    return stent_lattice(
        stent.axis.points, radius, lambda at: prescribed_diameters(stent.stent, stent.axis, at) / 2
    )


def _limits(radii: Sequence[float], lumens: Sequence[Lumen]) -> tuple[float, float]:
    """Ends of the color scale: half millimeters around all diameters there are."""
    values = np.concatenate([2 * np.array(radii), *(one.diameters.ravel() for one in lumens)])
    # What is printed as 6.0 mm does not push the scale to 6.5.
    lower = np.floor(2 * values.min() + 0.1) / 2
    return float(lower), float(max(np.ceil(2 * values.max() - 0.1) / 2, lower + 0.5))


def _headings(stents: Sequence[TreatedStent], title: str) -> Iterator[Mark]:
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
    yield Line([(WIDTH / 2, 50), (WIDTH / 2, BOTTOM)], "#d9dee3", 1.5)
    yield Words("Research use only. Not for clinical decisions.", 984, 674, 12, GRAY)


def _length_scale(view: View) -> Iterator[Mark]:
    steps = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
    nice = max(step for step in steps if step <= max(190 / view.per_mm, 0.5))
    left, right, y = 60, 60 + nice * view.per_mm, 654
    yield Line([(left, y), (right, y)], width=2.5)
    yield from (Line([(x, y - 7), (x, y + 7)], width=2.5) for x in (left, right))
    yield Words(f"{nice:g} mm", (left + right) / 2, 683, 16)


def _color_scale(lower: float, upper: float) -> Iterator[Mark]:
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


def _sections(view: View, cloud: Points, lumens: Sequence[Lumen]) -> Iterator[Mark]:
    """Rings where it was narrowest, and the diameters beside them, alike in both panels."""
    covered = view.pixels(cloud)
    for lumen in lumens:
        values = lumen.at(lumen.narrowest)
        center = view.pixels(point_at(lumen.axis, [lumen.narrowest]))[0]
        gap = 0.7 * view.per_mm * lumen.diameters.max()
        away = label_side(covered, center, gap, LABEL)
        leader = away * (1 - np.min(LABEL / 2 / np.maximum(np.abs(away), 1e-9)))
        # The next label covers this one less gladly than any vessel.
        covered = np.concatenate([covered, np.tile(center + away, (len(covered), 1))])
        for side, value in enumerate(values):
            yield _curve(view, section_ring(lumen, side), side, RED, 2.5)
            start = center + np.array([side * WIDTH / 2, 0])
            yield Line([tuple(start), tuple(start + leader)], RED, 1.5)
            x, y = start + away
            yield Words(f"{value:.1f} mm", x, y + 6, 18, RED, is_bold=True)


def _curve(view: View, points: Points, side: int, color: str, width: float) -> Line:
    """A curve on the vessel before (side 0) or after (1), over the wall."""
    corners = view.pixels(points) + np.array([side * WIDTH / 2, 0])
    return Line([(float(x), float(y)) for x, y in corners], color, width)
