"""The largest empty balls inside of a closed surface, and how one leads to the next.

Every tetrahedron of the Delaunay triangulation of a surface's points has a ball through its corners
that holds no other point. The centers of those inside are the surface's skeleton, as fine as its
triangles are, whatever the width of the vessel (Amenta, Choi and Kolluri, 2001; VMTK looks for its
centerlines among them as well, see Antiga and Steinman, 2004).
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from ..geometry import (
    Edges,
    Surface,
    dot,
    edges,
    in_blocks,
    median_edge,
    norm,
    signed_volume,
    vertex_normals,
)
from ..threads import side_by_side, threads
from ..validation import Flags, Floats, Indices, Points, Triangles

SHAKEN = 1e-3
"""Share of the median edge by which every point is moved: many points of a wall as regular as that
of a synthetic tube lie on one sphere, which leaves the triangulation open."""

QHULL = "Qbb Qc Qz Q12 Q7"
"""Options of Qhull (qhull.org/html/qh-optq.htm): those of SciPy, and Q7, facets depth first instead
of breadth first. That takes a fifth less time for the points of a wall, by measurement."""

FEW = 32
"""One point in so many tells in a fiftieth of the time how far balls reach beyond the middle."""

SPARE = 1.1
"""Factor on that reach: in 20 surfaces with so `MANY` points, of vessels, 1.001 was enough."""

MANY = 10_000
"""Number of points from which on that is done: the balls of as many take a quarter of a second."""


class InnerBalls(NamedTuple):
    """Balls inside of a surface, and which of them are neighbors."""

    centers: Points
    """(n, 3), mm."""
    radii: Floats
    """(n,), mm: the distance of each center from the surface's points."""
    links: Indices
    """(k, 2) balls with three of the surface's points in common."""
    at_wall: Floats
    """Radius of the widest ball that touches each point of the surface, mm; 0 where none does."""

    @property
    def link_lengths(self) -> Floats:
        """Distances (k,) of the centers of linked balls, mm."""
        one, other = self.links.T
        return norm(self.centers[one] - self.centers[other])


class _Inner(NamedTuple):
    """Tetrahedra of which the balls are inside."""

    corners: Indices
    """(n, 4), ascending in each;"""
    centers: Points
    """(n, 3) of their balls, mm,"""
    radii: Floats
    """(n,) and their radii, mm."""

    def in_order(self) -> _Inner:
        """They, by their corners: in what order they were found says nothing."""
        return self.at(np.lexsort(self.corners.T[::-1]))

    def at(self, which: Indices) -> _Inner:
        """Some of them."""
        corners, centers, radii = self
        return _Inner(corners.take(which, axis=0), centers.take(which, axis=0), radii.take(which))


def inner_balls(surface: Surface) -> InnerBalls:
    """The empty balls inside of a surface.

    Between the ends of a side that is longer than the lumen is wide, balls would bulge out of the
    wall: such sides are halved, as long as there are less than `MANY` points or twice as many.

    Parameters
    ----------
    surface : Surface
        Closed, mm; several closed parts are several sets of balls without links between them.
    """
    count, found = len(surface.points), _balls_inside(surface)
    # Ends: sides become half as long, and points more.
    while len(surface.points) < max(2 * count, MANY):
        sides = edges(surface.triangles)
        one, other = sides.vertices.T
        lengths = norm(surface.points[one] - surface.points[other])
        widths = 2 * np.maximum(found.at_wall[one], found.at_wall[other])
        is_long = (lengths > widths) & (widths > 0)
        if not is_long.any():
            break
        surface = _halved(surface, sides, is_long)
        found = _balls_inside(surface)
    return found._replace(at_wall=found.at_wall[:count])


def _halved(surface: Surface, sides: Edges, is_long: Flags) -> Surface:
    """The surface with a point in the middle of some of its sides, behind the others."""
    points = surface.points
    middles = points[sides.vertices[is_long]].mean(axis=1)
    number = np.full(len(is_long), -1)
    number[is_long] = len(points) + np.arange(len(middles))
    corners, halves = surface.triangles, number[sides.face_edges]
    for _ in range(3):  # the first side of all triangles, then the second, then the third
        is_halved = halves[:, 0] >= 0
        (a, b, c), (half, second, third) = corners[is_halved].T, halves[is_halved].T
        done = np.full(len(a), -1)
        parts = np.column_stack([a, half, c]), np.column_stack([half, b, c])
        left = np.column_stack([done, done, third]), np.column_stack([done, second, done])
        corners = np.roll(np.vstack([corners[~is_halved], *parts]), -1, axis=1)
        halves = np.roll(np.vstack([halves[~is_halved], *left]), -1, axis=1)
    return Surface(np.vstack([points, middles]), corners)


def _balls_inside(surface: Surface) -> InnerBalls:
    triangles = surface.wound_triangles
    outward = vertex_normals(surface.points, triangles)
    outward *= np.sign(signed_volume(surface.points, triangles))
    reach = SHAKEN * median_edge(surface.points, triangles)
    shift = np.random.default_rng(0).uniform(-reach, reach, surface.points.shape)
    points = surface.points + shift
    found = _by_halves(points, outward) if threads() > 1 and len(points) >= MANY else None
    corners, centers, radii = (found or _inner(points, outward)).in_order()
    at_wall = np.zeros(len(points))
    for corner in corners.T:
        np.maximum.at(at_wall, corner, radii)
    return InnerBalls(centers, radii, _links(corners, triangles), at_wall)


def _by_halves(points: Points, outward: Floats) -> _Inner | None:
    """The same as of `_inner`, in two threads; None where a ball is too large for that."""
    axis = int(np.ptp(points, axis=0).argmax())
    one, other = side_by_side(partial(_half, points, outward, axis), (1, -1))
    if one is None or other is None:
        return None
    return _Inner(
        np.concatenate([one.corners, other.corners]),
        np.concatenate([one.centers, other.centers]),
        np.concatenate([one.radii, other.radii]),
    )


def _half(points: Points, outward: Floats, axis: int, side: int) -> _Inner | None:
    """Those whose centers are on one side of the middle along an axis, 1 for its beginning.

    Looks at the points there, and as far beyond as balls may reach. None where one may hold points
    that were not looked at.
    """
    from scipy.spatial import QhullError

    middle = np.median(points[:, axis])
    heights = side * (points[:, axis] - middle)

    def among(near: Indices) -> tuple[_Inner, float]:
        """Those on this side among some points, and how far beyond the middle balls reach."""
        found = _inner(points.take(near, axis=0), outward.take(near, axis=0))
        found = found._replace(corners=near.take(found.corners))
        height = side * (found.centers[:, axis] - middle)
        is_own = (height < 0) | ((height == 0) & (side > 0))
        # A place in a ball of all points is in one of some of them that is as large at least.
        is_beside = (heights.take(found.corners) < 0).any(axis=1)
        reach = found.radii + np.where(is_own, height, 0.0)
        reach = reach.compress(is_own | is_beside)
        return found.at(np.flatnonzero(is_own)), float(reach.max(initial=0.0))

    try:
        end = SPARE * among(np.arange(0, len(points), FEW))[1]
        near = np.flatnonzero(heights <= end)
        if len(near) == len(points):
            return None
        found, reach = among(near)
    except QhullError:  # all in a plane
        return None
    return found if reach <= end else None


def _inner(points: Points, outward: Floats) -> _Inner:
    """Tetrahedra of points (n, 3) whose balls are inside, by the outward normals (n, 3) there."""
    from scipy.spatial import Delaunay

    def inside(block: Indices) -> Floats:
        centers, radii = _balls(points, block)
        for corner in block.T:
            ways = points.take(corner, axis=0) - centers
            radii[~(dot(ways, outward.take(corner, axis=0)) > 0)] = np.nan
        return np.vstack([centers.T, radii])

    corners = np.sort(Delaunay(points, qhull_options=QHULL).simplices, axis=1).astype(np.int64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        *centers, radii = in_blocks(inside, corners)
    return _Inner(corners, np.stack(centers, axis=1), radii).at(np.flatnonzero(np.isfinite(radii)))


def _balls(points: Points, corners: Indices) -> tuple[Points, Floats]:
    """Centers (n, 3) and radii (n,) of the balls through four corners (n, 4); not finite where the
    four lie in a plane."""
    first = points.take(corners[:, 0], axis=0)
    b, c, d = (points.take(corner, axis=0) - first for corner in corners.T[1:])
    over_d, over_c, over_b = np.cross(b, c), np.cross(d, b), np.cross(c, d)
    offset = dot(b, b)[:, None] * over_b + dot(c, c)[:, None] * over_c
    offset = (offset + dot(d, d)[:, None] * over_d) / (2 * dot(b, over_b))[:, None]
    return first + offset, norm(offset)


def _links(corners: Indices, triangles: Triangles) -> Indices:
    """Pairs (k, 2) of tetrahedra that share a side which is none of the surface: across that the
    way leads through the wall."""
    count = int(max(corners.max(initial=0), triangles.max(initial=0))) + 1
    places = np.array([count * count, count, 1])
    sides = np.concatenate([np.delete(corners, one, axis=1) @ places for one in range(4)])
    order = np.argsort(sides)
    ordered = sides[order]
    shared = np.flatnonzero(ordered[1:] == ordered[:-1])
    is_wall = np.isin(ordered[shared], np.sort(triangles, axis=1) @ places)
    both = shared[~is_wall, None] + [0, 1]
    return np.sort(order[both] % len(corners), axis=1)
