"""Whether a flat spot or a rim is where a vessel ends, or only a spot or a hole in its wall.

A vessel ends over its whole width, and goes on from there: as deep below an end as it is wide, a
sphere hardly wider meets the wall; and from its middle the lumen reaches farther than the end does.
The facets of a coarse wall, its steps and its slivers fail one or the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ..geometry import Surface, SurfaceIndex, closest_on_segments, norm
from ..validation import Flags, Floats, Indices, Points
from .spheres import known_index
from .tolerances import ALIKE, ASKEW, OWN_WIDTH, ROUNDING

_RAYS = 64
_DOWN = 4.0
"""Radii of a spot of few sides within which most lines into a coarse vessel meet its wall."""

_BELOW = 0.01
"""Distance from a spot, as a share of its narrow radius, at which its inner side is looked for."""


class Spot(NamedTuple):
    """A flat part of a surface, or a rim, that may be an end of the vessel."""

    center: Floats
    """(3,) its center, mm."""
    across: Floats
    """(3,) unit vector across it, to any side."""
    narrow: float
    """Distance from the center to the nearest place of its border, mm,"""
    wide: float
    """and to the farthest place."""
    faces: Indices
    """Indices of the triangles of the surface that lie in it."""
    side: float
    """The mean length of the pieces of its border, mm."""

    @property
    def is_round(self) -> bool:
        """Whether it is wider for its pieces than a square or a strip, as five sides make it."""
        return self.narrow > ALIKE * self.side / 2


def spot(points: Points, rim: Indices, across: Floats, faces: Indices, center: Floats) -> Spot:
    """The spot with a given border, edges (k, 2) of a surface."""
    start, stop = points[rim[:, 0]], points[rim[:, 1]]
    places = closest_on_segments(start, stop, center[None])
    narrow, side = float(places.distances[0]), float(norm(stop - start).mean())
    return Spot(center, across, narrow, float(norm(start - center).max()), faces, side)


def are_ends(surface: Surface, spots: Sequence[Spot]) -> Flags:
    """Mask (k,) of the spots of a surface that are ends of the vessel."""
    found = np.zeros(len(spots), dtype=bool)
    own = [number for number, one in enumerate(spots) if one.narrow > 0]
    if not own:
        return found
    centers = np.array([spots[i].center for i in own])
    across = np.array([spots[i].across for i in own])
    narrow = np.array([spots[i].narrow for i in own])
    step = _BELOW * narrow[:, None] * across
    within, beyond = surface.contains(centers - step), surface.contains(centers + step)
    inward = np.where(within, -1.0, 1.0)[:, None] * across
    index = known_index(surface)
    spot_of = np.full(len(surface.triangles), -1)
    for place, number in enumerate(own):
        spot_of[spots[number].faces] = place
    # As deep below as it is wide.
    middles = centers + 2 * narrow[:, None] * inward
    spans = (within != beyond) & _meet_wall(index, spot_of, middles, OWN_WIDTH * narrow)
    for row in np.flatnonzero(spans).tolist():
        one = spots[own[row]]
        free = partial(_free, index, spot_of, row, centers[row], inward[row])
        # A terrace of voxels has few sides as a coarse vessel has, which is narrow farther down.
        is_narrow = one.is_round or free(_DOWN * one.narrow) <= 0.5
        found[own[row]] = is_narrow and free(2 * one.wide) > 0
    return found


def _meet_wall(index: SurfaceIndex, spot_of: Indices, middles: Points, radii: Floats) -> Flags:
    """Mask (k,) of the spheres, each below the spot of its number, that meet wall outside of it."""
    query, triangle, _ = index.near(middles, radii)
    is_wall = spot_of[triangle] != query
    query, triangle = query[is_wall], triangle[is_wall]
    away = norm(index.closest_points(middles[query], triangle) - middles[query])
    found = np.zeros(len(middles), dtype=bool)
    found[query[away < radii[query]]] = True
    return found


def _free(
    index: SurfaceIndex,
    spot_of: Indices,
    number: int,
    center: Floats,
    inward: Floats,
    reach: float,
) -> float:
    """Share of straight lines from a spot's center into the lumen as long as `reach`, mm.

    Lines meet triangles that are not the spot's own as in Moeller and Trumbore, Fast, Minimum
    Storage Ray/Triangle Intersection, J Graph Tools 2 (1997).
    """
    triangle = index.near(center[None], np.array([reach])).triangle
    corners = index.corners[triangle[spot_of[triangle] != number]]
    ways = _cone(inward)
    first = corners[:, 0]
    u, v = corners[:, 1] - first, corners[:, 2] - first
    from_first = center - first
    normal = np.cross(u, v)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = -1.0 / (ways @ normal.T)
        s = (ways @ np.cross(v, from_first).T) * scale
        t = (ways @ np.cross(from_first, u).T) * scale
        length = (from_first * normal).sum(axis=1) * scale
        is_met = (s >= -ROUNDING) & (t >= -ROUNDING) & (s + t <= 1 + ROUNDING)
        is_met &= (length > 0) & (length <= reach)
    return 1.0 - float(is_met.any(axis=1).mean())


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
