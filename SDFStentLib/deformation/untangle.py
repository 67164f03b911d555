"""Taking apart what still folds: a last, local resort after the deformation.

The positions of the few vertices round a fold are smoothed under the constraint that none enters
the stent, which keeps the prescribed lumen. What this achieves was measured: see docs/method.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..certificate import Comparison, Verdict
from ..geometry import Surface, VertexNeighbors, faces_at, ranges, vertex_neighbors
from ..validation import Flags, Place, Points, Triangles, as_place
from .motion import Motion

ROUNDS = 40
ROUNDS_PER_RING = 4
IDLE_ROUNDS = 10
"""Rounds without fewer faults after which untangling gives up.

Of the 144 that succeeded in 450 random stents none was idle for more than 8."""
RELAXATION = 0.5
"""Share of the way to the mean of its neighbors that a vertex goes in a round."""

WAYS_TO_UNTANGLE = ((RELAXATION, False), (0.2, False), (RELAXATION, True))
"""Shares of the way to the mean of the neighbors, and whether the lumen is relieved, in turn.

The first is quick. The second resolves some folds in which the first swings to and fro. The third
takes the facet compensation back round the fold: some facets there lie inside again, by up to the
height of their arc, and those that it had pushed into each other come free.
"""

FEW_FAULTS = 20
"""Number of faulty faces up to which the next way is tried; 4 to 11 were left where it helped."""

RELIEVED_RINGS = 3


class Relief(NamedTuple):
    """A place where the facet compensation was taken back to take a fold apart."""

    center: Place
    """The point that was taken back farthest, mm."""
    depth: float
    """Distance by which that point was taken back, mm; facets now lie inside by about as much."""

    def caution(self) -> Caution:
        """A caution for the person who will use the surface."""
        return Caution("facets-inside", {"depth_mm": self.depth}, self.center)


class Tangle(NamedTuple):
    """A state of the patch with its faults, and how it came about."""

    positions: Points
    """(n, 3) of all vertices of the patch, mm."""
    faulty: NDArray[np.int64]
    """Triangles of the patch that fail and did not before the deployment."""
    rounds: int = 0
    relief: Relief | None = None


def taken_apart(
    motion: Motion, level: float, comparison: Comparison, folded: Tangle, uncompensated: Points
) -> Tangle:
    """Untangle in one way after the other; the best state counts, without a fault if possible.

    Parameters
    ----------
    motion, level, comparison : Motion, float, Comparison
        As for `untangled`.
    folded : Tangle
        The state to begin with.
    uncompensated : (n, 3) array
        Points of the motion before the compensation of facets, mm.
    """
    best, rounds = folded, 0
    for relaxation, is_relieved in WAYS_TO_UNTANGLE:
        begin = _relieved(folded, comparison, uncompensated, motion) if is_relieved else folded
        outcome = untangled(motion, level, comparison, begin, relaxation)
        rounds += outcome.rounds
        if len(outcome.faulty) < len(best.faulty):
            best = outcome
        if not 0 < len(best.faulty) <= FEW_FAULTS:
            break
    return best._replace(rounds=rounds)


def _relieved(
    folded: Tangle, comparison: Comparison, uncompensated: Points, motion: Motion
) -> Tangle:
    """The state with facet compensation taken back round faulty faces, and its faults."""
    triangles, positions = comparison.triangles, folded.positions.copy()
    neighbors = vertex_neighbors(triangles, len(positions))
    near = grown(np.unique(triangles[folded.faulty]), neighbors, RELIEVED_RINGS)
    near = near[near < np.count_nonzero(motion.touchable)]
    pushed = np.linalg.norm(positions[near] - uncompensated[near], axis=1)
    relief = None
    if pushed.any():
        relief = Relief(as_place(uncompensated[near[pushed.argmax()]]), float(pushed.max()))
    positions[near] = uncompensated[near]
    faulty = comparison.new_faults(positions, _faces_at(near, triangles, len(positions)))
    return Tangle(positions, faulty, relief=relief)


def untangled(
    motion: Motion,
    level: float,
    comparison: Comparison,
    begin: Tangle,
    relaxation: float = RELAXATION,
) -> Tangle:
    """Smooth positions round faulty triangles; the best state counts, without a fault if possible.

    Parameters
    ----------
    motion : Motion
        The finished motion; the patch's first vertices are its points that can be touched.
    level : float
        Field level of the expanded stent, mm: no vertex outside it may enter.
    comparison : Comparison
        Comparison with the patch before the deployment, consistently wound.
    begin : Tangle
    relaxation : float
        Share of the way to the mean of the neighbors in every round.
    """
    triangles, wall_count = comparison.triangles, int(np.count_nonzero(motion.touchable))
    after, bad = begin.positions.copy(), begin.faulty
    neighbors = vertex_neighbors(triangles, len(after))
    # Least distance of each vertex: its own or that of the stent; found when it first moves.
    floor = (motion.distance_at(level) + motion.offset)[:wall_count]
    is_known = np.zeros(wall_count, dtype=bool)
    best, rounds, idle = begin, 0, 0
    # Ends: counted; the best state is kept.
    while len(bad) and rounds < ROUNDS and idle < IDLE_ROUNDS:
        group = grown(np.unique(triangles[bad]), neighbors, rounds // ROUNDS_PER_RING)
        group = group[group < wall_count]
        new = group[~is_known[group]]
        floor[new] = np.minimum(floor[new], motion.field_at(new, after[new]).distance)
        is_known[new] = True
        smooth = _neighbor_mean(after, neighbors, group)
        target = after[group] + relaxation * (smooth - after[group])
        field = motion.field_at(group, target)
        short = np.maximum(floor[group] - field.distance, 0)
        after[group] = target + short[:, None] * field.direction

        among = np.union1d(_faces_at(group, triangles, len(after)), bad)
        bad = comparison.new_faults(after, among)
        rounds += 1
        idle += 1
        if len(bad) < len(best.faulty):
            best, idle = best._replace(positions=after.copy(), faulty=bad), 0
    return best._replace(rounds=rounds)


def _faces_at(vertices: NDArray[np.int64], triangles: Triangles, count: int) -> NDArray[np.int64]:
    """Faces with a corner at any of some vertices; `count` is the number of all vertices."""
    is_there = np.zeros(count, dtype=bool)
    is_there[vertices] = True
    return np.flatnonzero(faces_at(is_there, triangles))


def grown(vertices: NDArray[np.int64], neighbors: VertexNeighbors, rings: int) -> NDArray[np.int64]:
    """Indices (k,) of vertices together with a number of rings of neighbors round them."""
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
    """Number of neighbors of each of some vertices, and all the neighbors, row after row."""
    starts = neighbors.offsets[vertices]
    counts = neighbors.offsets[vertices + 1] - starts
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return counts, neighbors.indices[np.repeat(starts, counts) + within]


class Relaxed(NamedTuple):
    """Places of all points (n, 3), mm, and the verdict on the whole surface."""

    points: Points
    verdict: Verdict


def relaxed(surface: Surface, points: Points, comparison: Comparison, first: Verdict) -> Relaxed:
    """Smooth the outer side of a wall round its faults until none is left, or give up.

    In a crotch the outer side is finer than the lumen and bends the other way, so that a shift that
    is smooth along the lumen may be too steep for it. The state with the fewest faults counts.

    Parameters
    ----------
    surface : Surface
        The surface before the deployment.
    points : (n, 3) array
        Points after the deployment, mm; those of the lumen stay.
    comparison, first
        Comparison of the whole surface, and its verdict on these points.
    """
    whole = surface.whole
    goes_along = np.zeros(len(points), dtype=bool)
    goes_along[surface.followers] = True
    best = last = Relaxed(points, first)
    free = np.zeros(len(points), dtype=bool)
    idle = 0
    for round_ in range(ROUNDS):
        if best.verdict.passed or idle > IDLE_ROUNDS:
            break
        free[whole.triangles[last.verdict.failing]] = True
        if round_ % ROUNDS_PER_RING == ROUNDS_PER_RING - 1:
            free[whole.triangles[faces_at(free, whole.triangles)]] = True
        moved = surface.with_copies(_relaxed_once(whole, last.points, free & goes_along))
        last = Relaxed(moved, comparison.verdict(moved, last.verdict))
        idle += 1
        if len(last.verdict.failing) < len(best.verdict.failing):
            best, idle = last, 0
    return best


def _relaxed_once(surface: Surface, points: Points, free: Flags) -> Points:
    """Points (n, 3), with the free ones moved a part of the way to the mean of their neighbors."""
    offsets, neighbors = surface.neighbors
    where = np.flatnonzero(free & (np.diff(offsets) > 0))
    counts = np.diff(offsets)[where]
    around = points[neighbors[ranges(offsets[where], counts)]]
    owner = np.repeat(np.arange(len(where)), counts)
    sums = np.stack([np.bincount(owner, column, len(where)) for column in around.T], axis=1)
    moved = points.copy()
    moved[where] += RELAXATION * (sums / counts[:, None] - moved[where])
    return moved
