"""A picture for the heart-team meeting: the vessel before and after, seen by one camera."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...plan import PlanResult
from ...treatment import TreatedStent
from ...validation import check_is_a
from .drawing import GRAY, INK, Drawing, Mark, Stroke, Words
from .marks import color_limits, color_scale, curve, length_scale, section_marks
from .painting import painted
from .shapes import Panel, lumen_of, panel_of, strut_curves, wall_diameters
from .view import BOTTOM, HEIGHT, PANEL_WIDTH, TOP, WIDTH, best_view


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
        panels[1] = panels[1]._replace(struts=strut_curves(result.treatment.final_stents))
    return painted(drawing, panels)


def before_after_scene(result: PlanResult, title: str) -> tuple[Drawing, list[Panel]]:
    """What `before_after_picture` paints: all that is flat, and the walls under it."""
    surface, stents = result.inputs.surface, result.treatment.final_stents
    moments = surface.surface, result.treatment.surface
    cloud, axes = np.concatenate([one.points for one in moments]), [s.axis.line for s in stents]
    radii = [stent.stent.widest_diameter / 2 for stent in stents]
    view = best_view(axes, max(radii), cloud, PANEL_WIDTH / (BOTTOM - TOP), surface.frame)
    lumens = [lumen for lumen in map(lumen_of, stents) if len(lumen.arc_length)]
    limits = color_limits(radii, lumens)
    panels = []
    for side, wall in enumerate(moments):
        diameters = wall_diameters(wall.points, lumens, side)
        panels.append(panel_of(side, view, wall, diameters, limits))
    marks = [*_headings(stents, title), *length_scale(view)]
    marks += color_scale(*limits, WIDTH / 2)
    marks += [curve(view, stent.axis.points, 0, INK, 2.5) for stent in stents]
    marks += section_marks(view, cloud, lumens, ((0, 0), (1, 1)))
    return Drawing(WIDTH, HEIGHT, tuple(marks), title), panels


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
    yield Stroke([(WIDTH / 2, 50), (WIDTH / 2, BOTTOM)], "#d9dee3", 1.5)
    yield Words("Research use only. Not for clinical decisions.", 984, 674, 12, GRAY)
