"""The way from the last radius step to the prescribed lumen.

The published method leaves the wall within a few hundredths of the smoothed field's level, and a
lumen of flat facets is narrower than its vertices. Here vertices in contact are put on the true
distance from the axis, then pushed out until the facets' chords lie at the prescribed radius.

The motion is over and is only read: its levels and directions are those at its end, and positions
are taken and returned.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..field import fractions_of
from ..geometry import dot, nearest_distances
from ..validation import Points, Triangles
from .motion import Motion

CONTACT_BAND = 1.5
"""Distance from the final level, in contact tolerances, within which a point lies on the stent."""

FINISH_ROUNDS = 2

DRAG_BOUND = 2.0
"""Largest factor by which dragging may increase the distance of wall from the expanded stent.

Any factor above 1 lets the bound begin without a
jump where the stent just reaches. With 2, wall goes no farther out than it was away from the stent.
"""

UNREACHED_BOUND = 1.15
"""Factor of the drag bound round a lumen that the stent does not reach, from that lumen's wall.

The wall of a slope is farther from the axis than the lumen there is wide; a lumen is that of its
nearest wall. So at 45 degrees this widens it by 0.15 (1 - cos 45) of its radius, 4.4 %, and it may
become wider by 5 %.
"""

UNREACHED = 0.1
"""Share by which a lumen wider than the stent counts as not reached; up to there by degrees."""

NEGLIGIBLE = 1e-4
"""Share of the radius by which facets may miss it and still be fine enough as they are."""

ROUNDING = 1e-9
"""Relative difference below which two distances count as equal."""

COARSEST_CHORD = np.sqrt(0.5)
"""Sine of half the angle, seen from the axis, of the longest chord that is compensated: 90 degrees.

Pushing both ends of a chord out brings its middle out by the cosine of half its angle: at 90
degrees by 0.7 of it, at 120 by half, at 180 by nothing.
"""

COARSEST_REACH = np.sqrt(2.0)
"""Distance from the axis, in radii, of the ends of such a chord whose middle is at the radius."""

BEND_SLACK = 1.5
"""Largest push of a vertex, over what a chord round a straight axis needs.

In 24 random stents of the anatomies the largest push was 1.05 times that, in bends more.
"""

COMPENSATION_PASSES = 2
COMPENSATION_ROUNDS = 5


class Expanded(NamedTuple):
    """The stent at its target: field level, radius and contact tolerance, mm."""

    level: float
    radius: float
    contact_tolerance: float


class OnStent(NamedTuple):
    """Positions (n, 3) of all points, mm, and the numbers (k,) of those newly on the stent."""

    positions: Points
    numbers: NDArray[np.int64]


class OwnWall(NamedTuple):
    """Points of the stented lumen's own wall."""

    numbers: NDArray[np.int64]
    """(k,)"""
    share: NDArray[np.float64]
    """(k,) how certain it is that they are, in (0, 1]."""
    start: Points
    """(k, 3) their places before anything moved, mm."""


def finished(motion: Motion, stent: Expanded) -> OnStent:
    """Move the points on the stent to the prescribed true distance from the axis.

    They move along the field's direction, which keeps the smoothness of the published deformation.
    This removes ripple, asymmetry in bends, the contact tolerance and the narrowing at the ends.

    Parameters
    ----------
    motion : Motion
        Settled motion: its levels are evaluated, not extrapolated.
    stent : Expanded
    """
    band = stent.level + CONTACT_BAND * stent.contact_tolerance
    positions = motion.positions.copy()
    near = motion.level < band + motion.chain.smoothing_width
    where = np.flatnonzero(near & motion.touchable)
    true_distance = stent_distance(motion, where, positions[where], stent.radius)
    wanted = stent.radius + motion.offset[where]
    on_stent = (motion.level[where] < band) | (true_distance < wanted)
    where, wanted, true_distance = where[on_stent], wanted[on_stent], true_distance[on_stent]
    for round_ in range(FINISH_ROUNDS):
        if round_:
            true_distance = stent_distance(motion, where, positions[where], stent.radius)
        positions[where] += (wanted - true_distance)[:, None] * motion.outward[where]
    return OnStent(positions, where)


def drawn_in(motion: Motion, positions: Points, own: OwnWall, stent: Expanded) -> OnStent:
    """Bring back wall that ran ahead of the stent and ended outside of it.

    A stent only pushes. Wall that it reaches has no cause to end up outside of it, nor has wall
    round a wider lumen to go out; but near contact the published rule drags both along. A point
    out of contact influences nobody, so this is the same as if its dragging had stopped there. It
    concerns only the stented lumen's own wall. Beyond the ends, where dragging makes the
    transition to the wall that rests, wall may lie as far out as it is beyond the end.

    Parameters
    ----------
    motion : Motion
        Settled motion.
    positions : (n, 3) array
        Finished positions, mm.
    own : OwnWall
        The points, each with the share by which it is brought back.
    stent : Expanded
    """
    positions, radius = positions.copy(), stent.radius
    moved = np.linalg.norm(positions[own.numbers] - own.start, axis=1)
    outside = motion.distance_at(motion.level - stent.level)[own.numbers]
    may_be = (outside > 0) & (moved > 0)
    where, share = own.numbers[may_be], own.share[may_be]
    start = own.start[may_be]
    native = stent_distance(motion, where, start, radius)
    distance = stent_distance(motion, where, positions[where], radius)
    nearest = nearest_distances(motion.chain.nodes, own.start)
    # The bound falls with the lumen up to the wall's own distance: the widest one has the least.
    widest = np.maximum(nearest.max() + motion.chain.shortfall(start, radius), radius)
    least = _allowed(np.minimum(widest, np.maximum(native, radius)), native, radius)
    doubtful = np.flatnonzero(distance > (least + motion.offset[where]) * (1 - ROUNDING))
    where, share, start = where[doubtful], share[doubtful], start[doubtful]
    native, distance = native[doubtful], distance[doubtful]
    lumen = np.maximum(_native_lumen(motion, nearest, start, radius), radius)
    allowed = _allowed(lumen, native, radius)
    bound = allowed + _beyond_ends(motion, where, positions[where]) + motion.offset[where]
    too_far = distance > bound * (1 + ROUNDING)
    where, bound = where[too_far], (distance + share * (bound - distance))[too_far]
    for _ in range(FINISH_ROUNDS):
        true_distance = stent_distance(motion, where, positions[where], stent.radius)
        positions[where] += (bound - true_distance)[:, None] * motion.outward[where]
    return OnStent(positions, where[bound <= (1 + NEGLIGIBLE) * radius])


def _allowed(
    lumen: NDArray[np.float64], native: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Largest distance (n,) from the axis where wall of a native distance may end, all in mm."""
    unreached = np.minimum((lumen / radius - 1) / UNREACHED, 1)
    factor = DRAG_BOUND + (UNREACHED_BOUND - DRAG_BOUND) * unreached
    return lumen + factor * np.maximum(native - lumen, 0)


def _native_lumen(
    motion: Motion, nearest: NDArray[np.float64], beside: Points, radius: float
) -> NDArray[np.float64]:
    """Distance (n,), mm, from the axis beside points to the nearest wall, by those at the nodes."""
    line = motion.chain.line
    along = line.arc_lengths / line.arc_lengths[-1]
    found = np.interp(fractions_of(beside, line), along, nearest)
    return found + motion.chain.shortfall(beside, radius)


def facets_compensated(
    motion: Motion,
    positions: Points,
    triangles: Triangles,
    on_stent: NDArray[np.int64],
    radius: float,
) -> Points:
    """Positions (n, 3) with vertices pushed out until edges at the stent reach its radius, mm.

    The distance to a straight axis is convex, so a facet is nearest to it on one of its edges;
    along an edge its square is a parabola through the two ends and the middle. Every vertex moves
    by the largest deficit of its edges, back again where all of them are too far out, but never
    farther in than it was, nor farther out than its longest edge can need: see `largest_push`.
    Facets that are too coarse for their stent stay inside. Vertices beside the stent take part,
    because an edge from one of them to the stent can cut into the lumen as well, and so can one
    between two of them. What remains is measured on the result: see `stent_checks`.
    """
    cutting = _cutting_edges(motion, positions, triangles, radius)
    ends = edges_on_stent(triangles, np.concatenate([on_stent, cutting.ravel()]), len(positions))
    sides = positions.take(ends[:, 0], axis=0) - positions.take(ends[:, 1], axis=0)
    longest = dot(sides, sides).max(initial=0)
    # An edge between two points of a circle lies inside it by its length squared over 8 radii.
    if longest < 8 * NEGLIGIBLE * motion.chain.least_radius(radius) ** 2:
        return positions
    # Sorted by vertex, the edges of each follow each other.
    order = np.argsort(ends.ravel(), kind="stable")
    by_vertex = ends.ravel()[order]
    starts = np.flatnonzero(np.concatenate([[True], by_vertex[1:] != by_vertex[:-1]]))
    group = by_vertex[starts]
    number = np.empty(len(positions), dtype=np.int64)
    number[group] = np.arange(len(group))
    ends = number[ends]

    edge_wanted = radius + motion.offset[group][ends].min(axis=1)
    edge_length = np.linalg.norm(sides, axis=1)
    local = edge_wanted - motion.chain.shortfall(_middles(positions[group], ends), radius)
    bound = np.maximum.reduceat(largest_push(edge_length, local)[order // 2], starts)
    start, direction = positions[group], motion.outward[group]
    distance = stent_distance(motion, group, start, radius)
    pushed = np.zeros(len(group))
    for _ in range(COMPENSATION_PASSES):
        moved = start + pushed[:, None] * direction
        # Within a pass the middle of an edge is taken to follow its two ends.
        middle = stent_distance(motion, group[ends[:, 0]], _middles(moved, ends), radius)
        measured_at = pushed.copy()
        for _ in range(COMPENSATION_ROUNDS):
            change = _middles(pushed - measured_at, ends)
            deficit = edge_wanted - _edge_distance(
                (distance + pushed)[ends], middle + change * middle / edge_wanted
            )
            push = np.maximum.reduceat(deficit[order // 2], starts)
            np.clip(push, -pushed, bound - pushed, out=push)
            pushed += push
            if np.abs(push).max() < 1e-4 * radius:
                break
    positions = positions.copy()
    positions[group] = start + pushed[:, None] * direction
    return positions


def _cutting_edges(
    motion: Motion, positions: Points, triangles: Triangles, radius: float
) -> NDArray[np.int64]:
    """Edges (e, 2) between vertices beside the stent that cut into it."""
    distance = (motion.distance_at(motion.level) + motion.offset)[: len(positions)]
    near = np.flatnonzero(distance < COARSEST_REACH * radius)
    ends = edges_on_stent(triangles, near, len(positions))
    sides = positions[ends[:, 0]] - positions[ends[:, 1]]
    # At a straight axis no place of an edge is nearer than this.
    nearest = distance[ends].min(axis=1) ** 2 - dot(sides, sides) / 4
    wanted = radius + motion.offset[ends].min(axis=1)
    may_cut = np.flatnonzero(nearest < wanted**2)
    ends, wanted = ends.take(may_cut, axis=0), wanted[may_cut]
    is_used = np.zeros(len(positions), dtype=bool)
    is_used[ends] = True
    used = np.flatnonzero(is_used)
    distance[used] = stent_distance(motion, used, positions[used], radius)
    middle = stent_distance(motion, ends[:, 0], _middles(positions, ends), radius)
    inside = _edge_distance(distance[ends], middle) < (1 - NEGLIGIBLE) * wanted
    return ends[inside]


def largest_push(length: ArrayLike, radius: ArrayLike) -> NDArray[np.float64]:
    """Largest outward move of the ends of chords until their middles reach a radius, mm.

    Both ends of a chord of length e at a radius r lie at the angle a from its middle, with sin a =
    e / 2 r, and its middle at r cos a. With the ends at r / cos a the middle has come to r. This is
    followed up to a right angle between the ends; there the push is largest, (sqrt(2) - 1) r.

    Parameters
    ----------
    length : array_like
        Length of the chords, mm.
    radius : array_like
        Radius that their middles shall have, mm.
    """
    radius = np.asarray(radius, dtype=np.float64)
    sine = np.minimum(np.asarray(length) / (2 * radius), COARSEST_CHORD)
    needed = radius * (1 / np.sqrt(1 - sine**2) - 1)
    return np.minimum(BEND_SLACK * needed, (np.sqrt(2.0) - 1) * radius)


def stent_distance(
    motion: Motion, where: NDArray[np.int64], positions: Points, radius: float
) -> NDArray[np.float64]:
    """Distance (k,) to the axis, mm, that points would have elsewhere, as if the stent were even.

    Where the stent is narrower than `radius`, the shortfall is added to the distance: so every
    place of the stent is at `radius`.
    """
    true_distance = motion.axis_distance(where, positions)
    return true_distance + motion.chain.shortfall(positions, radius)


def edges_on_stent(
    triangles: Triangles, on_stent: NDArray[np.int64], count: int
) -> NDArray[np.int64]:
    """Edges (e, 2) with an end on the stent, each once, among the first `count` vertices."""
    is_on_stent = np.zeros(int(triangles.max(initial=count)) + 1, dtype=bool)
    is_on_stent[on_stent] = True
    keys = []
    for start, end in ((0, 1), (1, 2), (2, 0)):
        first, second = triangles[:, start], triangles[:, end]
        # Ascending, so that an edge has one key from both of its faces.
        first, second = np.minimum(first, second), np.maximum(first, second)
        wanted = (is_on_stent[first] | is_on_stent[second]) & (second < count)
        keys.append(first[wanted] * count + second[wanted])
    key = np.sort(np.concatenate(keys))
    key = key[np.concatenate([[True], key[1:] != key[:-1]])] if len(key) else key
    return np.stack(np.divmod(key, count), axis=1)


def _middles(values: NDArray[np.float64], ends: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean of the values at both ends of every edge."""
    return 0.5 * (values[ends[:, 0]] + values[ends[:, 1]])


def _edge_distance(ends: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smallest distance along edges, from those at both ends (e, 2) and at the middle (e,)."""
    first, second, half = ends[:, 0] ** 2, ends[:, 1] ** 2, middle**2
    curvature = 2 * (first + second - 2 * half)
    slope = 4 * half - 3 * first - second
    curved = curvature > 1e-12
    at = np.clip(np.divide(-slope, 2 * curvature, out=np.full(len(half), 0.5), where=curved), 0, 1)
    return np.sqrt(np.maximum(first + slope * at + curvature * at**2, 0))


def _beyond_ends(
    motion: Motion, where: NDArray[np.int64], positions: Points
) -> NDArray[np.float64]:
    """Distance of points beyond the planes across the stent's ends, mm; 0 beside the stent."""
    nodes = motion.chain.nodes
    nearest = motion.axis_distance(where, positions) * (1 + ROUNDING)
    beyond = np.zeros(len(where))
    for end, inner in (nodes[:2], nodes[:-3:-1]):
        offset = positions - end
        along = offset @ (end - inner) / np.linalg.norm(end - inner)
        at_end = np.linalg.norm(offset, axis=1) <= nearest
        beyond[at_end] = np.maximum(along[at_end], 0)
    return beyond
