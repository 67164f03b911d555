"""Points that stand for a wall while a sphere looks roughly for its place."""

from __future__ import annotations

import numpy as np

from ...geometry import Balls, NearPairs, norm
from ...validation import Floats, Indices, Points
from .local_surface import LocalSurface


class WallPoints:
    """Middles of some of a surface's triangles, to be searched as the surface itself.

    They are a part of the wall: no distance to them is smaller than that to the wall.

    Parameters
    ----------
    surface : LocalSurface
    stride : float
        About one triangle of so many is taken.
    """

    def __init__(self, surface: LocalSurface, stride: float) -> None:
        self._surface, self._stride = surface, stride
        self.lowest, self.highest = surface.lowest, surface.highest
        self._growths = -1

    @property
    def growths(self) -> int:
        """The growths, as of `LocalSurface.growths`."""
        return self._surface.growths

    def near(self, centers: Points, radii: Floats) -> NearPairs:
        """The points that are near, as of `LocalSurface.near`."""
        self._surface.cover(centers, radii)
        points = self._known()
        query, one = self._balls.near(centers, radii)
        return NearPairs(query, one, norm(centers.take(query, axis=0) - points.take(one, axis=0)))

    def distances(self, centers: Points) -> Floats:
        """Distance (n,) to the nearest of the points that have been asked for."""
        self._known()
        return self._balls.nearest(centers)

    def closest_points(self, _queries: Points, which: Indices) -> Points:
        """The points (p, 3) themselves."""
        return np.asarray(self._points.take(which, axis=0))

    def _known(self) -> Points:
        index = self._surface.index
        if self._growths != self._surface.growths:
            self._growths = self._surface.growths
            chosen = self._surface.chosen(self._stride)
            # What was found once stays when the surface grows.
            self._stride = self._stride if chosen.any() else 1.0
            self._points = index.centroids[chosen] if chosen.any() else index.centroids
            self._balls = Balls(self._points, np.zeros(len(self._points)))
        return self._points
