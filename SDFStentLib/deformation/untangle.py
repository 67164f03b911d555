"""Take apart what still folds: a last, local resort after the deformation.

Source of the remedy: measured in ../docs/method.md; smoothing the positions of the few vertices
round a fold, under the constraint that none enters the stent, keeps the prescribed lumen.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..certificate import degenerate_triangles, inverted_triangles, self_intersecting_triangles
from ..geometry import Precision, VertexNeighbors, faces_at, vertex_neighbors
from ..validation import Points, Triangles
from .motion import Motion

ROUNDS = 40
ROUNDS_PER_RING = 4
IDLE_ROUNDS = 10
"""Rounds without fewer faults after which it is given up.

Of 144 that came to a good end in 450 random stents none was idle for more than 8."""
RELAXATION = 0.5
"""Share of the way to the mean of the neighbors."""


class Relief(NamedTuple):
    """A place where the facet compensation was taken back to take a fold apart."""

    center: tuple[float, float, float]
    """The point that was taken back farthest, mm."""
    depth: float
    """By how much, mm: about as far as facets now lie inside."""

    def caution(self) -> Caution:
        """For the person who will use the surface."""
        return Caution("facets-inside", {"depth_mm": self.depth}, self.center)


@dataclass(frozen=True)
class Faults:
    """What must not come anew.

    Attributes
    ----------
    before : (n, 3) array
        Vertices of the patch before the deployment, mm.
    triangles : (m, 3) array
        Consistently wound.
    precision : Precision
    """

    before: Points
    triangles: Triangles
    precision: Precision

    def among(self, after: Points, faces: NDArray[np.int64]) -> NDArray[np.int64]:
        """Faces that intersect, are turned over or without area now and were not before.

        A face can be turned over by its neighbours too, so these are judged with it. The state
        before is looked at only where something is wrong now.
        """
        stored, before = self.precision.stored(after), self._stored_before
        found = self_intersecting_triangles(stored, self.triangles, faces)
        known = self_intersecting_triangles(before, self.triangles, found) if len(found) else found
        new = [np.setdiff1d(found, known)]
        at_faces = np.zeros(len(stored), dtype=bool)
        at_faces[self.triangles[faces]] = True
        beside = np.flatnonzero(faces_at(at_faces, self.triangles))
        for look, judged in ((inverted_triangles, beside), (degenerate_triangles, faces)):
            now = look(stored, self.triangles, judged)
            new.append(np.setdiff1d(now, look(before, self.triangles, now)))
        return np.unique(np.concatenate(new))

    @cached_property
    def _stored_before(self) -> Points:
        return self.precision.stored(self.before)


class Untangled(NamedTuple):
    """What came of it."""

    positions: Points
    """All points, mm."""
    rounds: int
    remaining: NDArray[np.int64]
    """Triangles that still fail and did not before."""


def untangled(
    motion: Motion,
    positions: Points,
    faults: Faults,
    level: float,
    bad: NDArray[np.int64],
    relaxation: float = RELAXATION,
) -> Untangled:
    """Smooth positions round faulty triangles until there are none, or as few as it came to.

    Parameters
    ----------
    motion : Motion
        Over; the patch's first vertices are its points that can be touched.
    positions : (n, 3) array
        Of its points, mm.
    faults : Faults
        The patch and what must not come anew.
    level : float
        Field level of the expanded stent, mm: no vertex outside it may enter.
    bad : (k,) array
        Triangles to begin with.
    relaxation : float
        Share of the way to the mean of the neighbors in every round.
    """
    triangles, wall_count = faults.triangles, int(np.count_nonzero(motion.touchable))
    after = np.concatenate([positions[:wall_count], faults.before[wall_count:]])
    neighbors = vertex_neighbors(triangles, len(after))
    held = motion.field_at(np.arange(wall_count), after[:wall_count]).distance
    floor = np.minimum(held, level + motion.offset[:wall_count])
    fewest, best = bad, after.copy()
    rounds = idle = 0
    # Ends: counted; the best state is kept.
    while len(bad) and rounds < ROUNDS and idle < IDLE_ROUNDS:
        group = grown(np.unique(triangles[bad]), neighbors, rounds // ROUNDS_PER_RING)
        group = group[group < wall_count]
        smooth = _neighbor_mean(after, neighbors, group)
        target = after[group] + relaxation * (smooth - after[group])
        field = motion.field_at(group, target)
        short = np.maximum(floor[group] - field.distance, 0)
        after[group] = target + short[:, None] * field.direction

        touched = np.zeros(len(after), dtype=bool)
        touched[group] = True
        among = np.union1d(np.flatnonzero(faces_at(touched, triangles)), bad)
        bad = faults.among(after, among)
        rounds += 1
        idle += 1
        if len(bad) < len(fewest):
            fewest, best, idle = bad, after.copy(), 0
    return Untangled(np.concatenate([best[:wall_count], positions[wall_count:]]), rounds, fewest)


def grown(vertices: NDArray[np.int64], neighbors: VertexNeighbors, rings: int) -> NDArray[np.int64]:
    """Vertices of a surface with that many rings of neighbors."""
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
