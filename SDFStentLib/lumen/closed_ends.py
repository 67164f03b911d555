"""Inscribed spheres near a closed end of a vessel, measured as if the end were open.

A flat cap is where a model was cut, not a wall. Nearer to it than its own radius a sphere touches
the cap first, and the vessel would seem to narrow to nothing toward every in- and outlet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import (
    Line,
    Surface,
    SurfaceIndex,
    box_of,
    compacted,
    dot,
    may_meet_box,
    nearest_distances,
)
from ..validation import Flags, Floats, Indices, Points, Triangles
from .caps import caps_across
from .spheres import InscribedSpheres, some_corners
from .stations import Stations
from .tolerances import ACROSS, ALIKE, END_REACH, FARTHEST, NOTHING


class SurfacePart(NamedTuple):
    """Some triangles of a surface."""

    points: Points
    """Corners of the triangles, and other points."""
    triangles: Triangles
    """(k, 3) indices of these points."""
    numbers: Indices
    """(k,) indices of the triangles in the whole surface."""


def part_near(points: Points, triangles: Triangles, stations: Points, radius: float) -> SurfacePart:
    """The part of a surface that may touch spheres near some stations of a lumen of this radius.

    Two further points, the corners of the whole surface's box, keep the box as large: a sphere
    that leaves it is outside.
    """
    low, high = stations.min(axis=0) - FARTHEST * radius, stations.max(axis=0) + FARTHEST * radius
    numbers = np.flatnonzero(may_meet_box(points, triangles, low, high))
    near, kept = compacted(points, triangles.take(numbers, axis=0))
    return SurfacePart(np.vstack([near, *box_of(points)]), kept, numbers)


def touches(
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


def fills(spheres: InscribedSpheres, equivalent: Floats) -> Flags:
    """Mask (n,) of the spheres that fill their sections of these equivalent diameters (n,)."""
    return np.asarray(2 * ALIKE * spheres.radii > equivalent)


class OpenWall(NamedTuple):
    """A surface without some of its caps."""

    triangles: Triangles
    """(k, 3) triangles that are left."""
    caps: Indices
    """(m,) indices of the other triangles in the surface."""


def open_at_ends(surface: Surface, axis: Points) -> OpenWall:
    """A surface without the flat caps across the ends of an axis (n, 3).

    Without them no sphere climbs along a cap, in many small steps, only to be measured without it.
    """
    points, triangles = surface.points, surface.triangles
    some = some_corners(points, triangles)
    reach = FARTHEST * float(nearest_distances(axis, some).max())
    is_capped = caps_across(surface, axis, reach)
    caps = np.flatnonzero(is_capped)
    return OpenWall(triangles.compress(~is_capped, axis=0) if len(caps) else triangles, caps)


def past_closed_ends(
    points: Points, triangles: Triangles, measured: Stations, caps: Indices
) -> Stations:
    """The stations, spheres that touch a closed end of the vessel measured anew without its cap.

    A sphere is NaN where it touches an end that is no flat cap, but for `caps`, triangles by number
    that counted as open already, such as a cap that a stent has bulged since; and where it climbs
    out through one that the axis meets askew. An equivalent diameter is NaN where a cap, a little
    askew, cuts the section off.
    """
    stations, directions, spheres, equivalent = measured
    arc = Line(stations).arc_lengths
    to_end = np.minimum(arc, arc[-1] - arc)
    # Sections may be NaN.
    near_end = to_end <= END_REACH * np.fmax(spheres.radii, equivalent / 2)
    at_end = np.flatnonzero(near_end & np.isfinite(spheres.radii))
    outward = np.where((arc < arc[-1] / 2)[:, None], -directions, directions)
    at_end = at_end[touches(points, triangles, outward[at_end], spheres.at(at_end), ACROSS)]
    if not len(at_end):
        return measured
    width = float(np.nanmax(np.concatenate([equivalent[at_end], 2 * spheres.radii])))
    points, triangles, numbers = part_near(points, triangles, stations[at_end], width)
    is_capped = np.isin(numbers, caps)
    kept, centers, radii = triangles[~is_capped], spheres.centers.copy(), spheres.radii.copy()
    closed = at_end[touches(points, kept, outward[at_end], spheres.at(at_end), ACROSS)]
    centers[closed], radii[closed] = np.nan, np.nan
    corners = points[triangles[is_capped].ravel()]
    cut = [i for i in at_end if _is_crossed(corners, stations[i], directions[i], width)]
    equivalent = equivalent.copy()
    equivalent[cut] = np.nan
    return measured._replace(spheres=InscribedSpheres(centers, radii), equivalent=equivalent)


def _is_crossed(points: Points, station: Floats, direction: Floats, width: float) -> bool:
    """Whether the plane across the axis has some of the points near the station on both sides."""
    offset = points - station
    offset = offset[dot(offset, offset) < width**2]
    heights = offset @ direction
    touch = (ALIKE - 1) * width
    return bool(len(heights) and heights.min() < -touch and heights.max() > touch)
