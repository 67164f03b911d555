"""Sections of lesions and of the healthy vessel beside them, cut when somebody asks for areas."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Line, Surface, compacted, may_meet_box
from ..lumen import ALIKE, FARTHEST, FINE_STATIONS, OWN_WIDTH, equivalent_diameters
from ..validation import Floats, Points, Triangles
from .caliber import KEPT
from .narrowings import Plateau
from .runs import VesselRun

_HEALTHY_SECTIONS = 5
"""Number of sections along healthy vessel, of which the least oblong gives the area: branches that
leave, and lines that go aslant, only make them larger."""


class Section(NamedTuple):
    """A cross-section of a lesion; NaN in all three where none is its vessel's alone."""

    area: float
    """mm^2."""
    reference: float
    """The area of the healthy vessel there, mm^2."""
    percent: float
    """The percent by which it is smaller."""


class LesionLine(NamedTuple):
    """The line of a lesion from its start to its end."""

    line: Line
    """Centerline of the lesion through k points."""
    healthy: Floats
    """(k,) diameters of the healthy vessel, mm."""
    diameters: Floats
    """(k,) inscribed, mm; NaN where unknown."""
    area_ratio: float
    """The ratio of the healthy vessel's area to its squared diameter."""


def smallest_section(surface: Surface, line: LesionLine, minimum: float) -> Section:
    """The smallest of the sections along a lesion that are those of its vessel.

    Parameters
    ----------
    surface : Surface
    line : LesionLine
    minimum : float
        The lesion's inscribed diameter, mm.
    """
    along, wall = cut_at(line.line), _wall_round(surface, line)
    areas = _own_areas(wall, line, along)
    smallest = tightest(areas, _wanted(line, along)) if np.isfinite(areas).any() else 0
    fine = between_neighbors(along, smallest, smallest)
    areas = np.r_[areas, _own_areas(wall, line, fine)]
    return _smallest(line, np.r_[along, fine], areas, minimum)


def cut_at(line: Line) -> Floats:
    """Arc lengths (k,) from its start at which a lesion is cut, two to a station: by areas of a
    vessel that are a quarter of its radius apart the smallest is known to the next ones."""
    return np.linspace(0.0, line.arc_lengths[-1], max(FINE_STATIONS, 2 * len(line)))


def tightest(sizes: Floats, references: Floats) -> int:
    """The narrowest place; of those that are about as narrow, the one that should be widest.

    A stent is as wide everywhere: what is left in it is told where most is missing.
    """
    about = sizes <= ALIKE * np.nanmin(sizes)
    return int(np.where(about, references / sizes, -np.inf).argmax())


def between_neighbors(along: Floats, first: int, last: int) -> Floats:
    """Arc lengths (k,) from the neighbor before some stations in a row to the one behind them."""
    ends = along[max(first - 1, 0)], along[min(last + 1, len(along) - 1)]
    return np.linspace(*ends, FINE_STATIONS + FINE_STATIONS // 2 * (last - first))


def on_line(line: Line, along: Floats) -> tuple[Points, Points]:
    """Points and directions (k, 3) at some arc lengths of a line."""
    places, ways = (
        np.column_stack([np.interp(along, line.arc_lengths, column) for column in values.T])
        for values in (line.points, line.directions)
    )
    return places, ways


def _wall_round(surface: Surface, line: LesionLine) -> tuple[Points, Triangles]:
    """The part of a surface that holds all sections of a lesion that are its vessel's own."""
    reach = FARTHEST / 2 * float(np.fmax(line.healthy, line.diameters).max())
    low, high = line.line.points.min(axis=0) - reach, line.line.points.max(axis=0) + reach
    near = may_meet_box(surface.points, surface.triangles, low, high)
    return compacted(surface.points, surface.triangles.compress(near, axis=0))


def _own_areas(wall: tuple[Points, Triangles], line: LesionLine, along: Floats) -> Floats:
    """Areas of the sections at some arc lengths from its start, NaN for those of other vessels."""
    stations = on_line(line.line, along)
    sections = equivalent_diameters(*wall, *stations)
    known = np.isfinite(line.diameters)
    if not known.any():
        return np.full(len(along), np.nan)
    widths = np.interp(along, line.line.arc_lengths[known], line.diameters[known])
    return np.where(sections <= OWN_WIDTH * widths, np.pi / 4 * sections**2, np.nan)


def _smallest(line: LesionLine, along: Floats, areas: Floats, minimum: float) -> Section:
    """The smallest of the areas at some arc lengths from its start."""
    wanted, unknown = _wanted(line, along), float("nan")
    largest = OWN_WIDTH**2 * np.pi / 4 * minimum**2
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


def healthy_area(surface: Surface, run: VesselRun, side: Plateau) -> float:
    """Area of the least oblong section along healthy vessel, mm^2; NaN where none is its own."""
    places, ways, diameters = _along_plateau(run, side)
    sections = equivalent_diameters(surface.points, surface.triangles, places, ways)
    own = sections <= OWN_WIDTH * side.diameter
    oblong = float((sections[own] / diameters[own]).min(initial=np.inf))
    return np.pi / 4 * (oblong * side.diameter) ** 2 if own.any() else float("nan")


def _along_plateau(run: VesselRun, side: Plateau) -> tuple[Points, Points, Floats]:
    """Places (k, 3) along healthy vessel with its directions and inscribed diameters (k,)."""
    half = KEPT * side.diameter / 2
    at = np.linspace(side.arc_length - half, side.arc_length + half, _HEALTHY_SECTIONS)
    at = np.clip(at, run.along[0], run.along[-1])
    line, ways = (
        np.column_stack([np.interp(at, run.along, column) for column in values.T])
        for values in (run.points, run.line.directions)
    )
    known = np.isfinite(run.diameter)
    return line, ways, np.interp(at, run.along[known], run.diameter[known])
