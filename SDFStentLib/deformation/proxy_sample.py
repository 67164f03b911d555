"""A few points that stand for a wall, and the weights with which its vertices follow them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..field import CapsuleChain
from ..geometry import Surface, dot, face_areas, oriented_triangles, ranges, signed_volume
from ..geometry import vertex_normals as normals_at
from ..validation import Floats, Indices, Points, Triangles

CELL = 4.0
"""Edge of the cells in which a wall's vertices are stored, mm."""

PROBES = 5_000
"""Number of vertices from which the area near a stent is estimated."""

GRID_SHARE = 1.5
"""Spacing of a sample over that of the grid from which its candidates come."""


@dataclass(frozen=True)
class Near:
    """The part of a wall within reach of a stent, estimated from the probes."""

    count: float
    """Number of vertices."""
    area: float
    """Area of the wall, mm^2."""


class SampledWall:
    """The used vertices of a surface, cell by cell, with normals out of the lumen. Immutable.

    Parameters
    ----------
    surface : Surface
    inside : (k, 3) array
        Points in the lumen, mm; they show which side of an open surface is out.

    Attributes
    ----------
    vertices : (n,) array
        Numbers of the used vertices in the surface; rows of the other arrays have this order.
    points, normals : (n, 3) arrays
        Coordinates, mm, and unit normals.
    probes : (k, 3) array
        Some of the points, spread evenly among all, mm.
    """

    def __init__(self, surface: Surface, inside: Points) -> None:
        self.surface = surface
        triangles = _outward(surface, inside)
        normals = normals_at(surface.points, triangles)
        area = np.repeat(face_areas(surface.points, triangles) / 3, 3)
        count = len(surface.points)
        shares = np.bincount(surface.triangles.ravel(), area, minlength=count)
        is_used = np.zeros(count, dtype=bool)
        is_used[surface.triangles.ravel()] = True
        used = np.flatnonzero(is_used)
        order, self.starts = _in_cells(surface.points[used], CELL)
        self.vertices = used[order]
        self.points, self.normals = surface.points[self.vertices], normals[self.vertices]
        self._step = max(1, len(used) // PROBES)
        self.probes = self.points[:: self._step].copy()
        self._shares = shares[self.vertices][:: self._step]

    @cached_property
    def _centers(self) -> Points:
        counts = np.diff(self.starts)
        return np.add.reduceat(self.points, self.starts[:-1], axis=0) / counts[:, None]

    @cached_property
    def _radii(self) -> Floats:
        apart = self.points - np.repeat(self._centers, np.diff(self.starts), axis=0)
        return np.sqrt(np.maximum.reduceat(dot(apart, apart), self.starts[:-1]))

    def near(self, chain: CapsuleChain, reach: float) -> Near:
        """The part of the wall within a distance, mm, of a stent's axis."""
        is_near = chain.folding.nearest_nodes(self.probes)[1] < reach
        return Near(self._step * is_near.sum(), self._step * self._shares[is_near].sum())

    def cells_near(self, chain: CapsuleChain, reach: float) -> Indices:
        """Indices (k,) of cells with vertices within a distance, mm, of a stent's axis, and of
        others."""
        distance = chain.folding.nearest_nodes(self._centers)[1]
        return np.flatnonzero(distance < reach + self._radii)

    def rows_of(self, cells: Indices) -> Indices:
        """Rows (k,) of some cells."""
        return ranges(self.starts[cells], np.diff(self.starts)[cells])

    def sample(self, spacing: float) -> Indices:
        """Rows (k,) of vertices that keep a spacing, mm, from each other and leave no room for
        more.

        Vertices of walls that face each other do not count as near.
        """
        from scipy.spatial import cKDTree  # late: it costs half a second

        rows = self._candidates(spacing / GRID_SHARE)
        pairs = cKDTree(self.points[rows]).query_pairs(spacing, output_type="ndarray")
        first, second = self.normals[rows[pairs[:, 0]]], self.normals[rows[pairs[:, 1]]]
        return rows[_independent(len(rows), pairs[dot(first, second) > 0])]

    def _candidates(self, edge: float) -> Indices:
        """Indices of a point for every cube of a grid and every main direction that walls face in
        it."""
        largest = np.abs(self.normals).argmax(axis=1)
        facing = 2 * largest + (self.normals[np.arange(len(largest)), largest] > 0)
        key = _cube_numbers(self.points, edge) * 6 + facing
        return np.sort(np.unique(key, return_index=True)[1])


def _outward(surface: Surface, inside: Points) -> Triangles:
    """The triangles wound so that normals point out of the lumen."""
    points, triangles, shape = surface.points, surface.triangles, surface.topology
    if shape.is_closed and shape.is_consistently_wound and shape.component_count == 1:
        return triangles if signed_volume(points, triangles) > 0 else triangles[:, ::-1]
    return oriented_triangles(points, triangles, inside=inside)


def _cube_numbers(points: Points, edge: float) -> Indices:
    """Number (n,) of the cube of a grid that each point lies in."""
    cubes = np.floor((points - points.min(axis=0)) / edge).astype(np.int64)
    extent = cubes.max(axis=0) + 1
    return np.asarray((cubes[:, 0] * extent[1] + cubes[:, 1]) * extent[2] + cubes[:, 2])


def _in_cells(points: Points, edge: float) -> tuple[Indices, Indices]:
    """Order of the points by their cells, and the offsets at which cells begin and the last one
    ends."""
    key = _cube_numbers(points, edge)
    order = np.argsort(key, kind="stable")
    begins = np.flatnonzero(np.diff(key[order])) + 1
    return order, np.concatenate([[0], begins, [len(points)]])


def _independent(count: int, pairs: Indices) -> Indices:
    """A maximal set of numbers below `count` with no pair among them, the same every time."""
    rank = np.random.default_rng(count).permutation(count)
    is_open, is_chosen = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    # Ends: in every round the first in rank of the open ones is chosen.
    while is_open.any():
        wins = is_open.copy()
        wins[np.where(rank[pairs[:, 0]] > rank[pairs[:, 1]], pairs[:, 0], pairs[:, 1])] = False
        is_chosen |= wins
        is_open &= ~wins
        is_open[pairs[wins[pairs[:, 0]], 1]] = False
        is_open[pairs[wins[pairs[:, 1]], 0]] = False
        pairs = pairs[is_open[pairs].all(axis=1)]
    return np.flatnonzero(is_chosen)


SUPPORT = 6
"""Number of sample points that a vertex follows; weights fade to 0 at the distance of the next."""

STIFFNESS = 0.01
"""Regularization of the fit, over the sample's extent; it keeps it from extrapolating across a flat
wall."""

BEHIND = 1e-6
"""Weight of points on walls that face the other way; it counts only where there are no others."""

BLOCK = 1 << 14
"""Number of vertices whose weights are made at once."""


class Spreading:
    """The weights with which each vertex takes its displacement from its neighbors in a sample.

    A moving least-squares fit: constant and linear displacements are reproduced, and weights fade
    smoothly with distance and with the angle between the walls. They are made cell by cell when
    first needed, and kept.

    Parameters
    ----------
    wall : SampledWall
    sample : (p,) array
        Rows of the wall that are sampled.
    """

    def __init__(self, wall: SampledWall, sample: Indices) -> None:
        from scipy.spatial import cKDTree  # late: it costs half a second

        self._wall, self.sample = wall, sample
        self._support = min(SUPPORT, len(sample) - 1)
        self._tree = cKDTree(wall.points[sample])
        self._numbers = np.empty((len(wall.points), self._support), dtype=np.int32)
        self._weights = np.empty((len(wall.points), self._support), dtype=np.float32)
        self._is_made = np.zeros(len(wall.starts) - 1, dtype=bool)

    def made(self, cells: Indices) -> None:
        """Make the weights of the vertices in some cells."""
        rows = self._wall.rows_of(cells[~self._is_made[cells]])
        for start in range(0, len(rows), BLOCK):
            self._make(rows[start : start + BLOCK])
        self._is_made[cells] = True

    def carried(self, cells: Indices, displacement: Points) -> Points:
        """The displacement, mm, of the vertices in some cells, from that (p, 3) of the sample."""
        from scipy.sparse import csr_matrix

        self.made(cells)
        rows = self._wall.rows_of(cells)
        ends = np.arange(0, len(rows) * self._support + 1, self._support, dtype=np.int32)
        weights, numbers = self._weights[rows], self._numbers[rows]
        shape = (len(rows), len(self.sample))
        matrix = csr_matrix((weights.ravel(), numbers.ravel(), ends), shape=shape)
        return np.asarray(matrix @ displacement.astype(np.float32))

    def _make(self, rows: Indices) -> None:
        wall = self._wall
        distance, number = self._tree.query(wall.points[rows], k=self._support + 1)
        number = number[:, :-1]
        rows_near = self.sample[number]
        facing = np.einsum("nkj,nj->nk", wall.normals[rows_near], wall.normals[rows])
        share = 1 - distance[:, :-1] / np.maximum(distance[:, -1:], 1e-12)
        weight = share**2 * (np.maximum(facing, 0) ** 2 + BEHIND) + 1e-30
        offset = wall.points[rows_near] - wall.points[rows][:, None]
        self._numbers[rows] = number
        self._weights[rows] = linear_weights(offset, weight)


def linear_weights(offset: NDArray[np.float64], weight: NDArray[np.float64]) -> Points:
    """Weights (n, k) that add up to 1 and whose weighted mean of the offsets (n, k, 3) is nearly
    zero.

    Only nearly, because a flat wall does not show how anything changes across it; and where all
    points lie to one side, going less than the whole way is better than extrapolating.
    """
    weight = weight / weight.sum(axis=1, keepdims=True)
    mean = np.einsum("nk,nkj->nj", weight, offset)
    apart = offset - mean[:, None]
    spread = np.einsum("nk,nki,nkj->nij", weight, apart, apart, optimize=True)
    size = np.trace(spread, axis1=1, axis2=2)
    spread += (STIFFNESS * size + 1e-12)[:, None, None] * np.eye(3)
    slope = np.linalg.solve(spread, -mean[:, :, None])[:, :, 0]
    return np.asarray(weight * (1 + np.einsum("nkj,nj->nk", apart, slope)))


def moved_rows(displacement: Points) -> Indices:
    """Rows (k,) with a displacement other than zero."""
    return np.flatnonzero(dot(displacement, displacement) > 0)
