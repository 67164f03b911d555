"""The picture of a vessel that was made from a segmentation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from ...geometry import Line, search_tree
from ...scan import PreparedVessel
from ...units import Frame
from ..words import millimeters
from .drawing import GRAY, INK, Drawing, Mark, Stroke, Words
from .painting import painted
from .picture import color_scale, length_scale
from .shapes import panel_of
from .view import BOTTOM, HEIGHT, PANEL_WIDTH, TOP, Viewpoint, best_view

NAMED = 12
"""Number of ends up to which all of them are named in the picture; else the inlet is."""


def prepared_picture(made: PreparedVessel, frame: Frame) -> bytes:
    """A PNG of the vessel, its wall colored by the diameter beside it, with its lines and ends.

    Raises
    ------
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    points, lines, radii = made.lines
    longest = max((Line(points[line]) for line in lines), key=lambda line: line.length)
    aspect, cloud = PANEL_WIDTH / (BOTTOM - TOP), made.surface.points
    view = best_view([longest], float(radii.max()), cloud, aspect, frame).framing(cloud, aspect)
    diameters = 2 * radii[search_tree(points).query(cloud)[1]]
    limits = float(np.floor(diameters.min())), float(np.ceil(diameters.max()))
    panel = panel_of(0, view, made.surface, diameters, limits)
    marks = [*_heading(made), *length_scale(view), *_scale(limits), *_lines(view, made)]
    return painted(Drawing(PANEL_WIDTH, HEIGHT, (*marks, *_names(view, made))), [panel])


def _heading(made: PreparedVessel) -> Iterator[Mark]:
    count = len(made.ends) - 1
    outlets = f"{count} outlet{'s' * (count != 1)}"
    yield Words(f"Inlet and {outlets}", PANEL_WIDTH / 2, 40, 23, is_bold=True)
    voxels = " x ".join(millimeters(side).removesuffix(" mm") for side in made.voxels)
    yield Words(f"from voxels of {voxels} mm", PANEL_WIDTH / 2, 68, 15, GRAY)


def _scale(limits: tuple[float, float]) -> Iterator[Mark]:
    yield from color_scale(*limits, 0.62 * PANEL_WIDTH)


def _lines(view: Viewpoint, made: PreparedVessel) -> Iterator[Mark]:
    for line in made.lines.lines:
        corners = view.pixels(made.lines.points[line])
        yield Stroke([(float(x), float(y)) for x, y in corners], INK, 2)


def _names(view: Viewpoint, made: PreparedVessel) -> Iterator[Mark]:
    shown = made.ends if len(made.ends) <= NAMED else made.ends[:1]
    middle = PANEL_WIDTH / 2
    for end, (x, y) in zip(shown, view.pixels(np.array([e.center for e in shown])), strict=True):
        side: Literal["start", "end"] = "start" if x < middle else "end"
        yield Words(end.name.replace("_", " "), float(x), float(y) - 8, 15, INK, side, True)
