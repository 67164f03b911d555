"""Meshes that are too coarse for a stent: where its lumen is not reached, or may not be."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..cautions import Caution
from ..certificate import LumenCheck
from ..deformation import FINE
from ..geometry import Surface, SurfaceIndex, median_edge, side_lengths
from .value import TreatedStent

COARSE = 0.6
"""Edge at the expanded stent over its radius, from which on a caution is given.

In 120 stents of straight and bent phantoms, by the wall's distance from the axis, the narrowest
place was at most 0.6 % too narrow below a median of 0.35 radii, 1.2 % below 0.5, 1.7 % below 0.6;
from there on up to 3.8 %, more than 3 % in 18 of 73, in bends and at the ends. 42 stents of the
anatomies had at most 0.31.
"""

AT_STENT = np.sqrt(2.0)
"""Distance from the axis, in radii, of corners by which facets are compensated."""

BESIDE = 0.1
"""Radii of the stent beyond the nearest wall within which wall counts as that of a narrow place."""


def too_coarse(check: LumenCheck, before: Surface, after: Surface) -> Iterator[Caution]:
    """Whether a lumen is not the prescribed one where few and long triangles go round it.

    Parameters
    ----------
    check : LumenCheck
        Check of a stent, in the surface after all of them.
    before, after : Surface
        As this stent found it, and after all of them.
    """
    if check.passed or not check.narrowest:
        return
    found, prescribed, place = check.missed()
    radius, station = prescribed / 2, np.array([place])
    near = SurfaceIndex(after.points, after.triangles)
    reach = near.distances(station).distance + BESIDE * radius
    faces = near.near(station, reach).triangle
    triangles = after.triangles[faces]
    long, start = (side_lengths(one.points, triangles) for one in (after, before))
    worst = np.unravel_index(long.argmax(), long.shape)
    if long[worst] <= COARSE * radius:
        return
    # Sides are refined before they are stretched.
    fine = min(FINE * radius, start[worst] / 3, start[worst] * COARSE * radius / long[worst])
    numbers = {
        "start_mm": start[worst],
        "edge_mm": long[worst],
        "found_mm": found,
        "prescribed_mm": prescribed,
        "fine_mm": fine,
    }
    yield Caution("too-coarse", {name: float(one) for name, one in numbers.items()}, place)


def coarse_mesh(treated: TreatedStent) -> Iterator[Caution]:
    """Whether the edges at a stent whose lumen is not judged are so long that it may be missed."""
    radius, edge = treated.stent.radius, edge_at_stent(treated)
    if edge > COARSE * radius:
        lengths = {"edge_mm": edge, "stent_radius_mm": radius, "fine_mm": FINE * radius}
        yield Caution("coarse-mesh", lengths)


def edge_at_stent(treated: TreatedStent) -> float:
    """Median length of the deformed wall's edges on the expanded stent, mm; 0 without any."""
    moved, surface = treated.result.state.indices, treated.result.surface
    radius = treated.stent.radius
    # Coarser than the axis is given; a median asks for no more.
    axis = treated.axis.line.resampled(radius / 2)
    at_stent = axis.nearest(surface.points[moved]).distances <= AT_STENT * radius
    is_there = np.zeros(len(surface.points), dtype=bool)
    is_there[moved[at_stent]] = True
    are_there = np.logical_and.reduce([is_there.take(corner) for corner in surface.corners])
    near = surface.triangles.compress(are_there, axis=0)
    return median_edge(surface.points, near) if len(near) else 0.0
