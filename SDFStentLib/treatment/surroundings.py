"""What a stent does to its surroundings: branches, neighbors, contact with the wall."""

from __future__ import annotations

from typing import NamedTuple

from ..centerline import Centerline
from ..geometry import Surface
from ..measure import (
    Apposition,
    NeighborLumen,
    Ostium,
    apposition,
    extended_axis,
    find_ostia,
    neighbor_lumens,
)
from ..validation import Points

LISTED = 10.0
"""Branches so far beyond an end of the stent are listed, mm."""


class Surroundings(NamedTuple):
    """Of one stent."""

    branches: tuple[Ostium, ...]
    """Proximal to distal."""
    neighbors: tuple[NeighborLumen, ...]
    """Those whose wall has moved: beyond both ends, then branches by the names of their ostia."""
    apposition: Apposition
    """Contact with the wall after treatment."""


def surroundings(
    before: Surface,
    after: Surface,
    axis: Points,
    radius: float,
    centerline: Centerline | None,
) -> Surroundings:
    """What a stent of that axis (n, 3) and radius, mm, did to its surroundings.

    Parameters
    ----------
    before, after : Surface
        As the stent found it, and as the treatment left it, mm.
    axis : (n, 3) array
    radius : float
        mm.
    centerline : Centerline or None
        Of `before`. Without it branches are found, but their lumen is not followed.
    """
    way = extended_axis(before, axis, centerline)
    ostia = find_ostia(before, way)
    near = tuple(o for o in ostia if o.end > -LISTED and o.start < way.stent_length + LISTED)
    return Surroundings(
        near,
        neighbor_lumens(before, after, way, near, centerline),
        apposition(after, axis, radius),
    )
