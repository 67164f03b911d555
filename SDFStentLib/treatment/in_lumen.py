"""Points of a placement have to lie in the vessel that is stented."""

from __future__ import annotations

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, SurfaceIndex, is_inside
from ..measure import closed_surface
from ..stent import Placement, placement_points
from ..validation import InputError

ON_WALL = 0.5
"""A point so near to the wall is one on it, as a click on the surface gives, mm."""


def check_in_lumen(placement: Placement, centerline: Centerline, surface: Surface) -> None:
    """Refuse points outside of the lumen; those within the inscribed sphere need no look.

    Raises
    ------
    InputError
        A point of the placement is outside, and not on the wall.
    """
    points, triangles = surface.points, surface.triangles
    for name, point in placement_points(placement):
        place = centerline.project(point)
        if place.distance < place.inscribed_radius:  # False where it is unknown
            continue
        if is_inside(point[None], *closed_surface(points, triangles))[0]:
            continue
        beyond = float(SurfaceIndex(points, triangles).distances(point[None]).distance[0])
        if beyond <= ON_WALL:
            continue
        raise InputError(
            f"{name}: expected a point in the lumen, got {np.round(point, 2).tolist()} mm, which "
            f"is {place.distance:.1f} mm from the centerline and {beyond:.1f} mm outside of the "
            "wall; move it into the vessel."
        )
