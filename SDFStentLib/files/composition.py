"""Parts of a surface that are no wall of a lumen: seams, ghosts, and outer sides of walls.

A surface may hold the lumen and the outer side of its wall, both open, or joined by a ring at every
end to the boundary of a solid.
"""

from __future__ import annotations

import numpy as np

from ..cautions import Caution
from ..geometry import (
    Surface,
    SurfaceIndex,
    boundary_edges,
    compacted,
    component_labels,
    connected,
    different_counts,
    dot,
    edges,
    face_normals,
    signed_volume,
)
from ..validation import Flags, Indices, Points, Triangles, as_place

FLAT = np.cos(np.deg2rad(5.0))
"""Cosine of the angle up to which the faces of a ring that closes a wall lie in one plane."""

ALL = 0.95
"""Share of a side that counts as the whole side: ends may be cut at a slant."""

SAMPLES = 400
"""Number of points of a side that are examined."""


MOST_HOSTS = 32
"""Number of the largest parts in which others are searched: a mesh may have thousands of pieces."""

LARGEST_ISLAND = 20.0
"""Extent, mm, below which a closed part in another is an island: no vessel model is that small."""


def composition_warnings(surface: Surface, name: str) -> tuple[Caution, ...]:
    """Cautions about what was joined or left out of a surface when it was read."""
    whole, again, islands = surface.whole, surface.again_count, surface.islands
    outer = len(whole.triangles) - again - len(surface.triangles) - len(islands)
    counts = {
        "points-joined": ("points", surface.unshared_points),
        "ghost-cells": ("cells", surface.made_of - len(whole.triangles)),
        "triangles-again": ("triangles", again),
        "outer-wall": ("triangles", outer),
    }
    found = [
        Caution(kind, {what: count}, label=f"{name}: ")
        for kind, (what, count) in counts.items()
        if count
    ]
    if len(islands):
        parts = _SurfaceParts(surface.points, islands, np.zeros(len(islands), dtype=bool))
        largest = int(parts.extents.argmax())
        size = {"islands": parts.count, "extent_mm": float(parts.extents[largest])}
        place = as_place((parts.low[largest] + parts.high[largest]) / 2)
        found.append(Caution("islands", size, place, label=f"{name}: "))
    return tuple(found)


def lumen_alone(surface: Surface) -> Surface:
    """The surface without outer sides of walls and without islands; the surface itself if it has
    none.

    An outer side encloses the lumen's side, and all of it is nearer to that than the lumen is wide.
    An island, such as calcium or a remnant of a segmentation, is a small closed part that lies in
    another part. A wire in the lumen is neither.
    """
    is_ring = rings(surface)
    if surface.topology.component_count == 1 and not is_ring.any():
        return surface
    parts = _SurfaceParts(surface.points, surface.triangles, is_ring)
    if parts.count < 2:
        return surface
    is_apart, is_island = is_ring.copy(), np.zeros(len(is_ring), dtype=bool)
    hosts = np.argsort(-parts.extents, kind="stable")[:MOST_HOSTS]
    small = parts.is_closed & (parts.extents < LARGEST_ISLAND)
    for outer in hosts:
        inner = parts.boxed_in(outer)
        if not inner.any():
            continue
        host = parts.alone(outer)
        if any(_is_wall_of(host, parts.alone(one)) for one in hosts if inner[one]):
            is_apart[parts.faces(outer)] = True
        for one in parts.wholly_in(host, np.flatnonzero(inner & small)):
            is_island[parts.faces(one)] = True
    # Rings of no wall of two sides stay, as flat spots with a hole in them.
    if not (is_apart & ~is_ring).any():
        is_apart[:] = False
    is_island &= ~is_apart
    if not (is_apart | is_island).any() or (is_apart | is_island).all():
        return surface
    return surface.without(is_apart, is_island)


class _SurfaceParts:
    """The parts of a surface without its rings, numbered by their first triangles."""

    def __init__(self, points: Points, triangles: Triangles, is_ring: Flags) -> None:
        self._points, self._triangles = points, triangles
        rows = np.flatnonzero(~is_ring)
        kept = triangles[rows]
        size = int(triangles.max()) + 1
        label = component_labels(size, kept[:, :2].ravel(), kept[:, 1:].ravel())
        own, number = np.unique(label[kept[:, 0]], return_inverse=True)
        number = number.reshape(-1)
        order = np.argsort(number, kind="stable")
        self.count = len(own)
        self._rows = rows[order]
        self._starts = np.searchsorted(number[order], np.arange(self.count + 1))
        corners = points[triangles[self._rows]]
        self.low = np.minimum.reduceat(corners.min(axis=1), self._starts[:-1])
        self.high = np.maximum.reduceat(corners.max(axis=1), self._starts[:-1])
        self.extents = (self.high - self.low).max(axis=1)
        self.is_closed = ~np.isin(own, label[boundary_edges(kept).ravel()])

    def faces(self, part: int) -> Indices:
        """Numbers (k,) of the triangles of a part."""
        return self._rows[self._starts[part] : self._starts[part + 1]]

    def alone(self, part: int) -> Surface:
        """A single part as a surface of its own."""
        return Surface(*compacted(self._points, self._triangles[self.faces(part)]))

    def wholly_in(self, host: Surface, some: Indices) -> Indices:
        """The parts among some (k,) that lie in another surface with every point."""
        if not len(some):
            return some
        own = [self.faces(part) for part in some]
        used, corner = np.unique(self._triangles[np.concatenate(own)], return_inverse=True)
        is_in = host.contains(self._points[used])[corner.reshape(-1, 3)].all(axis=1)
        return some[np.logical_and.reduceat(is_in, np.cumsum([0, *map(len, own[:-1])]))]

    def boxed_in(self, part: int) -> Flags:
        """Whether each other part (p,) lies in the box round a part, apart from what a slanted end
        may."""
        slack = (1 - ALL) * self.extents[part]
        found = (self.low >= self.low[part] - slack) & (self.high <= self.high[part] + slack)
        found[part] = False
        return np.asarray(found.all(axis=1))


def _is_wall_of(outer: Surface, inner: Surface) -> bool:
    """Whether one part is the outer side of a wall whose lumen's side is the other part."""
    sides = [one.points[:: max(1, len(one.points) // SAMPLES)] for one in (outer, inner)]
    if outer.contains(sides[1]).mean() < ALL:
        return False
    away = SurfaceIndex(inner.points, inner.triangles).distances(sides[0]).distance
    # Four times its volume over its area is the diameter of a long tube.
    volume = abs(signed_volume(inner.closed.points, inner.closed.triangles))
    return float(np.quantile(away, ALL)) < 4 * volume / float(inner.face_areas.sum())


def rings(surface: Surface) -> Flags:
    """Whether each triangle (m,) belongs to a flat ring at which a closed solid has an end."""
    triangles, shape = surface.triangles, surface.topology
    nothing = np.zeros(len(triangles), dtype=bool)
    vertices = int(np.count_nonzero(np.bincount(triangles.ravel())))
    # A closed surface without a handle is a sphere: nothing leads through it.
    if not shape.is_watertight or vertices - len(triangles) // 2 >= 2 * shape.component_count:
        return nothing
    found, normals = edges(triangles), face_normals(surface.points, surface.wound_triangles)
    one, other = found.paired_sides.T // 3
    is_flat = dot(normals[one], normals[other]) > FLAT
    count, label = connected(len(triangles), one[is_flat], other[is_flat])
    means = np.stack([np.bincount(label, column, count) for column in normals.T], axis=1)
    sizes = np.bincount(label, minlength=count)
    is_plane = np.linalg.norm(means, axis=1) > FLAT * sizes
    at_corners = np.repeat(label, 3)
    corners = different_counts(at_corners, triangles.ravel(), count)
    sides = different_counts(at_corners, found.face_edges.ravel(), count)
    euler = corners - sides + sizes
    return np.asarray((is_plane & (euler == 0))[label])
