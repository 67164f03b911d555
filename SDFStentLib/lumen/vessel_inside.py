"""The distance of a place outside of a vessel."""

from __future__ import annotations

from functools import cached_property

from ..geometry import Surface, SurfaceIndex
from ..validation import Points

ON_WALL = 0.5
"""Distance from the wall up to which a point counts as on it, such as a click on the
surface, mm."""


class VesselInside:
    """The inside of a vessel; the structures that many questions about it need are made once."""

    def __init__(self, surface: Surface) -> None:
        self.surface = surface

    @cached_property
    def _wall(self) -> SurfaceIndex:
        return SurfaceIndex(self.surface.points, self.surface.triangles)

    def beyond(self, point: Points) -> float:
        """The distance of a point (3,) outside of the wall, mm; 0 inside and on the wall."""
        if self.surface.contains(point[None])[0]:
            return 0.0
        away = float(self._wall.distances(point[None]).distance[0])
        return away if away > ON_WALL else 0.0
