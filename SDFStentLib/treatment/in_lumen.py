"""Points of a placement have to lie in the vessel that is stented."""

from __future__ import annotations

import numpy as np

from ..centerline import Centerline
from ..lumen import VesselInside
from ..stent import Placement, placement_points
from ..validation import InputError


def check_in_lumen(inside: VesselInside, placement: Placement, centerline: Centerline) -> None:
    """Refuse points outside of a vessel; those within the inscribed sphere need no look.

    Raises
    ------
    InputError
        A point of the placement is outside, and not on the wall.
    """
    for name, point in placement_points(placement):
        place = centerline.project(point)
        if place.distance < place.inscribed_radius:  # False where it is unknown
            continue
        if beyond := inside.beyond(point):
            raise InputError(
                f"{name}: expected a point in the lumen, got {np.round(point, 2).tolist()} mm, "
                f"which is {place.distance:.1f} mm from the centerline and {beyond:.1f} mm outside "
                "of the wall; move it into the vessel."
            )
