"""Seams of a surface: points that are the same point, and triangles that repeat.

Appended parts, split normals and files in pieces store the points of a seam more than once.
"""

from __future__ import annotations

from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Flags, Indices, Points, Triangles, read_only
from .closing import Closing, closing
from .distance import following_weights
from .fans import connected
from .rows import dot, used_points
from .topology import (
    Topology,
    VertexNeighbors,
    boundary_edges,
    consistently_wound,
    surface_topology,
    vertex_neighbors,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FOLDED = np.cos(np.deg2rad(1.0))
"""Two faces at an angle below 1 degree lie on each other: walls that touch, no seam of one wall."""


class Triangulation:
    """Everything that follows from the triangles alone; surfaces that differ in their points share
    it."""

    weights: csr_array | None

    def __init__(self, points: Points, triangles: Triangles, is_left_out: Flags | None) -> None:
        kept = None if is_left_out is None else np.flatnonzero(~is_left_out)
        found = joined(points, triangles if kept is None else triangles[kept], triangles)
        self.point_count, self.given = len(points), triangles
        self.whole = self.triangles = read_only(found.triangles)
        self.cells = self.cells_of_whole = kept
        self.copies, self.originals = read_only(found.copies), read_only(found.originals)
        self.unshared, self.again_count = found.unshared, 0
        self.followers, self.weights = NOTHING, None
        self.islands = triangles[:0]
        if found.is_wall is not None:
            wall = np.flatnonzero(found.is_wall)
            self.triangles = read_only(found.triangles[wall])
            self.cells = wall if kept is None else kept[wall]
            self.again_count = len(self.whole) - len(wall)

    @cached_property
    def topology(self) -> Topology:
        return surface_topology(self.triangles)._replace(unshared_points=self.unshared)

    @cached_property
    def corners(self) -> Triangles:
        return read_only(np.ascontiguousarray(self.triangles.T))

    @cached_property
    def neighbors(self) -> VertexNeighbors:
        found = vertex_neighbors(self.triangles, self.point_count)
        return VertexNeighbors(read_only(found.offsets), read_only(found.indices))

    @cached_property
    def wound_triangles(self) -> Triangles:
        if self.topology.is_consistently_wound:
            return self.triangles
        return read_only(consistently_wound(self.triangles)[0])

    @cached_property
    def closing(self) -> Closing:
        return closing(self.triangles, self.topology)

    @cached_property
    def of_whole(self) -> Triangulation:
        """The mesh of all triangles that belong to the surface, wall or not."""
        if self.whole is self.triangles:
            return self
        return self._of(self.whole, self.cells_of_whole)

    def without(self, points: Points, is_apart: Flags, is_island: Flags) -> Triangulation:
        """The mesh without some triangles (m,); points of those apart follow the wall."""
        kept = np.flatnonzero(~(is_apart | is_island))
        mesh = self._of(self.triangles[kept], kept if self.cells is None else self.cells[kept])
        mesh.islands = read_only(self.triangles[is_island])
        if is_apart.any():
            wall = used_points(mesh.triangles)
            own = np.setdiff1d(used_points(self.triangles[is_apart]), wall)
            mesh.followers = read_only(own)
            mesh.weights = following_weights(points, mesh.triangles, points[own])
        return mesh

    def _of(self, triangles: Triangles, cells: Indices | None) -> Triangulation:
        mesh = copy(self)
        for name in ("topology", "corners", "neighbors", "wound_triangles", "closing", "of_whole"):
            vars(mesh).pop(name, None)
        mesh.triangles, mesh.cells = read_only(triangles), cells
        return mesh


class Joined(NamedTuple):
    """A surface whose seams are closed.

    Attributes
    ----------
    triangles : (m, 3) array
        Triangles in which points that are the same point have the number of the first.
    is_wall : (m,) array or None
        False for a triangle that is there already, or that has collapsed to a line between points
        that lie on each other. None where all are wall.
    copies, originals : (c,) arrays
        Points that lie on a point of the wall but are none, ascending, and that wall point.
    unshared : int
        Number of copies that close a seam.
    """

    triangles: Triangles
    is_wall: Flags | None
    copies: Indices
    originals: Indices
    unshared: int = 0


NOTHING = np.empty(0, dtype=np.int64)


def joined(points: Points, triangles: Triangles, given: Triangles | None = None) -> Joined:
    """Close the seams of a surface.

    Free sides of triangles are joined where they lie on each other; so a seam closes, no edge gets
    a third face, and walls that only touch stay apart. Where more than two such sides meet, the
    pairs are joined across which the wall is flattest.

    Parameters
    ----------
    points : (n, 3) array
    triangles : (m, 3) array
    given : (k, 3) array, optional
        More triangles whose points may be copies, but which are no part of the surface.
    """
    used = used_points(triangles if given is None else given)
    twin = twins(points, used)
    is_wall = ~_come_again(triangles)
    if twin is None:
        return Joined(triangles, None if is_wall.all() else is_wall, NOTHING, NOTHING)
    is_wall &= ~(_collapsed(twin[triangles]) | _lie_alike(twin[triangles]))
    if not is_wall.any():
        return Joined(triangles, None, NOTHING, NOTHING)
    first = _first_of_joined(points, triangles[is_wall], twin)
    closed = first[triangles]
    is_wall &= ~_in_parts_on_others(closed, is_wall, twin)
    # The first point of the wall at each place; where walls touch there are more.
    at = np.full(len(points), -1, dtype=np.int64)
    wall = used_points(closed[is_wall])[::-1]
    at[twin[wall]] = wall
    is_joined = first != np.arange(len(points))
    originals = np.where(is_joined, first, at[twin])
    originals[wall] = -1
    copies = used[originals[used] >= 0]
    some = None if is_wall.all() else is_wall
    return Joined(closed, some, copies, originals[copies], int(is_joined.sum()))


def twins(points: Points, among: Indices) -> Indices | None:
    """First one (n,) of some points with the coordinates of each; None where no two are equal."""
    own = points[among]
    # Equal coordinates have equal sums: without equal sums there is nothing to look for.
    sums = np.sort(own[:, 0] + np.e * own[:, 1] + np.pi * own[:, 2])
    if not (sums[1:] == sums[:-1]).any():
        return None
    order = np.lexsort(own.T[::-1])
    repeats = np.zeros(len(own), dtype=bool)
    repeats[1:] = (own[order[1:]] == own[order[:-1]]).all(axis=1)
    if not repeats.any():
        return None
    # A stable sort keeps the lowest number first among equals.
    first = order[np.maximum.accumulate(np.where(repeats, 0, np.arange(len(own))))]
    twin = np.arange(len(points))
    twin[among[order]] = among[first]
    return twin


def _come_again(triangles: Triangles) -> Flags:
    """Whether each triangle has the same three points as an earlier one, in any order."""
    mixed = _mixed(np.arange(int(triangles.max()) + 1))
    first, second, third = triangles.T
    sums = np.sort(mixed.take(first) + mixed.take(second) + mixed.take(third))
    if not (sums[1:] == sums[:-1]).any():
        return np.zeros(len(triangles), dtype=bool)
    return _repeated(np.sort(triangles, axis=1))


def _mixed(numbers: Indices) -> NDArray[np.uint64]:
    """Scrambled numbers: sums of three of them are equal by chance only (SplitMix64, Steele et al.
    2014)."""
    mixed = (numbers.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(mixed ^ (mixed >> np.uint64(31)))


def _lie_alike(corners: Triangles) -> Flags:
    """Whether each triangle lies on an earlier one and is turned the same way.

    Where two walls touch in faces these are turned against each other, and both stay.
    """
    least = corners.argmin(axis=1)[:, None]
    return _repeated(np.take_along_axis(corners, (least + np.arange(3)) % 3, axis=1))


def _in_parts_on_others(triangles: Triangles, is_wall: Flags, twin: Indices) -> Flags:
    """Whether each triangle is of a part of the wall that lies wholly on earlier ones, turned
    either way."""
    again = np.ones(len(triangles), dtype=bool)
    again[is_wall] = _repeated(np.sort(twin[triangles[is_wall]], axis=1))
    wall = triangles[is_wall]
    part = connected(len(twin), wall[:, :2].ravel(), wall[:, 1:].ravel())[1]
    first_only = np.bincount(part[wall[:, 0]], ~again[is_wall], len(twin))
    return np.asarray(first_only[part[triangles[:, 0]]] == 0)


def _repeated(rows: Indices) -> Flags:
    """Whether each row is the same as an earlier one."""
    order = np.lexsort(rows.T[::-1])
    is_repeated = np.zeros(len(rows), dtype=bool)
    is_repeated[order[1:]] = (rows[order[1:]] == rows[order[:-1]]).all(axis=1)
    return is_repeated


def _collapsed(triangles: Triangles) -> Flags:
    first, second, third = triangles.T
    return (first == second) | (second == third) | (third == first)


def _first_of_joined(points: Points, triangles: Triangles, twin: Indices) -> Indices:
    """Number (n,) of the first among the points that are the same point as each."""
    sides, far = _free_sides(triangles)
    ends = twin[sides]
    order = np.lexsort(np.sort(ends, axis=1).T)
    sides, far, ends = sides[order], far[order], ends[order]
    keys = np.sort(ends, axis=1)
    starts = np.flatnonzero(np.r_[True, (keys[1:] != keys[:-1]).any(axis=1)])
    counts = np.diff(starts, append=len(keys))
    across = _across(points, sides, far)
    two = starts[counts == 2]
    pairs = np.stack([two, two + 1], axis=1)
    pairs = pairs[dot(across[two], across[two + 1]) < FOLDED]
    more = [
        _flattest(np.arange(start, start + count), across, ends)
        for start, count in zip(starts[counts > 2], counts[counts > 2], strict=True)
    ]
    pairs = np.concatenate([pairs, *more])
    one, other = sides[pairs[:, 0]], sides[pairs[:, 1]]
    turned = ends[pairs[:, 0], 0] != ends[pairs[:, 1], 0]
    other = np.where(turned[:, None], other[:, ::-1], other)
    label = connected(len(points), one.ravel(), other.ravel())[1]
    first = np.full(label.max() + 1, len(points), dtype=np.int64)
    np.minimum.at(first, label, np.arange(len(points)))
    return np.asarray(first[label])


def _free_sides(triangles: Triangles) -> tuple[Indices, Indices]:
    """Sides (b, 2) of one face only, in its direction, and its corner (b,) opposite of each."""
    count = int(triangles.max()) + 1
    free = boundary_edges(triangles)
    starts, ends = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    keys, wanted = starts * count + ends, free[:, 0] * count + free[:, 1]
    order = np.argsort(keys, kind="stable")
    side = order[np.searchsorted(keys, wanted, sorter=order)]
    return free, triangles[:, [2, 0, 1]].ravel()[side]


def _across(points: Points, sides: Indices, far: Indices) -> Points:
    """Unit directions (b, 3) from free sides into their faces."""
    start, end = points[sides[:, 0]], points[sides[:, 1]]
    along, into = end - start, points[far] - start
    length = np.maximum(dot(along, along), np.finfo(float).tiny)
    into = into - (dot(into, along) / length)[:, None] * along
    return into / np.maximum(np.linalg.norm(into, axis=1), np.finfo(float).tiny)[:, None]


def _flattest(group: Indices, across: Points, ends: Indices) -> Indices:
    """Pairs (p, 2) of sides that lie on each other: the flattest first, those
    running alike last."""
    first, second = np.triu_indices(len(group), 1)
    first, second = group[first], group[second]
    bend = dot(across[first], across[second])
    alike = ends[first, 0] == ends[second, 0]
    free, pairs = set(group.tolist()), []
    for pair in np.lexsort([bend, alike]):
        if {int(first[pair]), int(second[pair])} <= free and bend[pair] < FOLDED:
            free -= {int(first[pair]), int(second[pair])}
            pairs.append((first[pair], second[pair]))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)
