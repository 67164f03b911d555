"""A stenosis as a view shows it: by widths in the picture, against those of healthy vessel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line, Surface, compacted, may_meet_box, section_around
from ..validation import Floats, Points, Triangles
from ..vessel import OWN_SECTION, HealthyPlace, Lesion, tightest

SECTIONS = 33
"""Along a lesion, at least: as many as `measure` cuts at first, and one at its middle."""

_HEALTHY = 5
"""Along a diameter of healthy vessel, whose median width counts: a branch widens some."""


class SeenStenosis(NamedTuple):
    """How narrow a lesion looks; NaN where no section is its vessel's alone."""

    percent: float
    """100 (1 - width / that of healthy vessel at that place)."""
    width: float
    """The smallest, mm at the isocenter."""
    reference: float
    """Of healthy vessel there, mm."""


def seen_stenosis(lesion: Lesion, after: Lesion, tree: Centerline, toward: Floats) -> SeenStenosis:
    """How narrow a lesion looks from a direction (3,).

    Parameters
    ----------
    lesion : Lesion
        As found before treatment: what it is measured against stays.
    after : Lesion
        The same part on the wall that is looked at; the same as `lesion` before treatment.
    tree : Centerline
        On which it was found.
    toward : (3,) array
        Unit vector toward the detector.

    Notes
    -----
    Along the lesion the healthy vessel tapers as for `measure`. Its width in the picture is the
    inscribed diameter times the ratio of both at the healthy places: 1 where these are round.
    """
    sides = [side for side in (lesion.proximal, lesion.distal) if side is not None]
    ratios = [_healthy_width(lesion.surface, tree, side, toward) / side.diameter for side in sides]
    known = [ratio for ratio in ratios if np.isfinite(ratio)]
    line, count = after.line, max(SECTIONS, 2 * len(after.line) + 1)
    at = np.linspace(0.0, line.length, count)
    inside = np.isfinite(after.diameters)
    if not known or not inside.any():
        return SeenStenosis(*[float("nan")] * 3)
    expected = np.interp(at, line.arc_lengths[inside], after.diameters[inside])
    widths = seen_widths(after.surface, line, at, expected, toward)
    references = np.interp(at, line.arc_lengths, lesion.healthy) * float(np.mean(known))
    if not np.isfinite(widths).any():
        return SeenStenosis(*[float("nan")] * 3)
    place = tightest(widths, references)
    width, reference = float(widths[place]), float(references[place])
    return SeenStenosis(100 * (1 - width / reference), width, reference)


def seen_widths(
    surface: Surface, line: Line, at: Floats, expected: Floats, toward: Floats
) -> Floats:
    """Widths (k,) of a lumen in the picture, across its axis, mm.

    Parameters
    ----------
    surface : Surface
    line : Line
        The axis.
    at : (k,) array
        Arc lengths on it, mm.
    expected : (k,) array
        Inscribed diameters there, mm: a section that is far wider is not of this vessel alone.
    toward : (3,) array
        Unit vector toward the detector.

    Returns
    -------
    (k,) array
        NaN where no closed section of the vessel alone lies round the axis.
    """
    wall = _wall_round(surface, line, expected)
    ways = np.column_stack(
        [np.interp(at, line.arc_lengths, column) for column in line.directions.T]
    )
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    stations = zip(line.at(at), ways, expected, strict=True)
    return np.array([_width(wall, *station, toward) for station in stations])


def _width(
    wall: tuple[Points, Triangles], center: Floats, way: Floats, expected: float, toward: Floats
) -> float:
    section = section_around(*wall, center, way)
    is_own = section is not None and section.is_closed
    if section is None or not is_own:
        return float("nan")
    if 2 * np.sqrt(section.area / np.pi) > OWN_SECTION * expected:
        return float("nan")
    side = np.cross(toward, way)
    length = float(np.linalg.norm(side))
    # Seen along the vessel, its section has no side across the axis.
    return float(np.ptp(section.start @ side)) / length if length > 0 else float("nan")


def _wall_round(surface: Surface, line: Line, expected: Floats) -> tuple[Points, Triangles]:
    """The part of a surface that holds all sections of the vessel alone, wound alike."""
    reach = OWN_SECTION * float(expected.max())
    low, high = line.points.min(axis=0) - reach, line.points.max(axis=0) + reach
    near = may_meet_box(surface.points, surface.triangles, low, high)
    return compacted(surface.points, surface.wound_triangles.compress(near, axis=0))


def _healthy_width(surface: Surface, tree: Centerline, side: HealthyPlace, toward: Floats) -> float:
    """The median width of a diameter's length of healthy vessel, NaN where no section is its."""
    line = tree.path_around(side.point, side.diameter).line
    if line.length <= 0:
        return float("nan")
    at = np.linspace(0.0, line.length, _HEALTHY)
    widths = seen_widths(surface, line, at, np.full(_HEALTHY, side.diameter), toward)
    known = widths[np.isfinite(widths)]
    return float(np.median(known)) if len(known) else float("nan")
