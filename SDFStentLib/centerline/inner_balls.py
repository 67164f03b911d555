"""The largest empty balls inside of a closed surface, and how one leads to the next.

Every tetrahedron of the Delaunay triangulation of a surface's points has a ball through its corners
that holds no other point. The centers of those inside are the surface's skeleton, as fine as its
triangles are, whatever the width of the vessel (Amenta, Choi and Kolluri, 2001; VMTK looks for its
centerlines among them as well, see Antiga and Steinman, 2004).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Surface, dot, median_edge, norm, signed_volume, vertex_normals
from ..validation import Floats, Indices, Points, Triangles

SHAKEN = 1e-3
"""Share of the median edge by which every point is moved: many points of a wall as regular as that
of a synthetic tube lie on one sphere, which leaves the triangulation open."""

QHULL = "Qbb Qc Qz Q12 Q7"
"""Options of Qhull (qhull.org/html/qh-optq.htm): those of SciPy, and Q7, facets depth first instead
of breadth first. That takes a fifth less time for the points of a wall, by measurement."""


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


def inner_balls(surface: Surface) -> InnerBalls:
    """The empty balls inside of a surface.

    Parameters
    ----------
    surface : Surface
        Closed, mm; several closed parts are several sets of balls without links between them.
    """
    from scipy.spatial import Delaunay

    triangles = surface.wound_triangles
    outward = vertex_normals(surface.points, triangles)
    outward *= np.sign(signed_volume(surface.points, triangles))
    reach = SHAKEN * median_edge(surface.points, triangles)
    shift = np.random.default_rng(0).uniform(-reach, reach, surface.points.shape)
    points = surface.points + shift
    found = Delaunay(points, qhull_options=QHULL)
    corners = found.simplices.astype(np.int64)
    centers, radii = _balls(points, corners)
    inside = np.flatnonzero(np.isfinite(radii))
    for corner in corners.T:  # half of those left are outside each time
        own = corner[inside]
        ways = points.take(own, axis=0) - centers.take(inside, axis=0)
        inside = inside[dot(ways, outward.take(own, axis=0)) > 0]
    corners, radii = corners[inside], radii[inside]
    number = np.full(len(centers) + 1, -1)  # the last for -1, no neighbor
    number[inside] = np.arange(len(inside))
    at_wall = np.zeros(len(points))
    for corner in corners.T:
        np.maximum.at(at_wall, corner, radii)
    links = _links(corners, number[found.neighbors[inside]], triangles)
    return InnerBalls(centers[inside], radii, links, at_wall)


def _balls(points: Points, corners: Indices) -> tuple[Points, Floats]:
    """Centers (n, 3) and radii (n,) of the balls through four corners (n, 4); not finite where the
    four lie in a plane."""
    first = points.take(corners[:, 0], axis=0)
    b, c, d = (points.take(corner, axis=0) - first for corner in corners.T[1:])
    over_d, over_c, over_b = np.cross(b, c), np.cross(d, b), np.cross(c, d)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        offset = dot(b, b)[:, None] * over_b + dot(c, c)[:, None] * over_c
        offset = (offset + dot(d, d)[:, None] * over_d) / (2 * dot(b, over_b))[:, None]
        return first + offset, norm(offset)


def _links(corners: Indices, neighbors: Indices, triangles: Triangles) -> Indices:
    """Pairs (k, 2) of tetrahedra that share a side which is none of the surface: across that the
    way leads through the wall. Each has its neighbors (n, 4), negative where there is none."""
    one, side = np.nonzero(neighbors > np.arange(len(corners))[:, None])
    other = neighbors[one, side]
    others = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
    shared = np.sort(np.take_along_axis(corners[one], others[side], axis=1), axis=1)
    count = int(max(corners.max(initial=0), triangles.max(initial=0))) + 1
    places = np.array([count * count, count, 1])
    is_wall = np.isin(shared @ places, np.sort(triangles, axis=1) @ places)
    return np.column_stack([one, other])[~is_wall]
