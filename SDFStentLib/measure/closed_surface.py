"""A surface with its holes closed, which tells inside from outside."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import boundary_edges, component_labels
from ..validation import Floats, Indices, Points, Triangles


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


def closed_surface(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    """The surface with a fan of triangles over every hole."""
    holes = holes_of(points, triangles)
    if not len(holes.rim):
        return points, triangles
    fans = np.column_stack([holes.rim[:, ::-1], len(points) + holes.number])
    return np.vstack([points, holes.middles]), np.vstack([triangles, fans])


def holes_of(points: Points, triangles: Triangles) -> Holes:
    """Where a surface is open."""
    rim = boundary_edges(triangles)
    used, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    label = component_labels(len(used), ends[:, 0], ends[:, 1])
    sums = np.stack([np.bincount(label, part) for part in points[used].T], axis=1)
    middles = sums / np.bincount(label)[:, None]
    radii = np.zeros(len(middles))
    np.maximum.at(radii, label, np.linalg.norm(points[used] - middles[label], axis=1))
    return Holes(rim, label[ends[:, 0]], middles, radii)
