"""Fixed sparse weights that carry displacements from a sample of a wall to its vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import dot
from ..validation import Indices, Points
from .proxy_sample import SampledWall

SUPPORT = 6
"""Points of the sample that a vertex follows; the next one is where their weights have faded."""

STIFFNESS = 0.01
"""Share of the sample's extent that keeps the fit from extrapolating across a flat wall."""

BEHIND = 1e-6
"""Weight of points on walls that look the other way: it counts only where there are no others."""

BLOCK = 1 << 14
"""Vertices whose weights are made at once."""


class Spreading:
    """What of a displacement each vertex takes from its neighbors in a sample.

    A moving least-squares fit: constant and linear displacements arrive as they are, and what a
    vertex takes fades smoothly with distance, and with the angle between the walls. Weights are
    made cell by cell when they are first needed, and kept.

    Parameters
    ----------
    wall : SampledWall
    sample : (p,) array
        Rows of the wall.
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
    """Weights (n, k) that add up to 1, and whose mean of the offsets (n, k, 3) is zero, nearly.

    Nearly, because a flat wall does not say how anything changes across it; and where all points
    lie to one side, taking less than the whole way is better than extrapolating.
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
    """Rows that are displaced at all."""
    return np.flatnonzero(dot(displacement, displacement) > 0)
