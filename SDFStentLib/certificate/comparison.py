"""The faults that a surface has after its points moved but did not have before."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import Precision, faces_at
from ..validation import Flags, Indices, Points, Triangles
from .face_quality import Slivers, degenerate_triangles, inverted_triangles, slivers_among
from .intersections import intersecting_pairs, self_intersecting_triangles
from .spots import FaultSpot, spots_of

Judge = Callable[[Points, Triangles, Indices], Indices]
"""A function that picks, of some faces of a surface, those with a fault of one kind."""


class Verdict(NamedTuple):
    """The findings of a comparison; those of a result that differs little follow quickly from them.

    Attributes
    ----------
    stored : (n, 3) array
        Points of the result as stored.
    has_moved : (n,) bool array
        Whether the stored coordinates of a point differ from the input.
    pairs, pairs_before : (k, 2) arrays
        Faces that intersect in the result, one of which moved; pairs of the input that hold a face
        of `searched`.
    searched : (m,) bool array
        Whether a face of the input was searched for intersections.
    inverted, degenerate : arrays
        Moved faces that are turned over or without height, whether new or not.
    new_self_intersecting, new_inverted, new_degenerate : arrays
        Faces that fail but did not in the input, ascending.
    places : tuple of FaultSpot
        Places at which new faults gather, most faces first.
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
    places: tuple[FaultSpot, ...]

    @property
    def passed(self) -> bool:
        """Whether there is no new fault of any kind."""
        return not self.places

    @property
    def failing(self) -> Indices:
        """Indices (k,) of the faces with any new fault, ascending."""
        return united(self.new_self_intersecting, self.new_inverted, self.new_degenerate)


def united(*kinds: Indices) -> Indices:
    """Indices (k,) of faces of several kinds, each once, ascending."""
    return np.unique(np.concatenate(kinds))


class Comparison:
    """Compares results with the surface from which they came, in the stored numbers.

    Parameters
    ----------
    before, triangles : (n, 3) and (m, 3) arrays
        The input, mm, consistently wound.
    precision : Precision
        Type and unit of the stored coordinates.
    """

    def __init__(self, before: Points, triangles: Triangles, precision: Precision) -> None:
        self.triangles = triangles
        self._precision, self._before = precision, precision.stored(before)
        # Of the input's faces, by kind of fault: which were judged, and which have it.
        self._judged: defaultdict[Judge, Flags] = defaultdict(
            lambda: np.zeros((2, len(triangles)), dtype=bool)
        )

    def verdict(
        self,
        after: Points,
        earlier: Verdict | None = None,
        may_move: NDArray[np.bool_] | None = None,
    ) -> Verdict:
        """Judge a result, given the verdict on an earlier one.

        Only faces with a corner elsewhere than in the earlier result, and those that they meet, are
        judged anew; all others keep their verdict. So the outcome does not depend on `earlier`.
        """
        triangles, known = self.triangles, earlier or self._nothing_moved()
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
        searched, pairs_before = self._of_input(pairs, known)
        degenerate = degenerate_triangles(stored, triangles, np.flatnonzero(again & moved))
        degenerate = np.union1d(known.degenerate[~again[known.degenerate]], degenerate)
        # Whether a face is turned over depends on the faces at its corners as well.
        beside = np.zeros(len(stored), dtype=bool)
        beside[triangles[again]] = True
        again = faces_at(beside, triangles)
        inverted = inverted_triangles(stored, triangles, np.flatnonzero(again & moved))
        inverted = np.union1d(known.inverted[~again[known.inverted]], inverted)

        new = np.setdiff1d(pairs, pairs_before)
        new_inverted = self._anew(inverted_triangles, inverted)
        new_degenerate = self._anew(degenerate_triangles, degenerate)
        spots = tuple(spots_of(after, triangles, np.r_[new, new_inverted, new_degenerate], pairs))
        return Verdict(
            stored, has_moved, pairs, pairs_before, searched, inverted, degenerate,
            new, new_inverted, new_degenerate, spots,
        )  # fmt: skip

    def new_faults(self, after: Points, among: Indices) -> Indices:
        """Indices of faces that intersect, are turned over or lack height in a result, but not
        before.

        Only the given faces and those that they meet are judged; for being turned over also those
        at their corners, because neighbors can turn a face over, too. The input is judged only
        where something is wrong now.
        """
        triangles, stored = self.triangles, self._precision.stored(after)
        beside = np.zeros(len(stored), dtype=bool)
        beside[triangles[among]] = True
        near = np.flatnonzero(faces_at(beside, triangles))
        found = self_intersecting_triangles(stored, triangles, among)
        return united(
            self._anew(self_intersecting_triangles, found),
            self._anew(inverted_triangles, inverted_triangles(stored, triangles, near)),
            self._anew(degenerate_triangles, degenerate_triangles(stored, triangles, among)),
        )

    def new_slivers(self, verdict: Verdict) -> Slivers:
        """Moved faces of a judged result that became slivers but still have some height."""
        moved = np.flatnonzero(faces_at(verdict.has_moved, self.triangles))
        among = np.setdiff1d(moved, verdict.degenerate)
        scale = self._precision.scale
        return slivers_among(verdict.stored / scale, self.triangles, among, self._before / scale)

    def _anew(self, faulty: Judge, now: Indices) -> Indices:
        """The faces that are faulty now and were not in the input, each of which is judged once."""
        was_judged, was_faulty = self._judged[faulty]
        first = now[~was_judged[now]]
        if len(first):
            was_judged[first] = True
            was_faulty[faulty(self._before, self.triangles, first)] = True
        return now[~was_faulty[now]]

    def _nothing_moved(self) -> Verdict:
        at_points, at_faces = (
            np.zeros(len(values), dtype=bool) for values in (self._before, self.triangles)
        )
        face, pair = np.empty(0, dtype=np.int64), np.empty((0, 2), dtype=np.int64)
        return Verdict(
            self._before, at_points, pair, pair, at_faces, face, face, face, face, face, ()
        )

    def _of_input(self, pairs: Indices, known: Verdict) -> tuple[NDArray[np.bool_], Indices]:
        """Whether each face of the input is searched, and the intersecting pairs found there."""
        searched = np.zeros(len(self.triangles), dtype=bool)
        searched[pairs] = True
        kept = known.pairs_before[_any_of(known.pairs_before, searched)]
        found = intersecting_pairs(self._before, self.triangles, searched & ~known.searched)
        return searched, _sorted(kept, found)


def _differing(one: Points, other: Points) -> NDArray[np.bool_]:
    x, y, z = (one != other).T
    return x | y | z


def _any_of(pairs: Indices, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return marked[pairs[:, 0]] | marked[pairs[:, 1]]


def _sorted(one: Indices, other: Indices) -> Indices:
    """The pairs of both arrays, each once, in ascending order."""
    return np.unique(np.concatenate([one, other]), axis=0)
