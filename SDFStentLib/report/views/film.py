"""An angiogram as pixels that lie in space, for who shows them beside other things."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import Surface
from ...units import Frame
from ...validation import Floats, Points
from ...view import SOURCE, Angiogram, ArmView, Beam, Gray, angiogram, beam_on
from .facts import Stretch

METAL = 60
"""Gray of struts: they are seen on all but the darkest lumen, as in the laboratory."""

NICE = (1, 2, 5, 10, 20, 50, 100)
"""Lengths of scale bars, mm."""

_BAR, _EDGE = 4, 14
"""Height of the bar, and its distance from the edge, pixels."""


class Film(NamedTuple):
    """A square picture at the isocenter."""

    gray: Gray
    """(n, n), 0 is black; the first row is at the top."""
    middle: Points
    """(3,) the isocenter, mm."""
    axes: Floats
    """(3, 3) right, up, and toward the detector."""
    side: float
    """Side of the picture, mm."""
    bar: float
    """Length of the black bar at its right lower edge, mm."""


def shot(
    stretch: Stretch,
    wall: Surface,
    view: ArmView,
    frame: Frame,
    source: float | None = SOURCE,
    reach: float | None = None,
) -> Angiogram:
    """The angiogram of a wall about a stretch; source and reach as of `beam_on`."""
    return angiogram(wall, view, beam_of(stretch, view, frame, source, reach))


def beam_of(
    stretch: Stretch,
    view: ArmView,
    frame: Frame,
    source: float | None = SOURCE,
    reach: float | None = None,
) -> Beam:
    """Rays of a view of the stretch."""
    radius = float(np.nanmax(stretch.radii))
    return beam_on(stretch.line, radius, view, frame, source=source, reach=reach)


def film_of(
    stretch: Stretch, wall: Surface, view: ArmView, frame: Frame, struts: Sequence[Floats]
) -> Film:
    """The film of a wall, with curves (m, p, 3) of stents, mm, and a scale bar."""
    made = shot(stretch, wall, view, frame)
    gray, beam = made.gray(), made.beam
    for curves in struts:
        for curve in curves:
            _draw(gray, made.pixels(curve))
    size = beam.size[0]
    bar = scale_length(1 / beam.pixel, size)
    long = round(bar / beam.pixel)
    gray[size - _EDGE - _BAR : size - _EDGE, size - _EDGE - long : size - _EDGE] = 0
    return Film(gray, beam.isocenter, beam.axes, beam.side, bar)


def scale_length(per_mm: float, room: float) -> int:
    """Largest round length, mm, within a quarter of the room, at a scale in pixels/mm."""
    return max(one for one in NICE if one == NICE[0] or one * per_mm <= room / 4)


def _draw(gray: Gray, corners: Floats) -> None:
    """Draw a curve (p, 2) of columns and rows, one pixel wide, clipped to the picture."""
    steps = np.hypot(*np.diff(corners, axis=0).T)
    passed = np.r_[0.0, np.cumsum(steps)]
    at = np.linspace(0.0, passed[-1], int(2 * passed[-1]) + 2)
    column, row = (np.floor(np.interp(at, passed, one)).astype(np.int64) for one in corners.T)
    inside = (row >= 0) & (row < gray.shape[0]) & (column >= 0) & (column < gray.shape[1])
    gray[row[inside], column[inside]] = np.minimum(gray[row[inside], column[inside]], METAL)
