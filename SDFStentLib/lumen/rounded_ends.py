"""Inscribed spheres before a closed end of the vessel that is no flat cap.

Rounded, leaning or bulged, such an end is no wall either. The sphere is measured against the wall
beside and behind its station only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry import Line, compacted, connected, face_normals, may_meet_box, product
from ..validation import Floats, Points, Triangles
from .caps import flat_caps
from .closed_ends import fills, part_near, touches
from .spheres import InscribedSpheres, inscribed_spheres
from .stations import Stations

AHEAD = np.cos(np.deg2rad(60.0))
"""A sphere that touches the surface so nearly along the axis may touch the end."""

NEAR = 1.2
"""The part of the radius of the lumen: nothing that closes the end is farther from a sphere's
station."""

CLOSED = 1.6
"""Distance in radii beyond the last station within which a closed vessel is over,"""

BESIDE = 1.5
"""and largest distance in radii of its wall from its axis there."""

LOOKED_AT = 3.0
"""Radii within which the surface is looked at for that."""


_APART = 3.0
"""Distance of walls that are looked at side by side, in extents of the part they are of."""


def past_rounded_ends(points: Points, triangles: Triangles, measured: Stations) -> InscribedSpheres:
    """Spheres, of which those limited by the closing of an end are measured anew without it.

    Spheres are NaN at stations where they are known to touch an end.
    """
    stations, directions, spheres, equivalent = measured
    arc = Line(stations).arc_lengths
    centers, radii = spheres.centers.copy(), spheres.radii.copy()
    for end, sign, to_end in ((0, -1.0, arc), (len(arc) - 1, 1.0, arc[-1] - arc)):
        present = InscribedSpheres(centers, radii)
        lumen = np.fmax(radii, equivalent / 2)
        near = np.flatnonzero((to_end <= NEAR * lumen) & (equivalent > 0))
        # A sphere that fills its section touches no end.
        near = near[~fills(present, equivalent)[near]]
        outward = sign * directions
        is_ahead = touches(points, triangles, outward[near], present.at(near), AHEAD)
        touching = near[is_ahead | np.isnan(radii[near])]
        if not len(touching):
            continue
        widest = float(lumen[near].max())
        if not _is_closed(points, triangles, stations[end], outward[end], widest):
            continue
        part = part_near(points, triangles, stations[touching], widest)
        own = [
            part.triangles[_is_wall(*part[:2], stations[i], outward[i], lumen[i])] for i in touching
        ]
        anew = _each_in_its_wall(part.points, own, stations[touching], directions[touching])
        # One that is wider than the section has climbed out through the open end.
        climbed = ~(2 * anew.radii <= equivalent[touching])
        anew.centers[climbed], anew.radii[climbed] = np.nan, np.nan
        centers[touching], radii[touching] = anew
    return InscribedSpheres(centers, radii)


def _each_in_its_wall(
    points: Points, walls: Sequence[Triangles], stations: Points, directions: Points
) -> InscribedSpheres:
    """The sphere of every station, each in a wall of its own. All are searched together, with the
    walls side by side."""
    apart = np.zeros((len(walls), 1, 3))
    apart[:, 0, 0] = _APART * np.ptp(points, axis=0).max() * np.arange(len(walls))
    copies = (points + apart).reshape(-1, 3)
    numbers = [wall + number * len(points) for number, wall in enumerate(walls)]
    found = inscribed_spheres(copies, np.concatenate(numbers), stations + apart[:, 0], directions)
    return InscribedSpheres(found.centers - apart[:, 0], found.radii)


def _is_wall(
    points: Points, triangles: Triangles, station: Floats, outward: Floats, radius: float
) -> NDArray[np.bool_]:
    """Triangles (m,) that reach behind a station and do not turn across the axis near it."""
    heights = product(points - station, outward)
    highest = heights[triangles].max(axis=1)
    behind = heights[triangles].min(axis=1) < 0
    at_end = np.flatnonzero(behind & (highest > -AHEAD * radius))
    normals = face_normals(points, triangles[at_end])
    behind[at_end[np.abs(product(normals, outward)) >= AHEAD]] = False
    return np.asarray(behind)


def _is_closed(
    points: Points, triangles: Triangles, end: Floats, outward: Floats, radius: float
) -> bool:
    """Whether the surface beyond the last section ends soon after it.

    A vessel that turns aside goes on; so does one that an open rim ends, for nothing is in its way.
    """
    # What the rest of a large surface is plays no part.
    low, high = end - LOOKED_AT * radius, end + LOOKED_AT * radius
    triangles = triangles.compress(may_meet_box(points, triangles, low, high), axis=0)
    points, triangles = compacted(points, triangles)
    offset = points - end
    heights = product(offset, outward)
    distance = np.linalg.norm(offset, axis=1)
    beside = np.sqrt(np.maximum(distance**2 - heights**2, 0))
    ahead = (heights > 0) & (distance < LOOKED_AT * radius)
    corners = np.asfortranarray(triangles).T
    sides = np.hstack([corners[[0, 1]], corners[[1, 2]], corners[[2, 0]]])
    sides = sides[:, ahead[sides[0]] | ahead[sides[1]]]
    within = ahead[sides[0]] & ahead[sides[1]]
    label = connected(len(points), *sides[:, within])[1]
    # Sides that the plane cuts near the axis begin the parts that belong to this vessel.
    low, high = sides[:, ~within & (heights[sides].min(axis=0) <= 0)]
    over = np.where(ahead[low], low, high)
    own = ahead & np.isin(label, label[over[beside[over] < BESIDE * radius]])
    if not (
        own.any()
        and heights[own].max() < CLOSED * radius
        and beside[own].max() < BESIDE * radius
        and beside[own].min() < 0.5 * radius
    ):
        return False
    # Of a flat cap the spheres are free already.
    return not flat_caps(points, triangles[own[triangles].all(axis=1)])
