"""What a before-and-after picture shows, as arrays: colours of the wall, stent, marks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...geometry import (
    arc_lengths,
    closest_points,
    frames,
    length,
    point_at,
    resampled,
    tangents,
    vertex_normals,
)
from ...validation import Floats, Points, Triangles
from .view import View

WALL_COLOR = (0.84, 0.42, 0.36)
"""Of the vessel: a warm tissue red, light enough to look through."""

DIAMETER_COLORS = np.array(
    [
        (0.267, 0.005, 0.329),
        (0.230, 0.322, 0.546),
        (0.128, 0.567, 0.551),
        (0.369, 0.789, 0.383),
        (0.993, 0.906, 0.144),
    ]
)
"""Narrow to wide; lightness rises evenly, so that colour-blind readers see it too."""

FADE = 1.5
"""mm over which the colour of the stented region passes into that of the wall."""


def wall_colors(
    points: Points,
    triangles: Triangles,
    view: View,
    axis: Points,
    diameters: Floats,
    reach: float,
    limits: tuple[float, float],
) -> Floats:
    """Colour and opacity (n, 4) of every surface point, 0 to 1.

    Parameters
    ----------
    points, triangles : (n, 3), (m, 3) arrays
        The surface, mm.
    view : View
        Walls seen edge-on are drawn denser, as in glass: that shows the outline.
    axis, diameters : (k, 3), (k,) arrays
        Stent axis and the lumen diameter at its points, mm.
    reach : float
        Largest distance from the axis, mm, that still counts as stented wall.
    limits : two floats
        Diameters at the ends of the colour scale, mm.
    """
    colors = np.tile(np.array([*WALL_COLOR, 0.0]), (len(points), 1))
    near = _box(points, axis, reach + FADE)
    foot = closest_points(axis, points[near])
    along = arc_lengths(axis)
    overshoot = _overshoot(points[near], axis)
    share = np.clip((reach + FADE - foot.distances) / FADE, 0, 1)
    share = share * np.clip(1 - overshoot / FADE, 0, 1)
    local = np.interp(foot.arc_lengths, along, diameters)
    scale = (local - limits[0]) / max(limits[1] - limits[0], 1e-9)
    colors[near, :3] += share[:, None] * (diameter_colors(scale) - colors[near, :3])

    facing = np.abs(vertex_normals(points, triangles) @ view.toward_camera)
    stented = np.zeros(len(points))
    stented[near] = share
    dense = (1 - np.clip(facing, 0, 1)) ** 2
    colors[:, 3] = 0.26 + 0.32 * stented + (0.60 - 0.20 * stented) * dense
    return colors


def diameter_colors(fraction: Floats) -> Floats:
    """Colours (n, 3) on the scale from narrow (0) to wide (1)."""
    anchors = np.linspace(0, 1, len(DIAMETER_COLORS))
    clipped = np.clip(fraction, 0, 1)
    return np.stack([np.interp(clipped, anchors, part) for part in DIAMETER_COLORS.T], axis=-1)


def stent_lattice(axis: Points, radii: Floats, offset: float = 0.0) -> Floats:
    """Struts of a drawn stent: zigzag rows of diamonds around the axis, from end to end.

    Only a sign for a stent; no product looks like this.

    Parameters
    ----------
    axis, radii : (k, 3), (k,) arrays
        Stent axis and its radius there, mm.
    offset : float
        Added to the radii, mm.

    Returns
    -------
    (l, p, 3) array
        One polyline of p points per strut line, mm.
    """
    mean = float(np.mean(radii))
    around = 8
    rows = max(round(length(axis) / (np.pi * mean / around * 1.7)), 2)
    pieces = 6  # per row, so that struts follow the cylinder instead of cutting through it
    at = np.linspace(0, length(axis), rows * pieces + 1)
    center = point_at(axis, at)
    frame = frames(_smoothed(center, mean))
    radius = np.interp(at, arc_lengths(axis), radii) + offset
    step = np.pi / around
    # Zigzag in angle: half a cell forth in one row, back in the next.
    swing = step * np.abs((np.arange(len(at)) / pieces + 1) % 2 - 1)
    lines = []
    for number in range(around):
        for sign in (1, -1):
            angle = (2 * number * step + sign * swing)[:, None]
            radial = np.cos(angle) * frame[:, 1] + np.sin(angle) * frame[:, 2]
            lines.append(center + radius[:, None] * radial)
    return np.stack(lines)


def section_ring(axis: Points, at: float, radius: float) -> Points:
    """A circle (65, 3) across the axis at an arc length, closed, mm."""
    fine = resampled(axis, max(length(axis) / 200, 1e-6))
    frame = frames(fine)[int(np.argmin(np.abs(arc_lengths(fine) - at)))]
    angle = np.linspace(0, 2 * np.pi, 65)[:, None]
    ring = np.cos(angle) * frame[1] + np.sin(angle) * frame[2]
    return np.asarray(point_at(axis, at) + radius * ring)


def _smoothed(points: Points, reach: float) -> Points:
    """A curve whose directions are averaged over `reach` mm: else struts shake with the axis."""
    at = arc_lengths(points)
    weight = np.exp(-(((at[:, None] - at) / reach) ** 2))
    direction = weight @ tangents(points)
    return np.cumsum(direction / np.linalg.norm(direction, axis=1)[:, None], axis=0)


def _box(points: Points, axis: Points, reach: float) -> NDArray[np.int64]:
    """Indices of the points in the box around the axis."""
    lower, upper = axis.min(axis=0) - reach, axis.max(axis=0) + reach
    return np.flatnonzero(((points > lower) & (points < upper)).all(axis=1))


def _overshoot(points: Points, axis: Points) -> Floats:
    """How far (n,) points lie beyond the ends of the axis, mm; 0 beside it."""
    direction = tangents(axis)
    return np.maximum(
        np.maximum((axis[0] - points) @ direction[0], (points - axis[-1]) @ direction[-1]), 0
    )
