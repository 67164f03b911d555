"""Inscribed spheres before a closed end of the vessel that is no flat cap.

Rounded, leaning or bulged, such an end is no wall either. The sphere is measured against the wall
beside and behind its station only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import Line, compacted, connected, face_normals, may_meet_box, product
from ..validation import Floats, Points, Triangles
from .caps import flat_caps
from .closed_ends import fills, part_near, touches
from .spheres import InscribedSpheres, inscribed_spheres
from .stations import Stations
from .tolerances import ASKEW, CENTERED, END_REACH, FARTHEST, OWN_WIDTH


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
        near = near[~fills(present, equivalent)[near]]
        outward = sign * directions
        is_ahead = touches(points, triangles, outward[near], present.at(near), ASKEW)
        touching = near[is_ahead | np.isnan(radii[near])]
        if not len(touching):
            continue
        widest = float(lumen[near].max())
        if not _is_closed(points, triangles, stations[end], outward[end], widest):
            continue
        part = part_near(points, triangles, stations[touching], widest)
        for i in touching:
            own = part.triangles[_is_wall(*part[:2], stations[i], outward[i], lumen[i])]
            at = slice(i, i + 1)
            centers[at], radii[at] = inscribed_spheres(
                part.points, own, stations[at], directions[at]
            )
        # One that is wider than the section has climbed out through the open end.
        climbed = touching[~(2 * radii[touching] <= equivalent[touching])]
        centers[climbed], radii[climbed] = np.nan, np.nan
    return InscribedSpheres(centers, radii)


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
    if not (
        own.any()
        and heights[own].max() < OWN_WIDTH * radius
        and beside[own].max() < OWN_WIDTH * radius
        and beside[own].min() < CENTERED * radius
    ):
        return False
    # Of a flat cap the spheres are free already.
    return not flat_caps(points, triangles[own[triangles].all(axis=1)])
