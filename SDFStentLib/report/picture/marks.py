"""The flat marks of a picture that lie over its walls: stents, scales, rings with diameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ...validation import Points
from .drawing import Box, Mark, Stroke, Words
from .shapes import Lumen, diameter_colors, section_ring
from .view import PANEL_WIDTH, View, label_side

LABEL = np.array([90.0, 28.0])
"""Width and height of the label with a diameter, pixels."""

RED = "#cc0d33"


def color_limits(radii: Sequence[float], lumens: Sequence[Lumen]) -> tuple[float, float]:
    """Ends of the color scale: half millimeters around all diameters there are."""
    values = np.concatenate([2 * np.array(radii), *(one.diameters.ravel() for one in lumens)])
    # What is printed as 6.0 mm does not push the scale to 6.5.
    lower = np.floor(2 * values.min() + 0.1) / 2
    return float(lower), float(max(np.ceil(2 * values.max() - 0.1) / 2, lower + 0.5))


def length_scale(view: View) -> Iterator[Mark]:
    """How long so many millimeters are, at the left under the first panel."""
    steps = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
    nice = max(step for step in steps if step <= max(190 / view.per_mm, 0.5))
    left, right, y = 60, 60 + nice * view.per_mm, 654
    yield Stroke([(left, y), (right, y)], width=2.5)
    yield from (Stroke([(x, y - 7), (x, y + 7)], width=2.5) for x in (left, right))
    yield Words(f"{nice:g} mm", (left + right) / 2, 683, 16)


def color_scale(lower: float, upper: float, middle: float) -> Iterator[Mark]:
    """Which diameter has which color, mm, around `middle`."""
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
    view: View, cloud: Points, lumens: Sequence[Lumen], shown: Iterable[tuple[int, int]]
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


def curve(view: View, points: Points, column: int, color: str, width: float) -> Stroke:
    """A curve on the vessel in the panel of that column, over the wall."""
    corners = view.pixels(points) + np.array([column * PANEL_WIDTH, 0])
    return Stroke([(float(x), float(y)) for x, y in corners], color, width)
