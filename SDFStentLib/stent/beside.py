"""Points of a placement that lie beside the centerline, on which the stent is put."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..validation import Floats, as_place
from .placement import AlongAxis, AtCenter, AtDistalEnd, BetweenPoints, OfStent, Placement

FAR = 0.5
"""From this many local inscribed radii on the distance to the centerline is told."""

FAR_UNKNOWN = 2.0
"""The same where the radius is unknown, mm."""


def placement_points(placement: Placement) -> list[tuple[str, Floats]]:
    """The points of a placement with their names; none along a curve or a stent."""
    if isinstance(placement, BetweenPoints):
        return [("stent start", placement.start), ("stent end", placement.end)]
    if isinstance(placement, AlongAxis | OfStent):
        return []
    if isinstance(placement, AtCenter):
        return [("center", placement.point)]
    name = "distal end" if isinstance(placement, AtDistalEnd) else "proximal end"
    return [(name, placement.point)]


def beside(placement: Placement, centerline: Centerline) -> Iterator[Caution]:
    """Every point that is noticeably away from where the stent is put."""
    for name, point in placement_points(placement):
        place = centerline.project(point)
        radius = place.inscribed_radius
        if place.distance <= (FAR * radius if np.isfinite(radius) else FAR_UNKNOWN):
            continue
        if isinstance(placement, BetweenPoints):
            # The two ends are those of the part where one is measured.
            kind, which = "end-beside", {"end": name.removeprefix("stent ")}
        else:
            kind, which = "point-beside", {"point": name}
        yield Caution(kind, {**which, "distance_mm": place.distance}, as_place(place.point))
