"""The part of a surface that lies near some centers."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ...geometry import (
    Balls,
    NearPairs,
    Surface,
    SurfaceIndex,
    box_of,
    in_box,
    may_meet_box,
    nearest_distances,
    section_around,
)
from ...validation import Flags, Floats, Indices, Points, Triangles
from ..tolerances import ROUNDING

SOME = 1000
"""Number of a surface's corners that stand for all where about how far it is away is enough, or
about how wide."""

_ODD = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
"""Multipliers that make one number of the three of a place; any large odd ones would do."""

AROUND = 2.5
"""Margin of the box that holds the wall round some centers, in distances to some of it."""


def some_corners(points: Points, triangles: Triangles) -> Points:
    """Some of the corners of triangles (m, 3)."""
    return points[triangles[:: max(1, len(triangles) // SOME), 0]]


_kept: WeakKeyDictionary[Surface, SurfaceIndex] = WeakKeyDictionary()
"""Indices of whole surfaces, as long as these are in use."""


def known_index(surface: Surface) -> SurfaceIndex:
    """Index of all triangles of a surface, for one question: the one that is kept, if any is."""
    return _kept.get(surface) or SurfaceIndex(surface.points, surface.triangles)


def index_within(surface: Surface, places: Points, reaches: Floats) -> tuple[SurfaceIndex, Indices]:
    """Index of all triangles within reach (n,) of some places (n, 3), at least, and their numbers.

    That of all triangles where it is kept. At least one triangle is near.
    """
    if (kept := _kept.get(surface)) is not None:
        return kept, np.arange(len(surface.triangles))
    points, corners = surface.points.T, surface.corners
    is_near = np.zeros(corners.shape[1], dtype=bool)
    first = points[0].take(corners)
    low, high = first.min(axis=0), first.max(axis=0)
    for place, reach in zip(places, reaches.tolist(), strict=True):
        near = np.flatnonzero((low <= place[0] + reach) & (high >= place[0] - reach))
        for axis in (1, 2):
            along = points[axis].take(corners.take(near, axis=1))
            is_in = along.min(axis=0) <= place[axis] + reach
            near = near[is_in & (along.max(axis=0) >= place[axis] - reach)]
        is_near[near] = True
    numbers = np.flatnonzero(is_near)
    return SurfaceIndex(surface.points, surface.triangles.take(numbers, axis=0)), numbers


class LocalSurface:
    """The part of a surface near some centers; grows when they ask for more.

    Attributes
    ----------
    lowest, highest : (3,) arrays
        Corners of the box round the whole surface, mm.
    growths : int
        Number of its growths; triangle numbers change with it.
    """

    def __init__(self, points: Points, triangles: Triangles, centers: Points) -> None:
        self._points, self._triangles, self._centers = points, triangles, centers
        self._whole: Surface | None = None
        self.lowest: Floats
        self.highest: Floats
        self.lowest, self.highest = box_of(points)
        self._index: SurfaceIndex | None = None
        self._numbers: NDArray[np.uint64] | None = None
        self._some: dict[float, Balls | None] = {}
        self.growths = 0

    @classmethod
    def of(cls, surface: Surface, centers: Points) -> LocalSurface:
        """The part of a surface whose index is kept, and used where most of it lies near."""
        part = cls(surface.points, surface.triangles, centers)
        part._whole = surface
        return part

    @property
    def index(self) -> SurfaceIndex:
        """The triangles that have been asked for, and more; at least one."""
        if self._index is None:
            self._grow(AROUND * float(self._vertex_distances(self._centers).max()))
            assert self._index is not None
        return self._index

    def near(self, centers: Points, radii: Floats) -> NearPairs:
        """`SurfaceIndex.near`, complete; triangle numbers change when `index` does."""
        self.cover(centers, radii)
        return self.index.near(centers, radii)

    def distances(self, centers: Points) -> Floats:
        """Distance (n,) from centers to the whole surface."""
        if not len(centers):
            return np.empty(0)
        if self._index is None:
            # No wall that is nearer than some of it lies farther around.
            self._grow((1 + ROUNDING) * float(self._vertex_distances(centers).max()))
        distance = self.index.distances(centers).distance
        if self._cover(centers, distance):
            # More triangles are never farther away: what has been covered is enough.
            distance = self.index.distances(centers).distance
        return distance

    def bounds(self, centers: Points) -> Floats:
        """Distances (n,) that those from centers to the surface do not exceed."""
        return self.index.nearest_middles(centers)

    def least(self, centers: Points) -> Floats:
        """Distances (n,) that those from centers to the whole surface are at least."""
        if not len(centers):
            return np.empty(0)
        nearest = self.bounds(centers)
        if self._cover(centers, nearest):
            nearest = self.bounds(centers)
        return nearest - float(self.index.disc_radii.max())

    def closest_points(self, queries: Points, triangle: Indices) -> Points:
        """Nearest point (p, 3) of triangle i, as `near` numbers them, to query i."""
        return self.index.closest_points(queries, triangle)

    def triangles_round(self, centers: Points) -> Floats:
        """The approximate number of triangles (n,) of a sphere round a center that meets the wall.

        By those in the box round these centers: elsewhere the surface may be finer or coarser.
        """
        reach = self.index.nearest_middles(centers)
        margin = AROUND * reach.max(initial=0.0)
        low, high = centers.min(axis=0) - margin, centers.max(axis=0) + margin
        middles, radii = self.index.centroids, self.index.disc_radii
        is_near = in_box(middles, low, high)
        # A triangle with equal sides whose corners lie on a circle of radius 1 has the area 1.3.
        area = 1.3 * float(np.median(radii[is_near] if is_near.any() else radii)) ** 2
        # Of a center far outside there are not more than there are.
        return np.minimum(4 * np.pi * reach**2 / max(area, 1e-300), float(len(middles)))

    def cover(self, centers: Points, radii: Floats) -> None:
        """Hold all within the radii of the centers."""
        if self._index is None:
            self._low, self._high = self._centers.min(axis=0), self._centers.max(axis=0)
            self._grow((1 + ROUNDING) * self._missing(centers, radii))
        # Where the box holds nothing, a larger one is taken.
        self._index = self.index
        self._cover(centers, radii)

    def parts(self, place: Points, other: Points, axes: Floats) -> bool:
        """Whether a closed section of what has been asked for lies between two places of a plane.

        `axes` (2, 3) are those of the plane.
        """
        wall = self._triangles[self._kept]
        section = section_around(self._points, wall, place, np.cross(*axes))
        if section is None or not section.is_closed:
            return False
        odd = []
        for one in (place, other):
            (x, y), (next_x, next_y) = (
                axes @ (side - one).T for side in (section.start, section.end)
            )
            crosses = np.flatnonzero((y > 0) != (next_y > 0))
            along = x - y * np.divide(next_x - x, next_y - y, where=next_y != y, out=0 * x)
            odd.append(np.count_nonzero(along[crosses] > 0) % 2)
        return odd[0] != odd[1]

    def middles(self, stride: float) -> Balls | None:
        """Balls with the middles of the `chosen` triangles; None where none is.

        Made once until the surface grows: every search begins among the same ones.
        """
        index = self.index
        if stride <= 1:
            return index.discs
        if stride not in self._some:
            chosen = self.chosen(stride)
            count = np.count_nonzero(chosen)
            some = Balls(index.centroids[chosen], np.zeros(count)) if count else None
            self._some[stride] = some
        return self._some[stride]

    def chosen(self, stride: float) -> Flags:
        """Mask (m,) of a part of the triangles that have been asked for, about one in `stride`.

        By where they are alone: a triangle is chosen or not whatever else has been asked for, in
        whatever order a file has them, in single precision, and turned from LPS to RAS. Else as if
        at random: a regular choice could leave out whole sides of a regular mesh.
        """
        if self._numbers is None:
            places = np.abs(self._points).astype(np.float32, order="C").view(np.uint32)
            scattered = _scattered(places.astype(np.uint64) @ _ODD)
            corners = [scattered.take(column) for column in self._triangles[self._kept].T]
            self._numbers = _scattered(np.add.reduce(corners))
        return self._numbers * (stride / 2.0**64) < 1

    def _vertex_distances(self, centers: Points) -> Floats:
        """Distance (n,) to the nearest of `some_corners`, which bounds that to the wall."""
        return nearest_distances(centers, some_corners(self._points, self._triangles))

    def _grow(self, margin: float) -> None:
        """Take the triangles in the box round the centers, if there are any."""
        self.growths += 1
        self._numbers = None
        self._some = {}
        self._margin = margin
        self._low = self._centers.min(axis=0) - margin
        self._high = self._centers.max(axis=0) + margin
        self._kept: slice | Flags = slice(None)
        if not self._is_whole():
            self._kept = may_meet_box(self._points, self._triangles, self._low, self._high)
            if self._whole is not None and 2 * np.count_nonzero(self._kept) > len(self._kept):
                self._low, self._high, self._kept = self.lowest, self.highest, slice(None)
        if self._whole is not None and self._is_whole():
            self._index = _kept[self._whole] = known_index(self._whole)
            return
        kept = self._triangles
        if not isinstance(self._kept, slice):
            kept = kept.compress(self._kept, axis=0)
        self._index = SurfaceIndex(self._points, kept) if len(kept) else None

    def _is_whole(self) -> bool:
        return bool(np.all(self._low <= self.lowest) and np.all(self._high >= self.highest))

    def _missing(self, centers: Points, radii: Floats) -> float:
        """Length by which balls of these radii at the centers reach out of the box, mm."""
        reach = radii[:, None]
        beyond = np.maximum(self._low - (centers - reach), centers + reach - self._high)
        return max(float(beyond.max(initial=0.0)), 0.0)

    def _cover(self, centers: Points, radii: Floats) -> bool:
        """Grow, at most once, to hold all within the radii of the centers; whether it grew."""
        missing = self._missing(centers, radii)
        if missing <= 0 or self._is_whole():
            return False
        # Doubling spares growing at every step, but twice the margin of a center on a vertex is 0.
        self._grow(max(2 * self._margin, self._margin + (1 + ROUNDING) * missing))
        return True


def _scattered(numbers: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Scattered numbers, always the same for the same ones."""
    # The last steps of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
    first, second, last = np.uint64(30), np.uint64(27), np.uint64(31)
    numbers = (numbers ^ (numbers >> first)) * np.uint64(0xBF58476D1CE4E5B9)
    numbers = (numbers ^ (numbers >> second)) * np.uint64(0x94D049BB133111EB)
    return numbers ^ (numbers >> last)
