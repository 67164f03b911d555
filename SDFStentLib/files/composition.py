"""What a surface has that is no wall of a lumen: seams, ghosts, and outer sides of walls.

A surface may hold the lumen and the outer side of its wall, both open, or joined by a ring at every
end to the boundary of a solid.
"""

from __future__ import annotations

import numpy as np

from ..cautions import Caution
from ..geometry import (
    Surface,
    SurfaceIndex,
    component_labels,
    connected,
    dot,
    edges,
    face_normals,
    signed_volume,
)
from ..validation import Flags, Indices, Triangles

FLAT = np.cos(np.deg2rad(5.0))
"""Faces of a ring that closes a wall lie in one plane up to this angle."""

ALL = 0.95
"""Share of a side that counts as all of it: ends may be cut at a slant."""

SAMPLES = 400
"""Points of a side that are looked at."""


def composition_warnings(surface: Surface, name: str) -> tuple[Caution, ...]:
    """What was taken as one or left out of a surface as it was read."""
    whole, again = len(surface.whole.triangles), surface.again_count
    counts = {
        "points-joined": ("points", surface.unshared_points),
        "ghost-cells": ("cells", surface.made_of - whole),
        "triangles-again": ("triangles", again),
        "outer-wall": ("triangles", whole - again - len(surface.triangles)),
    }
    return tuple(
        Caution(kind, {what: count}, label=f"{name}: ")
        for kind, (what, count) in counts.items()
        if count
    )


def lumen_alone(surface: Surface) -> Surface:
    """The surface without outer sides of walls; itself where there is none.

    An outer side holds the lumen's side in it, and all of it is nearer to that than that is wide.
    An island in the lumen does not come near to all of the wall, nor does a wire.
    """
    is_ring = rings(surface)
    part = _parts(surface.triangles, is_ring)
    if part.max() < 1:
        return surface
    sides = [_Side(surface, np.flatnonzero(part == number)) for number in range(part.max() + 1)]
    is_apart = is_ring.copy()
    for outer in sides:
        if any(inner is not outer and outer.is_wall_of(inner) for inner in sides):
            is_apart[outer.faces] = True
    # Rings of no wall of two sides stay, as flat spots with a hole in them.
    if not (is_apart & ~is_ring).any() or is_apart.all():
        return surface
    return surface.without(is_apart)


def rings(surface: Surface) -> Flags:
    """Which triangles (m,) belong to flat rings at which a closed solid has its ends."""
    triangles, shape = surface.triangles, surface.topology
    nothing = np.zeros(len(triangles), dtype=bool)
    vertices = len(np.unique(triangles))
    # Closed without a handle it is a sphere: nothing leads through it.
    if not shape.is_watertight or vertices - len(triangles) // 2 >= 2 * shape.component_count:
        return nothing
    found, normals = edges(triangles), face_normals(surface.points, surface.wound_triangles)
    one, other = found.paired_sides.T // 3
    is_flat = dot(normals[one], normals[other]) > FLAT
    count, label = connected(len(triangles), one[is_flat], other[is_flat])
    means = np.stack([np.bincount(label, column, count) for column in normals.T], axis=1)
    sizes = np.bincount(label, minlength=count)
    is_plane = np.linalg.norm(means, axis=1) > FLAT * sizes
    corners = np.unique(np.stack([np.repeat(label, 3), triangles.ravel()]), axis=1)[0]
    sides = np.unique(np.stack([np.repeat(label, 3), found.face_edges.ravel()]), axis=1)[0]
    euler = np.bincount(corners, minlength=count) - np.bincount(sides, minlength=count) + sizes
    return np.asarray((is_plane & (euler == 0))[label])


def _parts(triangles: Triangles, is_ring: Flags) -> Indices:
    """Number (m,) of the part that each triangle belongs to without rings; -1 for these."""
    part = np.full(len(triangles), -1, dtype=np.int64)
    kept = triangles[~is_ring]
    label = component_labels(int(triangles.max()) + 1, kept[:, :2].ravel(), kept[:, 1:].ravel())
    part[~is_ring] = np.unique(label[kept[:, 0]], return_inverse=True)[1].reshape(-1)
    return part


class _Side:
    """A part of a surface."""

    def __init__(self, surface: Surface, faces: Indices) -> None:
        self.faces = faces
        self._surface = surface
        self._triangles = surface.triangles[faces]
        used = np.unique(self._triangles)
        self._points = surface.points[used]
        self._sample = self._points[:: max(1, len(used) // SAMPLES)]
        self._low, self._high = self._points.min(axis=0), self._points.max(axis=0)

    def is_wall_of(self, inner: _Side) -> bool:
        """Whether the other is the lumen's side of the wall of which this is the outer side."""
        in_box = (inner._sample >= self._low) & (inner._sample <= self._high)
        if in_box.all(axis=1).mean() < ALL:
            return False
        own = Surface(self._surface.points, self._triangles)
        if own.contains(inner._sample).mean() < ALL:
            return False
        away = SurfaceIndex(self._surface.points, inner._triangles).distances(self._sample)
        return float(np.quantile(away.distance, ALL)) < inner.width()

    def width(self) -> float:
        """Diameter, mm, of a long tube of this volume and area."""
        own = Surface(self._surface.points, self._triangles)
        volume = abs(signed_volume(own.closed.points, own.closed.triangles))
        return 4 * volume / float(own.face_areas.sum())
