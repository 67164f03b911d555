"""Faces of a surface that are turned over, without height, or slivers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..geometry import (
    NO_HEIGHT,
    compacted,
    corners_in_columns,
    dot,
    face_normals,
    faces_at,
    in_blocks,
    paired_sides,
)
from ..validation import Flags, Floats, Indices, Place, Points, Triangles, as_place, read_only

_ROUNDING = 8 * 2.0**-53
"""Relative rounding of a cross product: two sides below it count as parallel."""

SLIVER_DEG = 1.0
"""Smallest angle, degrees, below which a triangle is a sliver: its longest edge is at least 57
times its height. MeshLab calls 40 times a defect (its filter "Remove T-Vertices")."""

OPPOSED = -0.2
"""Mean cosine with the normals of the faces around, below which a face is turned over.

One face upside down in a flat wall has (3 - 15) / 18 = -0.67. Faces in pleats of tissue beside a
stent, which intersect nothing, came out just below 0 on the pulmonary artery.
"""


DOUBTFUL = 0.3
"""Mean cosine above which no face lies upside down. Two faces of a flat cap that a stent pushed out
over its rim had -0.07: they oppose the cap, and the wall at their other corners is at right angles
to both."""


def degenerate_triangles(
    points: Points, triangles: Triangles, among: Indices | None = None
) -> Indices:
    """Indices (k,) of triangles without height: a corner named twice, or in a line within
    `NO_HEIGHT`.

    The rounding of the coordinates counts as well: two corners at one place, or a corner on the
    opposite side, differ by the last bit of the numbers from which they were computed.
    """
    judged = np.arange(len(triangles)) if among is None else among
    columns = np.ascontiguousarray(points.T)

    def lacks_height(block: Triangles) -> Flags:
        corners = corners_in_columns(columns, block)
        lengths, areas = _sides_and_areas(corners)
        least = np.maximum(_ROUNDING * np.abs(corners).max(axis=(0, 1)), NO_HEIGHT * lengths[2])
        return areas <= least * lengths[2]

    return judged[in_blocks(lacks_height, triangles.take(judged, axis=0))]


def smallest_angles(points: Points, triangles: Triangles) -> Floats:
    """Smallest angle (m,) of every triangle, degrees; 0 for one without area."""
    lengths, areas = _sides_and_areas(corners_in_columns(np.ascontiguousarray(points.T), triangles))
    # The smallest angle lies between the two longer sides.
    between = lengths[1] * lengths[2]
    sine = np.divide(areas, between, out=np.zeros(len(areas)), where=between > 0)
    return np.asarray(np.rad2deg(np.arcsin(np.minimum(sine, 1.0))))


def inverted_triangles(
    points: Points, triangles: Triangles, among: Indices | None = None
) -> Indices:
    """Triangles turned over against their neighborhood, ascending.

    A face counts as turned over when its normal opposes the unit normals of the faces at its three
    corners by a mean cosine below `OPPOSED`, itself included; thus a neighbor across an edge counts
    twice, one at a corner once. This finds one face, or a few side by side, that lie upside down in
    a smooth wall. It leaves alone a face on a sharp ridge or in a pleat, where about as many
    neighbors agree with it as oppose it, and the corners of a box, unless it is folded flat onto a
    neighbor: nothing can be meshed between these, and the last bits of their coordinates decide
    whether they intersect. Faces without area have no normal and do not count either way.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Consistently wound.
    among : (k,) array, optional
        Indices of the triangles to judge; by default all.
    """
    judged = np.arange(len(triangles)) if among is None else among
    if not len(judged):
        return judged
    at_judged = np.zeros(len(points), dtype=bool)
    at_judged[triangles.take(judged, axis=0)] = True
    near = np.flatnonzero(faces_at(at_judged, triangles))
    used, local = compacted(points, triangles.take(near, axis=0))
    normals = face_normals(used, local)
    first, second, third = local.T

    def around(values: NDArray[Any]) -> NDArray[np.float64]:
        """Sum of the values of the faces at the three corners of each face."""
        at_corner = np.bincount(local.ravel(), np.repeat(values, 3), minlength=len(used))
        return at_corner[first] + at_corner[second] + at_corner[third]

    agreement = sum(column * around(column) for column in normals.T)
    x, y, z = normals.T != 0
    has_normal = x | y | z
    at_all = around(has_normal)
    is_turned = has_normal & (agreement < OPPOSED * at_all)
    doubtful = has_normal & ~is_turned & (agreement < DOUBTFUL * at_all)
    is_turned[_folded_flat(used, local, doubtful)] = True
    is_judged = np.zeros(len(triangles), dtype=bool)
    is_judged[judged] = True
    return near[is_turned & is_judged[near]]


def _folded_flat(points: Points, triangles: Triangles, doubtful: Flags) -> Indices:
    """Indices of the doubtful faces (m,) that lie on a neighbor beyond a side, within
    `NO_HEIGHT`."""
    if not doubtful.any():
        return np.empty(0, dtype=np.int64)
    at_doubtful = np.zeros(len(points), dtype=bool)
    at_doubtful[triangles[doubtful]] = True
    near = np.flatnonzero(faces_at(at_doubtful, triangles))
    face, side = np.divmod(paired_sides(triangles[near]).T, 3)
    face = near[face]
    start, end, apex = (points[triangles[face, (side + k) % 3]] for k in range(3))
    along = end[0] - start[0]
    one, other = np.cross(along, apex[0] - start[0]), np.cross(along, apex[1] - start[0])
    size = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    apart = np.linalg.norm(np.cross(one, other), axis=1)
    is_folded = (dot(one, other) > 0) & (apart <= NO_HEIGHT * size)
    folded = face[:, is_folded].ravel()
    return folded[doubtful[folded]]


def _sides_and_areas(corners: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Side lengths (3, m) in ascending order, and twice the areas (m,), of `corners_in_columns`."""
    first, second, third = corners.swapaxes(0, 1)
    (ux, uy, uz), side, (vx, vy, vz) = second - first, third - second, first - third
    u, v, w = (np.sqrt(x * x + y * y + z * z) for x, y, z in ((ux, uy, uz), (vx, vy, vz), side))
    low, high = np.minimum(u, v), np.maximum(u, v)
    lengths = np.stack(
        [np.minimum(low, w), np.maximum(low, np.minimum(high, w)), np.maximum(high, w)]
    )
    normal = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return lengths, np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)


MUCH_WORSE = 0.5
"""Share of its smallest angle that a triangle must have lost to be called much worse."""


class Slivers(NamedTuple):
    """The slivers of a surface.

    Attributes
    ----------
    triangles : (k,) array
        Numbers of the slivers, ascending.
    angle, before : float
        Smallest angle of the worst one, and that of the same triangle before, degrees; NaN for
        none.
    at : (x, y, z), optional
        Middle of the worst one, mm.
    """

    triangles: Indices
    angle: float = float("nan")
    before: float = float("nan")
    at: Place | None = None

    def cautions(self) -> tuple[Caution, ...]:
        """A caution for the person who will mesh the surface; none without slivers."""
        if not len(self.triangles):
            return ()
        numbers = {"triangles": len(self.triangles), "angle_deg": self.angle}
        if np.isnan(self.before):
            return (Caution("slivers", numbers, self.at),)
        return (Caution("new-slivers", {**numbers, "before_deg": self.before}, self.at),)

    def as_dict(self) -> dict[str, Any]:
        """The slivers as a part of a report."""
        found = bool(len(self.triangles))
        return {
            "triangle_ids": self.triangles.tolist(),
            "worst_deg": self.angle if found else None,
            "worst_before_deg": None if np.isnan(self.before) else self.before,
            "worst_at_mm": None if self.at is None else list(self.at),
        }


def slivers_among(
    points: Points, triangles: Triangles, among: Indices, before: Points | None = None
) -> Slivers:
    """The triangles with an angle below `SLIVER_DEG`; only those that became so, where `before` is
    given.

    Parameters
    ----------
    points : (n, 3) array
        Points as stored, but in mm.
    triangles : (m, 3) array
    among : (k,) array
        Indices of the triangles to judge, ascending.
    before : (n, 3) array, optional
        Places of the points before: then only triangles that lost `MUCH_WORSE` of their smallest
        angle count.
    """
    angles = smallest_angles(points, triangles[among])
    found = angles < SLIVER_DEG
    among, angles = among[found], angles[found]
    were = np.full(len(among), np.nan)
    if before is not None:
        were = smallest_angles(before, triangles[among])
        found = angles <= (1 - MUCH_WORSE) * were
        among, angles, were = among[found], angles[found], were[found]
    if not len(among):
        return Slivers(read_only(among))
    worst = int(angles.argmin())
    middle = as_place(points[triangles[among[worst]]].mean(axis=0))
    return Slivers(read_only(among), float(angles[worst]), float(were[worst]), middle)
