"""Faces of a surface that are turned over, without area, or slivers; and where faults gather.

`Comparison` finds the faults that a surface has after its points moved and had not before.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import Precision, compacted, component_labels, face_normals, faces_at
from ..validation import Indices, Points, Triangles
from .intersections import intersecting_pairs

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
    at_judged[triangles[judged]] = True
    near = np.flatnonzero(faces_at(at_judged, triangles))
    used, local = compacted(points, triangles[near])
    normals = face_normals(used, local)
    first, second, third = local.T

    def around(values: NDArray[Any]) -> NDArray[np.float64]:
        """Sum over the faces at the three corners."""
        at_corner = np.bincount(local.ravel(), np.repeat(values, 3), minlength=len(used))
        return at_corner[first] + at_corner[second] + at_corner[third]

    agreement = sum(column * around(column) for column in normals.T)
    x, y, z = normals.T != 0
    has_normal = x | y | z
    is_turned = has_normal & (agreement < OPPOSED * around(has_normal))
    is_judged = np.zeros(len(triangles), dtype=bool)
    is_judged[judged] = True
    return near[is_turned & is_judged[near]]


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


def winding_in_words(flipped: int, is_inside_out: bool) -> str:
    """What is wrong with the winding of triangles, as the end of a sentence."""
    if flipped:
        return f", and {flipped} of its triangles are wound against their neighbors"
    return ", and it is inside out: its triangles must be turned" if is_inside_out else ""


def count_in_words(count: int) -> str:
    """Such as "1 triangle" or "1,200 triangles"."""
    return f"{count:,} triangle" + ("" if count == 1 else "s")


class Verdict(NamedTuple):
    """What a comparison found; from it that of a result which differs little follows quickly.

    Attributes
    ----------
    stored : (n, 3) array
        The result as stored.
    has_moved : (n,) bool array
        Points whose stored coordinates changed since the input.
    pairs, pairs_before : (k, 2) arrays
        Faces that intersect in the result, one of which moved; pairs of the input round
        `searched`.
    searched : (m,) bool array
        Faces round which the input was searched for intersections.
    inverted, degenerate : arrays
        Moved faces that are turned over or without area, new or not.
    new_self_intersecting, new_inverted, new_degenerate : arrays
        Faces that fail and did not in the input, ascending.
    places : tuple of Place
    """

    stored: Points
    has_moved: NDArray[np.bool_]
    pairs: Indices
    pairs_before: Indices
    searched: NDArray[np.bool_]
    inverted: Indices
    degenerate: Indices
    new_self_intersecting: Indices
    new_inverted: Indices
    new_degenerate: Indices
    places: tuple[Place, ...]

    @property
    def passed(self) -> bool:
        """No new fault of any kind."""
        return not self.places

    @property
    def failing(self) -> Indices:
        """All faces with a new fault, ascending."""
        return united(self.new_self_intersecting, self.new_inverted, self.new_degenerate)


def united(*kinds: Indices) -> Indices:
    """Faces with a fault of any kind, each once, ascending."""
    return np.unique(np.concatenate(kinds))


class Comparison:
    """Compares results with the surface that they came from, in the stored numbers.

    Parameters
    ----------
    before, triangles : (n, 3) and (m, 3) arrays
        The input, mm, consistently wound.
    precision : Precision
        Type and unit of the stored coordinates.
    known_before : array, optional
        All faces that intersect in the input, where known: with none it is not searched, else
        round all faces that moved. By default it is searched round those that intersect in the
        result.
    """

    def __init__(
        self,
        before: Points,
        triangles: Triangles,
        precision: Precision,
        known_before: Indices | None = None,
    ) -> None:
        self._triangles = triangles
        self._precision, self._known_before = precision, known_before
        self._before = precision.stored(before)

    def verdict(
        self,
        after: Points,
        earlier: Verdict | None = None,
        may_move: NDArray[np.bool_] | None = None,
    ) -> Verdict:
        """Judge a result, given the verdict on an earlier one.

        Only faces with a corner elsewhere than in the earlier result are looked at, and those
        that they meet; all others keep their verdict. So the outcome does not depend on it.
        """
        triangles, known = self._triangles, earlier or self._nothing_moved()
        stored = self._precision.stored(after)
        has_moved = _differing(stored, self._before)
        if may_move is not None:
            has_moved &= may_move
        moved = again = faces_at(has_moved, triangles)
        if earlier is not None:
            elsewhere = _differing(stored, known.stored) | (has_moved != known.has_moved)
            again = faces_at(elsewhere, triangles)

        found = intersecting_pairs(stored, triangles, again)
        pairs = _sorted(known.pairs[~_any_of(known.pairs, again)], found[_any_of(found, moved)])
        searched, pairs_before = self._of_input(pairs, moved, known)
        degenerate = degenerate_triangles(stored, triangles, np.flatnonzero(again & moved))
        degenerate = np.union1d(known.degenerate[~again[known.degenerate]], degenerate)
        # Whether a face is turned over depends on the faces at its corners as well.
        beside = np.zeros(len(stored), dtype=bool)
        beside[triangles[again]] = True
        again = faces_at(beside, triangles)
        inverted = inverted_triangles(stored, triangles, np.flatnonzero(again & moved))
        inverted = np.union1d(known.inverted[~again[known.inverted]], inverted)

        new = np.setdiff1d(pairs, pairs_before)
        new_inverted, new_degenerate = (
            np.setdiff1d(now, look(self._before, triangles, now))
            for look, now in ((inverted_triangles, inverted), (degenerate_triangles, degenerate))
        )
        spots = tuple(places(after, triangles, np.r_[new, new_inverted, new_degenerate], pairs))
        return Verdict(
            stored, has_moved, pairs, pairs_before, searched, inverted, degenerate,
            new, new_inverted, new_degenerate, spots,
        )  # fmt: skip

    def _nothing_moved(self) -> Verdict:
        at_points, at_faces = (
            np.zeros(len(values), dtype=bool) for values in (self._before, self._triangles)
        )
        face, pair = np.empty(0, dtype=np.int64), np.empty((0, 2), dtype=np.int64)
        return Verdict(
            self._before, at_points, pair, pair, at_faces, face, face, face, face, face, ()
        )

    def _of_input(
        self, pairs: Indices, moved: NDArray[np.bool_], known: Verdict
    ) -> tuple[NDArray[np.bool_], Indices]:
        """Faces round which the input is searched, and its pairs there."""
        if self._known_before is not None:
            searched = moved & bool(len(self._known_before))
        else:
            searched = np.zeros(len(moved), dtype=bool)
            searched[pairs] = True
        kept = known.pairs_before[_any_of(known.pairs_before, searched)]
        found = intersecting_pairs(self._before, self._triangles, searched & ~known.searched)
        return searched, _sorted(kept, found)


def _differing(one: Points, other: Points) -> NDArray[np.bool_]:
    x, y, z = (one != other).T
    return x | y | z


def _any_of(pairs: Indices, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return marked[pairs[:, 0]] | marked[pairs[:, 1]]


def _sorted(one: Indices, other: Indices) -> Indices:
    """Pairs of both, each once, in ascending order."""
    return np.unique(np.concatenate([one, other]), axis=0)


def _sides_and_areas(
    points: Points, triangles: Triangles
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Side lengths (3, m) in ascending order, and twice the areas (m,)."""
    first, second, third = points.take(triangles.T, axis=0).swapaxes(1, 2)
    (ux, uy, uz), side, (vx, vy, vz) = second - first, third - second, first - third
    u, v, w = (np.sqrt(x * x + y * y + z * z) for x, y, z in ((ux, uy, uz), (vx, vy, vz), side))
    low, high = np.minimum(u, v), np.maximum(u, v)
    lengths = np.stack(
        [np.minimum(low, w), np.maximum(low, np.minimum(high, w)), np.maximum(high, w)]
    )
    normal = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return lengths, np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
