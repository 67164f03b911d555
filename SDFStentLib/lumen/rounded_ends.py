"""Inscribed spheres before a closed end of the vessel that is no flat cap.

Nearer to what closes an end than its own radius a sphere touches that first, and the vessel would
seem to narrow to nothing toward every in- and outlet. Flat caps are left out before spheres are
looked for (`wall_of`). Rounded or bulged, an end is no wall either: the sphere is measured against
the wall beside and behind its station only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import (
    Line,
    SurfaceIndex,
    box_of,
    compacted,
    connected,
    dot,
    face_normals,
    may_meet_box,
    product,
)
from ..validation import Flags, Floats, Points, Triangles
from .spheres import InscribedSpheres, inscribed_spheres
from .stations import Stations
from .tolerances import ALIKE, ASKEW, CENTERED, END_REACH, FARTHEST, NOTHING, OWN_WIDTH


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
        near = np.flatnonzero((to_end <= END_REACH * lumen) & (equivalent > 0))
        # A sphere that fills its section touches no end.
        near = near[~_fills(present, equivalent)[near]]
        outward = sign * directions
        is_ahead = _touches(points, triangles, outward[near], present.at(near), ASKEW)
        touching = near[is_ahead | np.isnan(radii[near])]
        if not len(touching):
            continue
        widest = float(lumen[near].max())
        if not _is_closed(points, triangles, stations[end], outward[end], widest):
            continue
        part = _part_near(points, triangles, stations[touching], widest)
        for i in touching:
            own = part[1][_is_wall(*part, stations[i], outward[i], lumen[i])]
            at = slice(i, i + 1)
            centers[at], radii[at] = inscribed_spheres(part[0], own, stations[at], directions[at])
        # One that is wider than the section has climbed out through the open end.
        climbed = touching[~(2 * radii[touching] <= equivalent[touching])]
        centers[climbed], radii[climbed] = np.nan, np.nan
    return InscribedSpheres(centers, radii)


def _part_near(
    points: Points, triangles: Triangles, stations: Points, radius: float
) -> tuple[Points, Triangles]:
    """The part of a surface that may touch spheres near some stations of a lumen of this radius.

    Two further points, the corners of the whole surface's box, keep the box as large: a sphere
    that leaves it is outside.
    """
    low, high = stations.min(axis=0) - FARTHEST * radius, stations.max(axis=0) + FARTHEST * radius
    kept = triangles.compress(may_meet_box(points, triangles, low, high), axis=0)
    near, kept = compacted(points, kept)
    return np.vstack([near, *box_of(points)]), kept


def _touches(
    points: Points, triangles: Triangles, outward: Points, spheres: InscribedSpheres, cosine: float
) -> Flags:
    """Mask (k,) of the spheres that touch the surface in a cone about their direction (k, 3)
    outward.

    One that reaches through it was measured without what is there, and counts. One that is unknown,
    or has climbed out of the surface, touches nothing.
    """
    found = np.zeros(len(outward), dtype=bool)
    known = np.flatnonzero(np.isfinite(spheres.radii))
    if not len(known):
        return found
    centers, radii = spheres.at(known)
    # For a sphere of radius 0 rounding decides what it touches.
    reach = np.maximum(ALIKE * radii, NOTHING)
    ample = ALIKE * reach[:, None]
    low, high = (centers - ample).min(axis=0), (centers + ample).max(axis=0)
    near = may_meet_box(points, triangles, low, high)
    if not near.any():
        return found
    surface = SurfaceIndex(points, triangles.compress(near, axis=0))
    query, triangle, _ = surface.near(centers, reach)
    offset = surface.closest_points(centers.take(query, axis=0), triangle)
    offset -= centers.take(query, axis=0)
    distance = np.linalg.norm(offset, axis=1)
    along = dot(offset, outward[known[query]])
    is_ahead = (distance <= reach[query]) & (along >= cosine * distance)
    is_through = distance < radii[query] / ALIKE
    # For a center in the surface itself, rounding decides the direction.
    found[known[query[is_ahead | is_through | (distance < NOTHING)]]] = True
    return found


def _fills(spheres: InscribedSpheres, equivalent: Floats) -> Flags:
    """Mask (n,) of the spheres that fill their sections of these equivalent diameters (n,)."""
    return np.asarray(2 * ALIKE * spheres.radii > equivalent)


def _is_wall(
    points: Points, triangles: Triangles, station: Floats, outward: Floats, radius: float
) -> NDArray[np.bool_]:
    """Triangles (m,) that reach behind a station and do not turn across the axis near it."""
    heights = product(points - station, outward)
    highest = heights[triangles].max(axis=1)
    behind = heights[triangles].min(axis=1) < 0
    at_end = np.flatnonzero(behind & (highest > -ASKEW * radius))
    normals = face_normals(points, triangles[at_end])
    behind[at_end[np.abs(product(normals, outward)) >= ASKEW]] = False
    return np.asarray(behind)


def _is_closed(
    points: Points, triangles: Triangles, end: Floats, outward: Floats, radius: float
) -> bool:
    """Whether the surface beyond the last section ends soon after it.

    A vessel that turns aside goes on; so does one that an open rim ends, for nothing is in its way.
    """
    # What the rest of a large surface is plays no part.
    low, high = end - FARTHEST * radius, end + FARTHEST * radius
    triangles = triangles.compress(may_meet_box(points, triangles, low, high), axis=0)
    points, triangles = compacted(points, triangles)
    offset = points - end
    heights = product(offset, outward)
    distance = np.linalg.norm(offset, axis=1)
    beside = np.sqrt(np.maximum(distance**2 - heights**2, 0))
    ahead = (heights > 0) & (distance < FARTHEST * radius)
    corners = np.asfortranarray(triangles).T
    sides = np.hstack([corners[[0, 1]], corners[[1, 2]], corners[[2, 0]]])
    sides = sides[:, ahead[sides[0]] | ahead[sides[1]]]
    within = ahead[sides[0]] & ahead[sides[1]]
    label = connected(len(points), *sides[:, within])[1]
    # Sides that the plane cuts near the axis begin the parts that belong to this vessel.
    low, high = sides[:, ~within & (heights[sides].min(axis=0) <= 0)]
    over = np.where(ahead[low], low, high)
    own = ahead & np.isin(label, label[over[beside[over] < OWN_WIDTH * radius]])
    return bool(
        own.any()
        and heights[own].max() < OWN_WIDTH * radius
        and beside[own].max() < OWN_WIDTH * radius
        and beside[own].min() < CENTERED * radius
    )
