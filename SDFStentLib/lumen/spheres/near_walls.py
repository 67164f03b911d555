"""Linear models of the distances to the wall near some centers, searched as seldom as may be."""

from __future__ import annotations

import numpy as np

from ...geometry import NearPairs, norm
from ...validation import Floats, Indices, Points
from ..tolerances import ALIKE
from .local_surface import LocalSurface
from .max_min_step import LinearRows
from .wall_points import WallPoints

_HELD = 0.7
"""Share of the centers left at which bounds of the others are dropped."""


class Neighborhood:
    """Triangles near every center, found once and thinned out as the centers settle."""

    def __init__(self, surface: LocalSurface | WallPoints, count: int) -> None:
        self._surface = surface
        self._covered = np.full(count, -np.inf)
        self._moved, self._held = np.zeros(count), count
        self._growths = surface.growths
        nothing = np.empty(0, dtype=np.int64)
        # Bounds hold at a center's first place: what it has moved since is to be taken off.
        self._pairs = NearPairs(nothing, nothing, np.empty(0))

    def forget(self, active: Indices, moved: Floats) -> None:
        """Shrink the bounds on distances by as much as the centers have moved."""
        self._covered[active] -= moved
        self._moved[active] += moved

    def rows(
        self, centers: Points, radii: Floats, axes: Floats, reach: Floats, active: Indices
    ) -> LinearRows:
        """Linear models of the distances that matter within a reach, and the exact radii.

        Parameters
        ----------
        centers, radii, axes : (n, 3), (n,) and (n, 2, 3) arrays
            Spheres and axes of all stations; no radius is below the distance to the wall.
        reach : (k,) array
            Walls farther than a radius and this do not matter, mm.
        active : (k,) array of int
            The centers that are looked at, in order.
        """
        # More than a step needs, not by its reach: that grows threefold while a center is far from
        # its place.
        spare = (ALIKE - 1) * radii[active]
        query, offset, distance = self._offsets(centers, active, radii[active] + reach, spare)
        starts = np.searchsorted(query, active)
        radius = np.minimum.reduceat(distance, starts)
        limit = np.empty(len(centers))
        limit[active] = radius + reach
        matters = np.flatnonzero(distance <= limit.take(query))
        query, distance = query.take(matters), distance.take(matters)
        offset = offset.take(matters, axis=0)
        slope = np.einsum("nij,nj->ni", axes.take(query, axis=0), offset)
        slope /= np.maximum(distance, 1e-300)[:, None]
        return LinearRows(distance, slope, np.searchsorted(query, active), radius)

    def _find(self, centers: Points, active: Indices, which: Indices, wanted: Floats) -> None:
        """Search anew round some of the centers, as far as wanted."""
        found = self._surface.near(centers[which], wanted)
        self._covered[which] = wanted
        anew = which.take(found.query)
        pairs = NearPairs(anew, found.triangle, found.bound + self._moved.take(anew))
        if len(which) < len(active):
            kept = self._pairs_of(len(centers), np.setdiff1d(active, which, assume_unique=True))
            both = [np.concatenate(columns) for columns in zip(kept, pairs, strict=True)]
            order = np.argsort(both[0], kind="stable")
            pairs = NearPairs(*(column.take(order) for column in both))
        self._hold(pairs, len(active))

    def _pairs_of(self, count: int, some: Indices) -> NearPairs:
        """The pairs of some of so many centers."""
        is_one = np.zeros(count, dtype=bool)
        is_one[some] = True
        query, triangle, bound = self._pairs
        kept = np.flatnonzero(is_one.take(query))
        return NearPairs(query.take(kept), triangle.take(kept), bound.take(kept))

    def _hold(self, pairs: NearPairs, count: int) -> None:
        self._pairs, self._held = pairs, count

    def _offsets(
        self, centers: Points, active: Indices, radii: Floats, spare: Floats
    ) -> tuple[Indices, Points, Floats]:
        """Query, offset and distance of the walls within `radii` of the active centers.

        Looks at a little more, up to `radii + spare`, so that it need not search at every step.
        """
        # Where the surface has grown its triangles have other numbers.
        missing = (radii > self._covered[active]) | (self._surface.growths != self._growths)
        if missing.any():
            growths = self._surface.growths
            self._find(centers, active, active[missing], (radii + spare)[missing])
            if self._surface.growths != growths and not missing.all():
                self._find(centers, active, active, radii + spare)
            self._growths = self._surface.growths
        if len(active) <= _HELD * self._held:
            self._hold(self._pairs_of(len(centers), active), len(active))
        query, triangle, bound = self._pairs
        limit = np.full(len(centers), -np.inf)
        limit[active] = radii + self._moved[active]
        inner = np.flatnonzero(bound <= limit.take(query))
        query, triangle = query.take(inner), triangle.take(inner)
        places = centers.take(query, axis=0)
        offset = places - self._surface.closest_points(places, triangle)
        distance = norm(offset)
        bound[inner] = distance + self._moved.take(query)
        return query, offset, distance
