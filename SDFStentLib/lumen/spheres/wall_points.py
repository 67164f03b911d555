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

    @property
    def growths(self) -> int:
        """The growths, as of `LocalSurface.growths`."""
        return self._surface.growths

    def near(self, centers: Points, radii: Floats) -> NearPairs:
        """The points that are near, as of `LocalSurface.near`."""
        self._surface.cover(centers, radii)
        known = self._known()
        query, one = known.near_middles(centers, radii)
        apart = centers.take(query, axis=0) - known.middles.take(one, axis=0)
        return NearPairs(query, one, norm(apart))

    def distances(self, centers: Points) -> Floats:
        """Distance (n,) to the nearest of the points that have been asked for."""
        return self._known().nearest(centers)

    def closest_points(self, _queries: Points, which: Indices) -> Points:
        """The points (p, 3) themselves."""
        return np.asarray(self._balls.middles.take(which, axis=0))

    def _known(self) -> Balls:
        known = self._surface.middles(self._stride)
        if known is None:
            # What was found once stays when the surface grows.
            self._stride, known = 1.0, self._surface.index.discs
        self._balls = known
        return known
