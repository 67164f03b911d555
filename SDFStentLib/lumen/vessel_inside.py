"""How far outside of a vessel a place is."""

from __future__ import annotations

from functools import cached_property

from ..geometry import Surface, SurfaceIndex
from ..validation import Points

ON_WALL = 0.5
"""A point so near to the wall is one on it, as a click on the surface gives, mm."""


class VesselInside:
    """The inside of a vessel; what many questions about it need is made once.

    Parameters
    ----------
    surface : Surface
    """

    def __init__(self, surface: Surface) -> None:
        self.surface = surface

    @cached_property
    def _wall(self) -> SurfaceIndex:
        return SurfaceIndex(self.surface.points, self.surface.triangles)

    def beyond(self, point: Points) -> float:
        """How far outside of the wall a point (3,) is, mm; 0 inside and on the wall."""
        if self.surface.contains(point[None])[0]:
            return 0.0
        away = float(self._wall.distances(point[None]).distance[0])
        return away if away > ON_WALL else 0.0
