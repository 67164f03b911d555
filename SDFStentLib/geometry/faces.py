"""Triangulated surfaces: areas, normals, volume, orientation, and the parts that a model names.

For arrays that are known to be sound, of a whole `Surface` or a part of one: `points` (n, 3), mm,
and `triangles` (m, 3). Faces of a well oriented surface turn counterclockwise seen from outside, so
that normals point out of the lumen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..validation import (
    Flags,
    Floats,
    Indices,
    InputError,
    Points,
    Triangles,
    one_line,
    read_only,
)
from .rows import in_blocks, used_points
from .topology import consistently_wound, edges

NO_HEIGHT = 1e-4
"""Height over the longest edge at and below which a triangle counts as one without height.

Its smallest angle is below 0.006 degrees then, and edges of 0.1 mm leave it 1e-5 mm, which is what
single precision resolves at 100 mm from the origin. The flattest triangle of the real anatomies has
3.3e-4; points of a cap that a stent pushes out to one place left 5e-5 and less.
"""


def face_areas(points: Points, triangles: Triangles) -> Floats:
    """Area (m,) of every face, mm^2."""
    columns = np.ascontiguousarray(points.T)
    return in_blocks(lambda block: 0.5 * _lengths(_area_vectors(columns, block)), triangles)


def face_normals(points: Points, triangles: Triangles) -> Floats:
    """Unit normals (m, 3); zero for a face without area."""
    columns = np.ascontiguousarray(points.T)
    found = in_blocks(lambda block: _unit(_area_vectors(columns, block)), triangles)
    return np.ascontiguousarray(found.T)


def vertex_normals(points: Points, triangles: Triangles) -> Floats:
    """Unit normals (n, 3) of the points: the faces' normals, weighted with their areas.

    Zero at a point without a face and where the faces cancel.
    """
    corners, columns = triangles.ravel(), np.ascontiguousarray(points.T)
    sums = [
        np.bincount(corners, weights=np.repeat(column, 3), minlength=len(points))
        for column in in_blocks(lambda block: _area_vectors(columns, block), triangles)
    ]
    return np.ascontiguousarray(_unit(np.stack(sums)).T)


def signed_volume(points: Points, triangles: Triangles) -> float:
    """Volume inside a closed surface, mm^3; positive when the faces look outward.

    For an open surface it is the volume of the cone over it from the mean of its corners, which has
    no meaning of its own.
    """
    return float(_cone_volumes(points, triangles).sum())


def oriented_triangles(
    points: Points, triangles: Triangles, inside: Points | None = None
) -> Triangles:
    """Triangles with one winding per connected part, outward where that is defined.

    A closed part is turned so that its volume is positive. An open part is turned away from the
    nearest of the `inside` points; without them it keeps the winding of the majority of its
    faces. A part that cannot be oriented keeps what it came with. Corners are reordered within
    their triangle only.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
    inside : (k, 3) array, optional
        Points in the lumen, for instance the centerline, mm.
    """
    triangles, part = consistently_wound(triangles)
    outward = np.bincount(part, weights=_cone_volumes(points, triangles))

    found = edges(triangles)
    is_free = np.zeros(len(outward), dtype=bool)
    is_free[part[found.sides[found.offsets[:-1][found.face_counts % 2 == 1]] // 3]] = True
    outward[is_free] = 0.0
    if inside is not None and is_free.any():
        away = _outward_flux(points, triangles, inside)
        outward[is_free] = np.bincount(part, weights=away)[is_free]

    turn = (outward < 0)[part]
    triangles[turn] = triangles[turn][:, ::-1]
    return triangles


def side_lengths(points: Points, triangles: Triangles) -> Floats:
    """Lengths (m, 3) of the sides of triangles (m, 3), mm."""
    sides = points[triangles] - points[triangles[:, [1, 2, 0]]]
    return np.asarray(np.linalg.norm(sides, axis=2))


def median_edge(points: Points, triangles: Triangles) -> float:
    """Median length of the triangles' sides, mm; one between two triangles counts twice."""
    return float(np.median(side_lengths(points, triangles)))


def faces_at(vertices: NDArray[np.bool_], triangles: Triangles) -> NDArray[np.bool_]:
    """Mask (m,) of the triangles with a corner at one of the marked vertices (n,)."""
    # Column by column: `any` along an axis of three takes NumPy several times longer.
    first, second, third = triangles.T
    return vertices[first] | vertices[second] | vertices[third]


def may_meet_box(points: Points, triangles: Triangles, low: Floats, high: Floats) -> Flags:
    """Mask (m,) of triangles that may meet the box: not those wholly beyond one side of it."""
    code = np.zeros(len(points), dtype=np.uint8)
    # Products with bits take a third of the time of shifts.
    for axis, values in enumerate(points.T):
        code |= (values < low[axis]).view(np.uint8) * np.uint8(1 << 2 * axis)
        code |= (values > high[axis]).view(np.uint8) * np.uint8(2 << 2 * axis)
    return (code[triangles[:, 0]] & code[triangles[:, 1]] & code[triangles[:, 2]]) == 0


def compacted(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    """Only the points that some triangles use, in their order, and the triangles in new numbers."""
    used = used_points(triangles)
    number = np.empty(len(points), dtype=np.int64)
    number[used] = np.arange(len(used))
    return points.take(used, axis=0), number.take(triangles)


# Vectors stand in columns, (3, m): sums along a last axis of three take NumPy several times longer.


def corners_in_columns(columns: Floats, triangles: Triangles) -> Floats:
    """Coordinates (coordinate, corner, face) by columns (3, n) of the points."""
    return columns.take(np.ascontiguousarray(triangles.T), axis=1)


def _area_vectors(columns: Floats, triangles: Triangles) -> Floats:
    """Normals (3, m) whose length is twice the area."""
    corners = corners_in_columns(columns, triangles)
    return _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _cone_volumes(points: Points, triangles: Triangles) -> Floats:
    """Signed volumes (m,) of the cones over the faces from the mean of all corners.

    Cones from the origin would cancel to less than their rounding on a surface far from it.
    """
    corners = corners_in_columns(np.ascontiguousarray(points.T), triangles)
    corners -= corners.mean(axis=(1, 2), keepdims=True)
    return _dot(corners[:, 0], _cross(corners[:, 1], corners[:, 2])) / 6.0


def _cross(one: Floats, other: Floats) -> Floats:
    (a, b, c), (x, y, z) = one, other
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x])


def _dot(one: Floats, other: Floats) -> Floats:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _lengths(vectors: Floats) -> Floats:
    return np.sqrt(_dot(vectors, vectors))


def _unit(vectors: Floats) -> Floats:
    lengths = _lengths(vectors)
    return vectors / np.where(lengths > 0, lengths, 1.0)


def _outward_flux(points: Points, triangles: Triangles, inside: Points) -> Floats:
    """Flux (m,) through every face, positive where its normal points away from the nearest inside
    point."""
    # Imported here: scipy costs half a second, which a first frame should not pay.
    from scipy.spatial import cKDTree

    centers = points[triangles].mean(axis=1)
    nearest = inside[cKDTree(inside).query(centers)[1]]
    columns = np.ascontiguousarray(points.T)
    return _dot(_area_vectors(columns, triangles), _unit((centers - nearest).T))


_SAID = 3
"""Number of parts that are named one by one; the rest is counted."""


@dataclass(frozen=True, eq=False)
class NamedFaces:
    """The part of the model to which every triangle belongs, as SimVascular marks caps and walls.

    Parameters
    ----------
    ids : array_like of int, shape (m,)
        Number of the part to which each triangle belongs.
    names : mapping of int to str
        Names of the parts that have one.

    Raises
    ------
    InputError
        Ids that are no row of integers.
    """

    ids: Indices
    names: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ids = np.asarray(self.ids)
        if ids.ndim != 1 or not np.issubdtype(ids.dtype, np.integer):
            raise InputError(
                f"face ids: expected one whole number for every triangle, got {ids.dtype} of shape "
                f"{ids.shape}."
            )
        object.__setattr__(self, "ids", read_only(ids.astype(np.int64)))
        names = {number: one_line(name) for number, name in self.names.items()}
        object.__setattr__(self, "names", names)

    def most(self, triangles: ArrayLike) -> int:
        """The part to which most of some triangles (k,) belong."""
        kinds, counts = np.unique(self.ids[np.asarray(triangles)], return_counts=True)
        return int(kinds[np.argmax(counts)])

    def branch_name(self, ids: Sequence[int]) -> str:
        """Name of a branch that leads to some parts."""
        if len(ids) == 1 and ids[0] in self.names:
            return self.said(ids)
        return f"branch to {self.said(ids)}"

    def said(self, ids: Sequence[int]) -> str:
        """Names of some parts as words, such as "face 3" or "right pulmonary artery"."""
        words = [self.names.get(number, f"face {number}") for number in ids]
        if len(words) > _SAID:
            words = [*words[:_SAID], f"{len(words) - _SAID} more"]
        return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def checked_faces(faces: NamedFaces | None, triangle_count: int) -> NamedFaces | None:
    """The face ids themselves; `InputError` where their number is not that of the triangles."""
    if faces is not None and len(faces.ids) != triangle_count:
        raise InputError(
            f"face ids: expected one for each of {triangle_count} triangles, got {len(faces.ids)}; "
            "take them from the same file as the surface."
        )
    return faces
