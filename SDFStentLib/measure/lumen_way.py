"""The way through a lumen without centerline, from sphere to sphere."""

from __future__ import annotations

import numpy as np

from ..geometry import Surface, cut, length
from ..validation import Floats, Points
from .inscribed import inscribed_spheres
from .wall_map import near_wall

_STEP = 0.5
"""Step, as a fraction of the radius."""

_NARROWEST = 0.05
"""Inscribed radius below which a lumen ends, mm."""

_BESIDE = 2.0
"""Wall beyond the reach that may limit a sphere, in radii of the first sphere and reaches."""


def through_lumen(surface: Surface, axis: Points, reach: float) -> Points:
    """Points (n, 3) beyond the end of an axis, for `reach` mm or to the end of the lumen.

    Each sphere's center is free in the plane across the way so far.
    """
    found, travelled = [axis[-1]], 0.0
    first = inscribed_spheres(surface.points, surface.triangles, axis[-1:], axis[-1:] - axis[-2:-1])
    radius = float(first.radii[0])
    near = near_wall(surface, axis[-1:], _BESIDE * (reach + radius))
    heading = heading_of(axis, max(radius, 1e-6)) if radius > _NARROWEST else np.zeros(3)
    # Ends: every step goes on by half the narrowest radius at least, or what is left.
    while radius > _NARROWEST and travelled < reach:
        step = min(_STEP * radius, reach - travelled)
        ahead = found[-1] + step * heading
        center, radii = inscribed_spheres(near.points, near.triangles, ahead[None], heading[None])
        # A sphere that shrinks so fast stands before the end of the vessel.
        if not radii[0] > radius - 0.5 * step:
            break
        # Half the way to the middle: the way bends no faster than the vessel.
        following = (ahead + center[0]) / 2
        travelled += float(np.linalg.norm(following - found[-1]))
        turned = heading + 0.5 * (following - found[-1]) / step
        heading, radius = turned / np.linalg.norm(turned), float(radii[0])
        found.append(following)
    return np.array(found[1:]).reshape(-1, 3)


def heading_of(axis: Points, window: float) -> Floats:
    """Unit direction in which a polyline ends, over its last `window` mm."""
    total = length(axis)
    back = cut(axis, max(0.0, total - window), total)[0]
    return np.asarray((axis[-1] - back) / np.linalg.norm(axis[-1] - back))
