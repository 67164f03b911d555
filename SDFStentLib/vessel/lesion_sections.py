"""The smallest section of a lesion, cut when somebody asks for areas."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Line, Surface
from ..lumen import equivalent_diameters
from ..validation import Floats, Points

SECTIONS = 16
"""At least so many sections along a lesion, and two to a station: by areas of a vessel that are a
quarter of its radius apart the smallest is known to the next ones."""

OWN_SECTION = 1.5
"""Times the inscribed diameter up to which the circle of a section's area may be wide: what is
wider is the section of the vessel from which this one comes, or goes on into a branch."""

ABOUT = 1.01
"""Times the narrowest up to which another place is as narrow."""

FINE_STATIONS = 17
"""Spheres between the neighbors of the narrowest station of a lesion's line, and sections between
those of the smallest one: a smooth throat is missed by less than 0.03 % of its reference."""


class Section(NamedTuple):
    """A cross-section of a lesion; NaN in all three where none is its vessel's alone."""

    area: float
    """mm^2."""
    reference: float
    """Of the healthy vessel there, mm^2."""
    percent: float
    """By which it is smaller."""


class LesionLine(NamedTuple):
    """The line of a lesion from its start to its end."""

    line: Line
    """Through k points."""
    healthy: Floats
    """(k,) diameters of the healthy vessel, mm."""
    diameters: Floats
    """(k,) inscribed, mm; NaN where unknown."""
    area_ratio: float
    """Of the healthy vessel's area to its squared diameter."""


def smallest_section(surface: Surface, line: LesionLine, minimum: float) -> Section:
    """The smallest of the sections along a lesion that are those of its vessel.

    Parameters
    ----------
    surface : Surface
    line : LesionLine
    minimum : float
        The lesion's inscribed diameter, mm.
    """
    along = cut_at(line.line)
    areas = _own_areas(surface, line, along)
    smallest = tightest(areas, _wanted(line, along)) if np.isfinite(areas).any() else 0
    fine = between_neighbors(along, smallest)
    areas = np.r_[areas, _own_areas(surface, line, fine)]
    return _smallest(line, np.r_[along, fine], areas, minimum)


def cut_at(line: Line) -> Floats:
    """Where a lesion is cut, arc lengths (k,) from its start."""
    return np.linspace(0.0, line.arc_lengths[-1], max(SECTIONS, 2 * len(line)))


def tightest(sizes: Floats, references: Floats) -> int:
    """The narrowest place; of those that are about as narrow, the one that should be widest.

    A stent is as wide everywhere: what is left in it is told where most is missing.
    """
    about = sizes <= ABOUT * np.nanmin(sizes)
    return int(np.where(about, references / sizes, -np.inf).argmax())


def between_neighbors(along: Floats, number: int) -> Floats:
    """Arc lengths between the neighbors of one of some."""
    ends = along[max(number - 1, 0)], along[min(number + 1, len(along) - 1)]
    return np.linspace(*ends, FINE_STATIONS)


def on_line(line: Line, along: Floats) -> tuple[Points, Points]:
    """Points and directions (k, 3) at some arc lengths of a line."""
    places, ways = (
        np.column_stack([np.interp(along, line.arc_lengths, column) for column in values.T])
        for values in (line.points, line.directions)
    )
    return places, ways


def _own_areas(surface: Surface, line: LesionLine, along: Floats) -> Floats:
    """Areas of the sections at some arc lengths from its start, NaN for those of other vessels."""
    stations = on_line(line.line, along)
    sections = equivalent_diameters(surface.points, surface.triangles, *stations)
    known = np.isfinite(line.diameters)
    if not known.any():
        return np.full(len(along), np.nan)
    widths = np.interp(along, line.line.arc_lengths[known], line.diameters[known])
    return np.where(sections <= OWN_SECTION * widths, np.pi / 4 * sections**2, np.nan)


def _smallest(line: LesionLine, along: Floats, areas: Floats, minimum: float) -> Section:
    """The smallest of the areas at some arc lengths from its start."""
    wanted, unknown = _wanted(line, along), float("nan")
    largest = OWN_SECTION**2 * np.pi / 4 * minimum**2
    # Where a branch leaves at the throat, no section there is this vessel's alone.
    if not (np.isfinite(wanted) & (areas <= largest)).any():
        return Section(unknown, unknown, unknown)
    smallest = tightest(areas, wanted)
    area, reference = float(areas[smallest]), float(wanted[smallest])
    return Section(area, reference, 100 * (1 - area / reference))


def _wanted(line: LesionLine, along: Floats) -> Floats:
    """Areas of the healthy vessel at some arc lengths from a lesion's start."""
    healthy = np.interp(along, line.line.arc_lengths, line.healthy)
    return np.asarray(healthy**2 * line.area_ratio)
