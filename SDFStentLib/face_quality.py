"""Faces of a surface that are turned over, without area, or slivers; and where faults gather."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .surface import face_normals
from .topology import component_labels
from .validation import Points, Triangles

Indices = NDArray[np.int64]

_ROUNDING = 8 * 2.0**-53
"""Relative rounding of a cross product: below it two sides cannot be told from parallel ones."""


OPPOSED = -0.2
"""Mean cosine to the faces around below which a face is turned over.

One face upside down in a flat wall has (3 - 15) / 18 = -0.67. Faces in pleats of tissue beside a
stent, which intersect nothing, came out just below 0 on the pulmonary artery.
"""


class Place(NamedTuple):
    """A spot of the surface where faces fail.

    Attributes
    ----------
    center : (x, y, z)
        Mean of the centroids of the faces, mm.
    triangles : tuple of int
        The faces, ascending.
    """

    center: tuple[float, float, float]
    triangles: tuple[int, ...]

    def __str__(self) -> str:
        x, y, z = self.center
        return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"


def degenerate_triangles(
    points: Points, triangles: Triangles, among: Indices | None = None
) -> Indices:
    """Triangles without area: a corner named twice, or corners in a line but for rounding."""
    judged = np.arange(len(triangles)) if among is None else among
    lengths, areas = _sides_and_areas(points, triangles[judged])
    return judged[areas <= _ROUNDING * lengths[1] * lengths[2]]


def sliver_triangles(points: Points, triangles: Triangles, angle_deg: float = 1.0) -> Indices:
    """Triangles whose smallest angle is below `angle_deg`, those without area included."""
    lengths, areas = _sides_and_areas(points, triangles)
    # The smallest angle lies between the two longer sides.
    return np.flatnonzero(areas <= np.sin(np.deg2rad(angle_deg)) * lengths[1] * lengths[2])


def inverted_triangles(
    points: Points, triangles: Triangles, among: Indices | None = None
) -> Indices:
    """Triangles turned over against their neighbourhood, ascending.

    A face counts as turned over when its normal opposes the unit normals of the faces at its three
    corners by a mean cosine below `OPPOSED`, itself included; a neighbour across an edge so counts
    twice, one at a corner once. This finds one face, or a few side by side, that lie upside down in
    a smooth wall. It leaves alone a face on a sharp ridge or in a pleat, where about as many
    neighbours agree with it as oppose it, and the corners of a box. Faces without area have no
    normal and do not count either way.

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
    at_judged[triangles[judged].ravel()] = True
    near = np.flatnonzero(at_judged[triangles].any(axis=1))
    used, local = np.unique(triangles[near], return_inverse=True)
    local = local.reshape(-1, 3)
    normals = face_normals(points[used], local)

    at_corner = np.stack(
        [
            np.bincount(local.ravel(), np.repeat(normals[:, k], 3), minlength=len(used))
            for k in range(3)
        ],
        axis=1,
    )
    agreement = np.einsum("ij,ij->i", normals, at_corner[local].sum(axis=1))
    has_normal = normals.any(axis=1)
    counted = np.bincount(local.ravel(), np.repeat(has_normal, 3), minlength=len(used))
    opposed = OPPOSED * counted[local].sum(axis=1)
    return np.intersect1d(judged, near[has_normal & (agreement < opposed)])


def places(points: Points, triangles: Triangles, faces: Indices, pairs: Indices) -> list[Place]:
    """Spots at which faces fail, most faces first.

    Faces belong to one spot when they share a corner or stand together in one of `pairs`.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
    faces : (k,) array
        Failing faces.
    pairs : (p, 2) array
        Faces that fail together; pairs of other faces are ignored.
    """
    faces = np.unique(faces)
    if not len(faces):
        return []
    pairs = pairs[np.isin(pairs, faces).all(axis=1)]
    used, corners = np.unique(triangles[faces], return_inverse=True)
    label = component_labels(
        len(faces) + len(used),
        np.r_[np.repeat(np.arange(len(faces)), 3), np.searchsorted(faces, pairs[:, 0])],
        np.r_[len(faces) + corners.ravel(), np.searchsorted(faces, pairs[:, 1])],
    )[: len(faces)]
    centers = points[triangles[faces]].mean(axis=1)
    spots = []
    for number in np.unique(label):
        x, y, z = centers[label == number].mean(axis=0).tolist()
        spots.append(Place((x, y, z), tuple(faces[label == number].tolist())))
    return sorted(spots, key=lambda spot: (-len(spot.triangles), spot.triangles))


def faults_in_words(spots: Sequence[Place], *counted: tuple[int, str]) -> str:
    """Counts of triangles, each with what is wrong, and where; `spots` are those of `places`."""
    faults = ", ".join(f"{count_in_words(count)} {words}" for count, words in counted if count)
    if len(spots) == 1:
        return f"{faults} near {spots[0]}"
    return f"{faults} at {len(spots)} places, most of them near {spots[0]}"


def count_in_words(count: int) -> str:
    """Such as "1 triangle" or "1,200 triangles"."""
    return f"{count:,} triangle" + ("" if count == 1 else "s")


def _sides_and_areas(
    points: Points, triangles: Triangles
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Side lengths (3, m) in ascending order, and twice the areas (m,)."""
    first, second, third = points[triangles.T]
    sides = [second - first, third - second, first - third]
    lengths = np.sort([np.sqrt(np.einsum("ij,ij->i", side, side)) for side in sides], axis=0)
    return lengths, np.linalg.norm(np.cross(sides[0], sides[2]), axis=1)
