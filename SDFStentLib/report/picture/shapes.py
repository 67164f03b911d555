"""Content of a before-and-after picture, as arrays: wall with its colors, stent, marks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import Line, Surface, across
from ...stent import stent_lattice
from ...treatment import TreatedStent
from ...validation import Floats, Points, Triangles
from .view import Viewpoint

WALL_COLOR = (0.84, 0.42, 0.36)
"""The color of the vessel: a warm tissue red."""

DIAMETER_COLORS = np.array(
    [
        (0.267, 0.005, 0.329),
        (0.230, 0.322, 0.546),
        (0.128, 0.567, 0.551),
        (0.369, 0.789, 0.383),
        (0.993, 0.906, 0.144),
    ]
)
"""Narrow to wide; lightness rises evenly, so that color-blind readers see it too."""

REACH = 1.15
"""Distance from the axis, in radii, up to which the wall has the color of its stent's lumen."""


class Panel(NamedTuple):
    """A surface, mm, in a view, with color and opacity (n, 4) of its points, 0 to 1."""

    column: int
    """The column of the picture, 0 for the left one."""
    view: Viewpoint
    points: Points
    triangles: Triangles
    colors: Floats
    struts: tuple[Floats, ...] = ()
    """Struts of every stent in it, (m, p, 3) mm."""


def panel_of(
    column: int, view: Viewpoint, surface: Surface, diameters: Floats, limits: tuple[float, float]
) -> Panel:
    """A wall with the lumen diameters (n,) at its points as its colors, see `wall_colors`."""
    facing = np.abs(surface.vertex_normals @ view.toward_camera)
    colors = wall_colors(diameters, limits, facing)
    return Panel(column, view, surface.points, surface.triangles, colors)


class Lumen(NamedTuple):
    """Diameters (2, k) before and after at arc lengths (k,) of a stent axis, mm; all known."""

    axis: Line
    arc_length: Floats
    diameters: Floats

    @property
    def narrowest(self) -> float:
        """Arc length of the place where it was narrowest before, mm."""
        return float(self.arc_length[np.argmin(self.diameters[0])])

    def at(self, arc_length: float) -> Floats:
        """Diameters (2,) before and after, mm."""
        return np.array([np.interp(arc_length, self.arc_length, each) for each in self.diameters])


def lumen_of(stent: TreatedStent) -> Lumen:
    """Lumen where both diameters are known; that may be nowhere."""
    both = np.stack([stent.before.inscribed_diameter, stent.after.inscribed_diameter])
    known = np.isfinite(both).all(axis=0)
    return Lumen(stent.axis.line, stent.before.arc_length[known], both[:, known])


def wall_diameters(points: Points, lumens: Sequence[Lumen], side: int) -> Floats:
    """Lumen diameter (n,) at wall points beside a stent, mm; NaN elsewhere.

    Before is side 0, after is side 1. A point is beside a stent when the nearest point of its
    axis is not an end.
    """
    found = np.full(len(points), np.nan)
    for lumen in lumens:
        far = REACH / 2 * lumen.diameters.max()
        low, high = lumen.axis.points.min(axis=0) - far, lumen.axis.points.max(axis=0) + far
        near = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
        foot = lumen.axis.nearest(points[near])
        beside = np.abs(foot.arc_lengths / lumen.axis.length - 0.5) < 0.5 - 1e-9
        at = np.flatnonzero(beside & (foot.distances < far))
        found[near[at]] = np.interp(foot.arc_lengths[at], lumen.arc_length, lumen.diameters[side])
    return found


def wall_colors(diameters: Floats, limits: tuple[float, float], facing: Floats) -> Floats:
    """Color and opacity (n, 4) of wall points, 0 to 1.

    Diameters (n,) have their color on the scale between the two `limits`, mm; NaN that of tissue.
    `facing` (n,) is 1 where a wall faces the camera and 0 where it is seen edge-on: there it is
    denser, as in glass, and shows the outline.
    """
    known = np.isfinite(diameters)[:, None]
    scaled = diameter_colors((diameters - limits[0]) / (limits[1] - limits[0]))
    dense = (1 - np.clip(facing, 0, 1))[:, None] ** 2
    return np.hstack(
        [
            np.where(known, scaled, WALL_COLOR),
            np.where(known, 0.58 + 0.40 * dense, 0.26 + 0.60 * dense),
        ]
    )


def diameter_colors(fraction: Floats) -> Floats:
    """Colors (n, 3) on the scale from narrow (0) to wide (1)."""
    anchors = np.linspace(0, 1, len(DIAMETER_COLORS))
    return np.stack([np.interp(fraction, anchors, part) for part in DIAMETER_COLORS.T], axis=-1)


def strut_curves(stents: Iterable[TreatedStent]) -> tuple[Floats, ...]:
    """The struts of every deployed stent, (m, p, 3) mm, as `stent_lattice` designs them."""
    return tuple(stent_lattice(one.stent, one.axis).curves for one in stents)


def section_ring(lumen: Lumen, side: int) -> Points:
    """The marked section, before or after: a circle (65, 3) across the axis, closed, mm."""
    at, radius = lumen.narrowest, lumen.at(lumen.narrowest)[side] / 2
    # Where the axis leaves the lumen, the radius is 0 and tells no direction.
    reach = max(radius, lumen.axis.length / 100)
    start, center, end = lumen.axis.at([at - reach, at, at + reach])
    one, other = across(((end - start) / np.linalg.norm(end - start))[None])[0]
    angle = np.linspace(0, 2 * np.pi, 65)[:, None]
    return np.asarray(center + radius * (np.cos(angle) * one + np.sin(angle) * other))
