"""Whether a flat spot or a rim is where a vessel ends, or only a spot or a hole in its wall.

A vessel ends over its whole width, and goes on from there: half as deep below an end as it is wide
there is wall all round, no farther away than that; and from its middle the lumen reaches farther
than the end does. The facets of a coarse wall, its steps and terraces fail one or the other, for
below them the lumen is as wide as their vessel. What comes farther down, as the vessel from which
this one comes, or a fork, plays no part.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ..geometry import Surface, SurfaceIndex, across, closest_on_segments, in_blocks, norm
from ..validation import Flags, Floats, Indices, Points
from .spheres import index_within
from .tolerances import ASKEW, OWN_WIDTH, ROUNDING

_RAYS = 64
_MOST = 2 / 3
"""Share of the directions across a vessel in which its wall is met; in others branches begin. Of
half of them flat wall at junctions passes, by a patient and trees whose ends are known."""

_BELOW = 0.01
"""Distance from a spot, as a share of its narrow radius, at which its inner side is looked for."""


class Spot(NamedTuple):
    """A flat part of a surface, or a rim, that may be an end of the vessel."""

    center: Floats
    """(3,) its center, mm."""
    across: Floats
    """(3,) unit vector across it, to any side."""
    narrow: float
    """Distance from the center to the nearest place of its border, or side of its outline, mm,"""
    wide: float
    """and to the farthest place."""
    faces: Indices
    """Indices of the triangles of the surface that lie in it."""


def spot(points: Points, rim: Indices, across: Floats, faces: Indices, center: Floats) -> Spot:
    """The spot with a given border, edges (k, 2) of a surface; an open one has no `faces`."""
    start, stop = points[rim[:, 0]], points[rim[:, 1]]
    if len(faces):
        narrow = float(closest_on_segments(start, stop, center[None]).distances[0])
    else:
        # As from outside: a notch in a ragged rim does not make the opening narrower.
        narrow = float(((start - center) @ _round(across).T).max(axis=0).min())
    return Spot(center, across, narrow, float(norm(start - center).max()), faces)


def are_ends(surface: Surface, spots: Sequence[Spot]) -> Flags:
    """Mask (k,) of the spots of a surface that are ends of the vessel."""
    found = np.zeros(len(spots), dtype=bool)
    own = [number for number, one in enumerate(spots) if one.narrow > 0]
    if not own:
        return found
    centers = np.array([spots[i].center for i in own])
    normals = np.array([spots[i].across for i in own])
    step = _BELOW * np.array([[spots[i].narrow] for i in own]) * normals
    beside = np.concatenate([centers - step, centers + step])
    within, beyond = np.split(surface.contains(beside), 2)
    inward = np.where(within, -1.0, 1.0)[:, None] * normals
    rows = np.flatnonzero(within != beyond)
    if not len(rows):
        return found
    narrow, wide = (np.array([getattr(spots[i], name) for i in own]) for name in ("narrow", "wide"))
    aside, ahead = OWN_WIDTH * np.sqrt(narrow * wide), 2 * wide
    around = np.maximum(narrow + aside, ahead) * (1 + ROUNDING)
    index, numbers = index_within(surface, centers[rows], around[rows])
    for row in rows.tolist():
        met = partial(_met, index, numbers, spots[own[row]].faces)
        below = centers[row] + narrow[row] * inward[row]
        round_it = _round(inward[row])
        is_met = met(below, round_it, float(aside[row]))
        beside = (round_it @ round_it[is_met].T).max(axis=1, initial=-1.0)
        if is_met.mean() > _MOST and beside.min() > ASKEW:
            found[own[row]] = not met(centers[row], _cone(inward[row]), float(ahead[row])).all()
    return found


def _met(
    index: SurfaceIndex,
    numbers: Indices,
    own: Indices,
    start: Points,
    ways: Points,
    reach: float,
) -> Flags:
    """Mask (k,) of straight lines from a place, along `ways`, that meet wall within `reach`, mm.

    `numbers` are those of the index's triangles in the surface. Lines meet triangles that are not a
    spot's own as in Moeller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, J Graph
    Tools 2 (1997).
    """
    triangle = index.near(start[None], np.array([reach])).triangle
    corners = index.corners[triangle[~np.isin(numbers.take(triangle), own)]]

    def meet(block: Floats) -> Flags:
        first = block[:, 0]
        u, v = block[:, 1] - first, block[:, 2] - first
        from_first = start - first
        normal = np.cross(u, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = -1.0 / (ways @ normal.T)
            s = (ways @ np.cross(v, from_first).T) * scale
            t = (ways @ np.cross(from_first, u).T) * scale
            length = (from_first * normal).sum(axis=1) * scale
            is_met = (s >= -ROUNDING) & (t >= -ROUNDING) & (s + t <= 1 + ROUNDING)
            return is_met & (length > 0) & (length <= reach)

    return np.asarray(in_blocks(meet, corners).any(axis=1))


def _round(inward: Floats) -> Points:
    """Directions (_RAYS, 3) all round across a direction."""
    side, other = across(inward[None])[0]
    turn = 2 * np.pi * np.arange(_RAYS) / _RAYS
    return np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other


def _cone(inward: Floats) -> Points:
    """Directions (_RAYS, 3) evenly over a cone: a spiral of Fibonacci."""
    number = np.arange(_RAYS)
    height = 1 - (1 - ASKEW) * number / (_RAYS - 1)
    turn = number * np.pi * (3 - np.sqrt(5.0))
    side = np.cross(inward, np.eye(3)[np.abs(inward).argmin()])
    side /= np.linalg.norm(side)
    aside = np.sqrt(1 - height**2)[:, None]
    round_it = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(inward, side)
    return height[:, None] * inward + aside * round_it
