"""Points of a placement have to lie in the vessel that is stented."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, SurfaceIndex
from ..lumen import closed_surface
from ..stent import Placement, placement_points
from ..validation import InputError, Points

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
    def closed(self) -> Surface:
        """The surface with its open ends closed."""
        return closed_surface(self.surface)

    @cached_property
    def _wall(self) -> SurfaceIndex:
        return SurfaceIndex(self.surface.points, self.surface.triangles)

    def check(self, placement: Placement, centerline: Centerline) -> None:
        """Refuse points outside of it; those within the inscribed sphere need no look.

        Raises
        ------
        InputError
            A point of the placement is outside, and not on the wall.
        """
        for name, point in placement_points(placement):
            place = centerline.project(point)
            if place.distance < place.inscribed_radius:  # False where it is unknown
                continue
            if (beyond := self._beyond(point)) <= ON_WALL:
                continue
            raise InputError(
                f"{name}: expected a point in the lumen, got {np.round(point, 2).tolist()} mm, "
                f"which is {place.distance:.1f} mm from the centerline and {beyond:.1f} mm outside "
                "of the wall; move it into the vessel."
            )

    def _beyond(self, point: Points) -> float:
        """How far outside of the wall a point (3,) is, mm; 0 inside."""
        if self.closed.contains(point[None])[0]:
            return 0.0
        return float(self._wall.distances(point[None]).distance[0])
