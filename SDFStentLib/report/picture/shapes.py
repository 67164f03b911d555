"""What a before-and-after picture shows, as arrays: wall with its colors, stent, marks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

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
"""Narrow to wide; lightness rises evenly, so that color-blind readers see it too."""

FADE = 1.5
"""mm over which the color of the stented region passes into that of the wall."""


class Wall(NamedTuple):
    """A surface, mm, with color and opacity (n, 4) of its points, 0 to 1."""

    points: Points
    triangles: Triangles
    colors: Floats


class Bars(NamedTuple):
    """Round bars along lines (l, p, 3), mm."""

    lines: Floats
    radius: float
    color: str


class Panel(NamedTuple):
    """A part of the picture: left, bottom, right, top as fractions, and what is seen in it."""

    place: tuple[float, float, float, float]
    view: View
    wall: Wall
    bars: tuple[Bars, ...]


class Lumen(NamedTuple):
    """Known diameters (k,) at arc lengths (k,) of a stent axis, mm, and how far they color."""

    axis: Points
    arc_length: Floats
    diameter: Floats
    reach: float


def wall_colors(
    points: Points,
    triangles: Triangles,
    view: View,
    lumens: Sequence[Lumen],
    limits: tuple[float, float],
) -> Floats:
    """Color and opacity (n, 4) of every surface point, 0 to 1.

    Walls along the `lumens` have the color of the diameter there on the scale between the two
    `limits`, mm. Walls seen edge-on are drawn denser, as in glass: that shows the outline.
    """
    colors = np.tile(np.array([*WALL_COLOR, 0.0]), (len(points), 1))
    stented = np.zeros(len(points))
    for lumen in lumens:
        far = lumen.reach + FADE
        inside = (points > lumen.axis.min(axis=0) - far) & (points < lumen.axis.max(axis=0) + far)
        near = np.flatnonzero(inside.all(axis=1))
        foot = closest_points(lumen.axis, points[near])
        share = np.clip((far - foot.distances) / FADE, 0, 1)
        share *= np.clip(1 - _overshoot(points[near], lumen.axis) / FADE, 0, 1)
        local = np.interp(foot.arc_lengths, lumen.arc_length, lumen.diameter)
        own = diameter_colors((local - limits[0]) / (limits[1] - limits[0]))
        colors[near, :3] += share[:, None] * (own - colors[near, :3])
        stented[near] = np.maximum(stented[near], share)
    facing = np.abs(vertex_normals(points, triangles) @ view.toward_camera)
    dense = (1 - np.clip(facing, 0, 1)) ** 2
    colors[:, 3] = 0.26 + 0.32 * stented + (0.60 - 0.20 * stented) * dense
    return colors


def diameter_colors(fraction: Floats) -> Floats:
    """Colors (n, 3) on the scale from narrow (0) to wide (1)."""
    anchors = np.linspace(0, 1, len(DIAMETER_COLORS))
    return np.stack([np.interp(fraction, anchors, part) for part in DIAMETER_COLORS.T], axis=-1)


def stent_lattice(axis: Points, radius: float) -> Floats:
    """Struts (l, p, 3) of a drawn stent, mm: rows of diamonds around the axis, end to end.

    Only a sign for a stent; no product looks like this.
    """
    around, pieces = 8, 6  # pieces per row let struts follow the cylinder, not cut through it
    rows = max(round(length(axis) / (np.pi * radius / around * 1.7)), 2)
    center = point_at(axis, np.linspace(0, length(axis), rows * pieces + 1))
    frame = frames(_smoothed(center, radius))
    # Zigzag in angle: half a cell forth in one row, back in the next.
    swing = np.abs((np.arange(len(center)) / pieces + 1) % 2 - 1)
    starts = 2 * np.arange(around)[:, None]
    angle = (np.pi / around * np.concatenate([starts + swing, starts - swing]))[..., None]
    return np.asarray(center + radius * (np.cos(angle) * frame[:, 1] + np.sin(angle) * frame[:, 2]))


def section_ring(axis: Points, at: float, radius: float) -> Points:
    """A circle (65, 3) across the axis at an arc length, closed, mm."""
    fine = resampled(axis, max(length(axis) / 200, 1e-6))
    _, one, other = frames(fine)[int(np.argmin(np.abs(arc_lengths(fine) - at)))]
    angle = np.linspace(0, 2 * np.pi, 65)[:, None]
    return np.asarray(point_at(axis, at) + radius * (np.cos(angle) * one + np.sin(angle) * other))


def _smoothed(points: Points, reach: float) -> Points:
    """A curve whose directions are averaged over `reach` mm: else struts shake with the axis."""
    at = arc_lengths(points)
    weight = np.exp(-(((at[:, None] - at) / reach) ** 2))
    direction = weight @ tangents(points)
    return np.cumsum(direction / np.linalg.norm(direction, axis=1)[:, None], axis=0)


def _overshoot(points: Points, axis: Points) -> Floats:
    """How far (n,) points lie beyond the ends of the axis, mm; 0 beside it."""
    direction = tangents(axis)
    before, behind = (axis[0] - points) @ direction[0], (points - axis[-1]) @ direction[-1]
    return np.maximum(np.maximum(before, behind), 0)
