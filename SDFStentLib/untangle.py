"""Take apart what still folds: a last, local resort after the deformation.

Source of the remedy: measured in ../docs/method.md; smoothing the positions of the few vertices
round a fold, under the constraint that none enters the stent, keeps the prescribed lumen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .intersections import self_intersecting_triangles
from .motion import Motion
from .topology import VertexNeighbors, vertex_neighbors
from .validation import Points, Triangles

ROUNDS = 40
ROUNDS_PER_RING = 4
RELAXATION = 0.3


class Precision(NamedTuple):
    """How coordinates will be stored: the certificate is about the stored numbers."""

    dtype: DTypeLike = np.float64
    scale: float = 1.0
    """File units per mm."""


class Untangled(NamedTuple):
    """What came of it."""

    rounds: int
    remaining: NDArray[np.int64]
    """Triangles that still intersect and did not before."""


def new_intersections(
    before: Points,
    after: Points,
    triangles: Triangles,
    among: NDArray[np.int64],
    precision: Precision,
) -> NDArray[np.int64]:
    """Triangles that intersect another one now and did not before.

    The state before is looked at only when something intersects now.
    """
    found = self_intersecting_triangles(after, triangles, among, **precision._asdict())
    if not len(found):
        return found
    known = self_intersecting_triangles(before, triangles, found, **precision._asdict())
    return np.setdiff1d(found, known)


def untangled(
    motion: Motion,
    before: Points,
    triangles: Triangles,
    wall_count: int,
    level: float,
    precision: Precision,
) -> Untangled:
    """Smooth positions round triangles that intersect anew until none does.

    Parameters
    ----------
    motion : Motion
        The deformed wall; changed in place.
    before : (n, 3) array
        All vertices of the patch before the deployment, mm.
    triangles : (m, 3) array
        The patch's triangles.
    wall_count : int
        The first so many vertices are the first points of the motion; the others never move.
    level : float
        Field level of the expanded stent, mm: no vertex outside it may enter.
    precision : Precision
        How the result will be stored.
    """
    after = np.concatenate([motion.positions[:wall_count], before[wall_count:]])
    moved = (after != before).any(axis=1)
    among = np.flatnonzero(moved[triangles].any(axis=1))
    bad = new_intersections(before, after, triangles, among, precision)
    if not len(bad):
        return Untangled(0, bad)

    neighbors = vertex_neighbors(triangles, len(before))
    held = motion.chain.field(after[:wall_count]).distance
    floor = np.minimum(held, level + motion.offset[:wall_count])
    for round_ in range(ROUNDS):
        group = _grown(np.unique(triangles[bad]), neighbors, round_ // ROUNDS_PER_RING)
        group = group[group < wall_count]
        smooth = _neighbor_mean(after, neighbors, group)
        target = after[group] + RELAXATION * (smooth - after[group])
        field = motion.chain.field(target)
        short = np.maximum(floor[group] - field.distance, 0)
        after[group] = target + short[:, None] * field.direction
        motion.moved_to(group, after[group])

        touched = np.zeros(len(before), dtype=bool)
        touched[group] = True
        among = np.union1d(np.flatnonzero(touched[triangles].any(axis=1)), bad)
        bad = new_intersections(before, after, triangles, among, precision)
        if not len(bad):
            return Untangled(round_ + 1, bad)
    return Untangled(ROUNDS, bad)


def _grown(
    vertices: NDArray[np.int64], neighbors: VertexNeighbors, rings: int
) -> NDArray[np.int64]:
    """Vertices with that many rings of neighbors."""
    for _ in range(rings):
        vertices = np.unique(np.concatenate([vertices, _rows(neighbors, vertices)[1]]))
    return vertices


def _neighbor_mean(
    points: Points, neighbors: VertexNeighbors, vertices: NDArray[np.int64]
) -> Points:
    counts, joined = _rows(neighbors, vertices)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    return np.add.reduceat(points[joined], starts, axis=0) / counts[:, None]


def _rows(
    neighbors: VertexNeighbors, vertices: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Number of neighbors of some vertices and the neighbors themselves, row after row."""
    starts = neighbors.offsets[vertices]
    counts = neighbors.offsets[vertices + 1] - starts
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return counts, neighbors.indices[np.repeat(starts, counts) + within]
