"""A surface with its holes closed, which tells inside from outside."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Surface, boundary_edges, component_labels
from ..validation import Floats, Indices, Points


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
