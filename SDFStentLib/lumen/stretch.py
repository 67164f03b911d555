"""The stretch and motion of a surface between two states, and the size of its triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Surface, as_surface, dot, in_blocks, state_of
from ..validation import Floats, Indices, InputError, Points, Triangles, as_points


class FaceStretch(NamedTuple):
    """Stretches of each face (m,), as ratios after / before: 1 is unchanged.

    `area` is the product of the other two. NaN at a face without area before.
    """

    area: Floats
    largest: Floats
    smallest: Floats


def face_stretches(
    before: Surface, after: Surface | ArrayLike, faces: Indices | None = None
) -> FaceStretch:
    """Area stretch and principal stretches of every triangle, or of those of some numbers (k,).

    A triangle maps linearly onto itself in the other state. The singular values s1 >= s2 of this
    2-D deformation gradient F are the largest and the smallest ratio of lengths in it. They follow
    from invariants, (s1 + s2)^2 = tr(F'F) + 2 J and (s1 - s2)^2 = tr(F'F) - 2 J with J = s1 s2,
    the ratio of the areas.

    Parameters
    ----------
    before : Surface
    after : Surface, or array_like of shape (n, 3)
        The other state: with the same triangles, or its points, mm.
    faces : (k,) array of int, optional

    Raises
    ------
    InputError
        No surface, or an other state that is not one of it.
    """
    after = state_of(as_surface(before, "before"), after)
    triangles = before.triangles if faces is None else before.triangles.take(faces, axis=0)
    uu, uv, vv = _metric(before.points, triangles)
    new_uu, new_uv, new_vv = _metric(after.points, triangles)
    old_area, new_area = uu * vv - uv * uv, new_uu * new_vv - new_uv * new_uv
    has_area = old_area > np.finfo(float).eps * uu * vv
    squared = np.where(has_area, old_area, np.nan)

    trace = (vv * new_uu - 2 * uv * new_uv + uu * new_vv) / squared
    area = np.sqrt(np.maximum(new_area, 0.0) / squared)
    total = np.sqrt(np.maximum(trace + 2 * area, 0.0))
    difference = np.sqrt(np.maximum(trace - 2 * area, 0.0))
    return FaceStretch(area, (total + difference) / 2, (total - difference) / 2)


def displacements(before: ArrayLike, after: ArrayLike) -> Floats:
    """The distance (n,) by which every point has moved, mm.

    Raises `InputError` if the two states differ in their number of points.
    """
    before, after = _both_states(before, after)
    return np.linalg.norm(after - before, axis=1)


def _both_states(before: ArrayLike, after: ArrayLike) -> tuple[Points, Points]:
    before, after = as_points(before, "before"), as_points(after, "after")
    if len(before) != len(after):
        raise InputError(
            f"after: expected the {len(before)} points of the state before, got {len(after)}; "
            "give two states of the same mesh."
        )
    return before, after


def _metric(points: Points, triangles: Triangles) -> tuple[Floats, Floats, Floats]:
    """Scalar products of the two sides at the first corner."""

    def products(corners: Triangles) -> Floats:
        first, second, third = (points.take(corner, axis=0) for corner in corners.T)
        u, v = second - first, third - first
        return np.stack([dot(u, u), dot(u, v), dot(v, v)])

    uu, uv, vv = in_blocks(products, triangles)
    return uu, uv, vv


class TriangleSizes(NamedTuple):
    """Sides (m, 3) of triangles, mm, and their smallest angles (m,), degrees."""

    edge_length: Floats
    smallest_angle: Floats


def triangle_sizes(points: Points, triangles: Triangles) -> TriangleSizes:
    """Sides and smallest angle of every triangle; the angle at a repeated corner is 0.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        mm.
    """
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides, axis=2)
    along = -np.einsum("fsx,fsx->fs", sides, np.roll(sides, 1, axis=1))
    product = lengths * np.roll(lengths, 1, axis=1)
    cosine = np.divide(along, product, out=np.ones_like(along), where=product > 0)
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return TriangleSizes(lengths, angles.min(axis=1))
