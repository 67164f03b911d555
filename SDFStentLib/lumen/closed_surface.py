"""A surface with its holes closed, which tells inside from outside."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..geometry import Surface, SurfaceIndex, boundary_edges, component_labels
from ..validation import Floats, Indices, Points

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

    def beyond(self, point: Points) -> float:
        """How far outside of the wall a point (3,) is, mm; 0 inside and on the wall."""
        if self.closed.contains(point[None])[0]:
            return 0.0
        away = float(self._wall.distances(point[None]).distance[0])
        return away if away > ON_WALL else 0.0


class Holes(NamedTuple):
    """The holes of a surface."""

    rim: Indices
    """(m, 2) all edges with a triangle on one side only."""
    number: Indices
    """(m,) of the hole round which each goes."""
    middles: Points
    """(h, 3) mean of the points round each hole, mm."""
    radii: Floats
    """(h,) how far they are from it, at most, mm."""


def closed_surface(surface: Surface) -> Surface:
    """The surface with a fan of triangles over every hole."""
    holes = holes_of(surface)
    if not len(holes.rim):
        return surface
    fans = np.column_stack([holes.rim[:, ::-1], len(surface.points) + holes.number])
    points = np.vstack([surface.points, holes.middles])
    return Surface(points, np.vstack([surface.triangles, fans]))


def holes_of(surface: Surface) -> Holes:
    """Where a surface is open."""
    points, known = surface.points, surface.known_topology
    is_whole = known is not None and known.boundary_edge_count == 0
    rim = np.empty((0, 2), np.int64) if is_whole else boundary_edges(surface.triangles)
    used, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    label = component_labels(len(used), ends[:, 0], ends[:, 1])
    sums = np.stack([np.bincount(label, part) for part in points[used].T], axis=1)
    middles = sums / np.bincount(label)[:, None]
    radii = np.zeros(len(middles))
    np.maximum.at(radii, label, np.linalg.norm(points[used] - middles[label], axis=1))
    return Holes(rim, label[ends[:, 0]], middles, radii)
