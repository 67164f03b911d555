"""Which inscribed spheres touch the surface ahead of them, as before an end of the vessel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import compacted, dot, may_meet_box
from ..validation import Flags, Floats, Indices, Points, Triangles
from .spheres import InscribedSpheres, LocalSurface

ROUND = 0.98
"""Inscribed over equivalent diameter from which a sphere fills its section: no end is nearer."""

TOUCH = 1e-3
"""Share of its radius by which a surface may be farther from a sphere's center and touch it."""

IN_SURFACE = 1e-6
"""mm."""


BESIDE = 4.0
"""Of the radius of the lumen: no farther from its station is a sphere, or what it touches."""


class SurfacePart(NamedTuple):
    """Some triangles of a surface."""

    points: Points
    """Their corners, and others."""
    triangles: Triangles
    """(k, 3) by the numbers of these points."""
    numbers: Indices
    """(k,) in the whole surface."""


def part_near(points: Points, triangles: Triangles, stations: Points, radius: float) -> SurfacePart:
    """The part of a surface that may touch spheres near some stations of a lumen, so wide.

    Two points of no triangle, corners of the whole surface's box, keep it as large: a sphere that
    leaves it is outside.
    """
    low, high = stations.min(axis=0) - BESIDE * radius, stations.max(axis=0) + BESIDE * radius
    numbers = np.flatnonzero(may_meet_box(points, triangles, low, high))
    near, kept = compacted(points, triangles.take(numbers, axis=0))
    return SurfacePart(np.vstack([near, points.min(axis=0), points.max(axis=0)]), kept, numbers)


def touches(
    points: Points, triangles: Triangles, outward: Points, spheres: InscribedSpheres, cosine: float
) -> Flags:
    """Which spheres (k,) touch the surface in their outward direction (k, 3), so nearly.

    One that reaches through it was measured without what is there, and counts. One that is unknown,
    or has climbed out of the surface, touches nothing.
    """
    found = np.zeros(len(outward), dtype=bool)
    known = np.flatnonzero(np.isfinite(spheres.radii))
    if len(known):
        centers, radii = spheres.at(known)
        # Of a sphere of radius 0 rounding tells what it touches.
        reach = np.maximum((1 + TOUCH) * radii, IN_SURFACE)
        surface = LocalSurface(points, triangles, centers)
        query, triangle, _ = surface.near(centers, reach)
        offset = surface.index.closest_points(centers.take(query, axis=0), triangle)
        offset -= centers.take(query, axis=0)
        distance = np.linalg.norm(offset, axis=1)
        along = dot(offset, outward[known[query]])
        is_ahead = (distance <= reach[query]) & (along >= cosine * distance)
        is_through = distance < (1 - TOUCH) * radii[query]
        # Of a center in the surface itself, rounding tells the direction.
        found[known[query[is_ahead | is_through | (distance < IN_SURFACE)]]] = True
    return found


def fills(spheres: InscribedSpheres, equivalent: Floats) -> Flags:
    """Which spheres (n,) fill their sections of these equivalent diameters (n,)."""
    return np.asarray(2 * spheres.radii > ROUND * equivalent)
