"""An index of many balls, to ask again and again which of them come near some places."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..validation import Floats, Indices, Points

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_SLACK = 1e-12
"""Rounding of a distance, over the largest coordinate or length that takes part in it."""

_ALIKE = 1.5
"""Factor between radii below which balls are searched together."""

_STEPS = 64
"""Number of such factors below the largest radius from which on all smaller balls are one group."""

_LEAF = 48
"""Points in a leaf of a search tree: building and asking it takes three quarters of the time of
SciPy's usual 10."""


class _Alike(NamedTuple):
    """Balls of about one size."""

    numbers: Indices
    largest: float
    tree: cKDTree


class Balls:
    """Balls, indexed for many questions about which of them are near.

    Parameters
    ----------
    middles, radii : (m, 3) and (m,) arrays
        mm; at least one.
    """

    def __init__(self, middles: Points, radii: Floats) -> None:
        self.middles, self.radii = middles, radii

    @cached_property
    def _tree(self) -> cKDTree:
        return search_tree(self.middles)

    @cached_property
    def _sizes(self) -> tuple[_Alike, ...]:
        # A search is for one size: few large balls among small ones are looked for by themselves.
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.log(self.radii.max() / self.radii) / np.log(_ALIKE)
        step = np.fmin(step, _STEPS).astype(np.int64)
        number = _parts(np.bincount(step))[step]
        if not number.any():
            return (_Alike(np.arange(len(step)), float(self.radii.max()), self._tree),)
        each = (np.flatnonzero(number == one) for one in range(int(number.max()) + 1))
        return tuple(
            _Alike(own, float(self.radii[own].max()), search_tree(self.middles.take(own, axis=0)))
            for own in each
        )

    @cached_property
    def _reach(self) -> float:
        """The largest coordinate or radius, mm."""
        return float(max(np.abs(self.middles).max(), self.radii.max()))

    def near(self, places: Points, reach: Floats) -> tuple[Indices, Indices]:
        """Pairs of a place and a ball whose surfaces may be at most `reach` of the place apart.

        Parameters
        ----------
        places, reach : (n, 3) and (n,) arrays
            mm.

        Returns
        -------
        place, ball : (p,) arrays of int
            Sorted by place. All pairs that are near enough, and some that are too far by up to the
            difference between a ball's radius and the largest one that is searched with it.
        """
        far = self._widened(places, reach)
        found = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
        for alike in self._sizes:
            place, ball = _pairs(alike.tree, places, far + alike.largest)
            found.append((place, ball if len(self._sizes) == 1 else alike.numbers.take(ball)))
        place, ball = (np.concatenate(column) for column in zip(*found, strict=True))
        if len(self._sizes) == 1:
            return place, ball
        order = np.argsort(place, kind="stable")
        return place.take(order), ball.take(order)

    def near_middles(self, places: Points, reach: Floats) -> tuple[Indices, Indices]:
        """Pairs of a place and a middle that may be at most `reach` apart, as of `near`."""
        return _pairs(self._tree, places, self._widened(places, reach))

    def nearest(self, places: Points) -> Floats:
        """Distance (n,) from every place to the nearest middle."""
        return np.asarray(self._tree.query(places)[0])

    def _widened(self, places: Points, reach: Floats) -> Floats:
        """Reaches (n,) by as much longer as distances are rounded, mm."""
        return reach + _SLACK * (self._reach + np.abs(places).max(initial=0.0) + reach)


def _pairs(tree: cKDTree, places: Points, reach: Floats) -> tuple[Indices, Indices]:
    """Pairs of a place and a point within its reach (n,), sorted by place."""
    return in_one_row(tree.query_ball_point(places, reach, return_sorted=False))


def nearest_distances(places: Points, points: Points) -> Floats:
    """Distance (n,) from every place to the nearest of some points, of which there is at least
    one."""
    return np.asarray(search_tree(points).query(places)[0])


def _parts(counts: Indices) -> Indices:
    """Number (k,) of the group in which balls of each size are searched, from the count of each
    size.

    Sizes go down by `_ALIKE`. Balls searched with larger ones are found too often, but a search of
    their own costs something for every place: they have to be many, or much smaller.
    """
    part = np.zeros(len(counts), dtype=np.int64)
    first, left = 0, counts.sum() - np.cumsum(counts)
    for size in range(1, len(counts)):
        own = counts[first:size].sum()
        is_begun = 0 < own < left[size - 1] * _ALIKE ** (size - first)
        first = size if is_begun else first
        part[size] = part[size - 1] + is_begun
    return part


def search_tree(points: Points) -> cKDTree:
    """A search tree of points (n, 3), built as quickly as possible for being asked a few times
    only."""
    # Late: scipy costs what a first frame should not pay.
    from scipy.spatial import cKDTree

    return cKDTree(points, leafsize=_LEAF, balanced_tree=False, compact_nodes=False)


def in_one_row(lists: Sequence[list[int]]) -> tuple[Indices, Indices]:
    """Number of the list, and value, for every value of some lists."""
    counts = np.fromiter(map(len, lists), np.int64, len(lists))
    values = np.fromiter(chain.from_iterable(lists), np.int64, int(counts.sum()))
    return np.repeat(np.arange(len(lists)), counts), values
