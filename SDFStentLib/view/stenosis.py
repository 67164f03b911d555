"""A stenosis as a view shows it: by widths in the picture, against those of healthy vessel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line, Surface, compacted, may_meet_box, section_around
from ..validation import Floats, Points, Triangles
from ..vessel import OWN_WIDTH, HealthyPlace, Lesion, tightest

SECTIONS = 33
"""Number of sections along a lesion, at least: as many as `measure` cuts at first, and one at its
middle."""

_HEALTHY = 5
"""Number of them along a diameter of healthy vessel, whose median width counts: a branch widens
some."""


class SeenStenosis(NamedTuple):
    """Stenosis of a lesion as it looks; NaN where no section is its vessel's alone."""

    percent: float
    """100 (1 - width / that of healthy vessel at that place)."""
    width: float
    """The smallest, mm at the isocenter."""
    reference: float
    """The width of healthy vessel there, mm."""


def seen_stenosis(lesion: Lesion, after: Lesion, tree: Centerline, toward: Floats) -> SeenStenosis:
    """Stenosis of a lesion as it looks from a direction (3,), a unit vector toward the detector;
    see `LesionSections`, which is cheaper for several of them."""
    return LesionSections(lesion, after, tree).seen(toward)


@dataclass(frozen=True, eq=False)
class LesionSections:
    """The sections of a lesion, by which it looks narrow from any direction.

    Parameters
    ----------
    lesion : Lesion
        Lesion as found before treatment: what it is measured against stays.
    after : Lesion
        The same part on the wall that is looked at; `lesion` itself before treatment.
    tree : Centerline
        On which it was found.

    Notes
    -----
    Along the lesion the healthy vessel tapers as for `measure`. Its width in the picture is the
    inscribed diameter times the ratio of both at the healthy places: 1 where these are round.
    """

    lesion: Lesion
    after: Lesion
    tree: Centerline

    def seen(self, toward: Floats) -> SeenStenosis:
        """The stenosis seen from a direction (3,), a unit vector toward the detector."""
        ratios = [_healthy_width(one, toward) / diameter for diameter, one in self._healthy]
        known = [ratio for ratio in ratios if np.isfinite(ratio)]
        if not known or self._own is None:
            return SeenStenosis(*[float("nan")] * 3)
        widths = self._own.widths(toward)
        line = self.after.line
        at = self._stations
        references = np.interp(at, line.arc_lengths, self.lesion.healthy) * float(np.mean(known))
        if not np.isfinite(widths).any():
            return SeenStenosis(*[float("nan")] * 3)
        place = tightest(widths, references)
        width, reference = float(widths[place]), float(references[place])
        return SeenStenosis(100 * (1 - width / reference), width, reference)

    @cached_property
    def _stations(self) -> Floats:
        line = self.after.line
        return np.linspace(0.0, line.length, max(SECTIONS, 2 * len(line) + 1))

    @cached_property
    def _own(self) -> Sections | None:
        line, at = self.after.line, self._stations
        inside = np.isfinite(self.after.diameters)
        if not inside.any():
            return None
        expected = np.interp(at, line.arc_lengths[inside], self.after.diameters[inside])
        return sections_along(self.after.surface, line, at, expected)

    @cached_property
    def _healthy(self) -> list[tuple[float, Sections | None]]:
        """The diameter at the healthy places, and the sections there."""
        lesion = self.lesion
        sides = [side for side in (lesion.proximal, lesion.distal) if side is not None]
        return [(one.diameter, _healthy_sections(lesion.surface, self.tree, one)) for one in sides]


class Sections(NamedTuple):
    """Sections of a lumen across an axis; k of them."""

    ways: Floats
    """(k, 3) directions of the axis there."""
    outlines: tuple[Points | None, ...]
    """The outline of each section; None where no closed one of the vessel alone lies round the
    axis."""

    def widths(self, toward: Floats) -> Floats:
        """Widths in the picture from a direction (3,), across the axis, mm (k,); NaN without a
        section.
        """
        pairs = zip(self.ways, self.outlines, strict=True)
        return np.array([_width(outline, way, toward) for way, outline in pairs])


def sections_along(surface: Surface, line: Line, at: Floats, expected: Floats) -> Sections:
    """The sections of a lumen at arc lengths (k,), mm; arguments as of `seen_widths`."""
    wall = _wall_round(surface, line, expected)
    ways = np.column_stack(
        [np.interp(at, line.arc_lengths, column) for column in line.directions.T]
    )
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    stations = zip(line.at(at), ways, expected, strict=True)
    return Sections(ways, tuple(_outline(wall, *station) for station in stations))


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
    return sections_along(surface, line, at, expected).widths(toward)


def _outline(
    wall: tuple[Points, Triangles], center: Floats, way: Floats, expected: float
) -> Points | None:
    section = section_around(*wall, center, way)
    if section is None or not section.is_closed:
        return None
    is_own = 2 * np.sqrt(section.area / np.pi) <= OWN_WIDTH * expected
    return section.start if is_own else None


def _width(outline: Points | None, way: Floats, toward: Floats) -> float:
    side = np.cross(toward, way)
    length = float(np.linalg.norm(side))
    # Seen along the vessel, its section has no side across the axis.
    if outline is None or length == 0:
        return float("nan")
    return float(np.ptp(outline @ side)) / length


def _wall_round(surface: Surface, line: Line, expected: Floats) -> tuple[Points, Triangles]:
    """The part of a surface that holds all sections of the vessel alone, wound alike."""
    reach = OWN_WIDTH * float(expected.max())
    low, high = line.points.min(axis=0) - reach, line.points.max(axis=0) + reach
    near = may_meet_box(surface.points, surface.triangles, low, high)
    return compacted(surface.points, surface.wound_triangles.compress(near, axis=0))


def _healthy_sections(surface: Surface, tree: Centerline, side: HealthyPlace) -> Sections | None:
    """Sections along a diameter's length of healthy vessel."""
    line = tree.path_around(side.point, side.diameter).line
    if line.length <= 0:
        return None
    at = np.linspace(0.0, line.length, _HEALTHY)
    return sections_along(surface, line, at, np.full(_HEALTHY, side.diameter))


def _healthy_width(sections: Sections | None, toward: Floats) -> float:
    """The median width of them, NaN where no section is the vessel's."""
    widths = np.empty(0) if sections is None else sections.widths(toward)
    known = widths[np.isfinite(widths)]
    return float(np.median(known)) if len(known) else float("nan")
