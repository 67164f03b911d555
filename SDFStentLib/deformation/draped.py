"""The wall draped over steep places of a stent's profile, where single edges would cut into it.

`facets_compensated` expects a circle between two vertices. Where the profile rises or falls within
an edge, the edge lies inside of the stent, however exactly its ends lie on it. So its ends are
moved out: like cloth over a corner the wall is wider beside it, and nowhere narrower.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..field import fractions_of
from ..geometry import norm
from ..validation import Floats, Points, Triangles
from .lumen import COARSEST_CHORD, edges_on_stent, largest_push, stent_distance
from .motion import Motion

SPACING = 0.25
"""Distance between the places that are checked along the edges, mm."""

MOST_PLACES = 16
"""Most places that are checked along an edge."""

NEGLIGIBLE = 1e-3
"""Share of the radius by which an edge may lie inside of a changing profile."""

ROUNDS = 30
"""Most rounds: where one end of an edge has gone as far as it may, the other follows slowly."""

LEAP = 2.0
"""Way of the nearest place on the axis, over the length of the edge, above which it has leapt."""


class _Edges(NamedTuple):
    """Edges between whose ends the profile is no straight line."""

    ends: NDArray[np.int64]
    """(e, 2) vertices."""
    widest: Floats
    """(e,) radius of the stent where it is widest along the edge, mm."""


def draped(motion: Motion, positions: Points, triangles: Triangles, radius: float) -> Points:
    """Push vertices out until no edge lies inside of the stent where its profile changes.

    A place of an edge that lies inside pushes both ends out, the nearer one more. No vertex goes
    farther out than a chord at the widest place of the stent along its edges can need.

    Parameters
    ----------
    motion : Motion
        The finished motion; only read.
    positions : (n, 3) array
        All corners, with facets compensated, mm; those that are not the motion's never move.
    triangles : (m, 3) array
        Triangles of the wall.
    radius : float
        Largest radius of the stent, mm.
    """
    ends, widest = _steep_edges(motion, positions, triangles, radius)
    if not len(ends):
        return positions
    sides = norm(positions[ends[:, 0]] - positions[ends[:, 1]])
    count = int(np.count_nonzero(motion.touchable))
    # An end that never moves keeps no tissue from the stent.
    offset = np.zeros(len(positions))
    offset[:count] = motion.offset[:count]
    wanted = radius + offset[ends].min(axis=1)
    farthest = np.zeros(len(positions))
    reach = widest + largest_push(sides, widest) + wanted - radius
    np.maximum.at(farthest, ends, reach[:, None])
    share = _places(float(sides.max()))
    toward = np.stack([1 - share, share]) / (share**2 + (1 - share) ** 2)
    positions, moved = positions.copy(), np.unique(ends)
    is_moved = np.zeros(len(positions), dtype=bool)
    for _ in range(ROUNDS):
        is_moved[:] = False
        is_moved[moved] = True
        todo = is_moved[ends].any(axis=1)
        deficit = wanted[todo, None] - _along(motion, positions, ends[todo], share, radius)
        push = np.zeros(len(positions))
        np.maximum.at(push, ends[todo], (deficit[:, None] * toward).max(axis=2))
        moved = np.flatnonzero(push[:count] > NEGLIGIBLE / 4 * radius)
        room = farthest[moved] - motion.axis_distance(moved, positions[moved])
        push = np.minimum(push[moved], np.maximum(room, 0))
        moved, push = moved[push > 0], push[push > 0]
        if not len(moved):
            break
        positions[moved] += push[:, None] * motion.outward[moved]
    return positions


def _steep_edges(motion: Motion, positions: Points, triangles: Triangles, radius: float) -> _Edges:
    """Edges along which the profile differs from a straight line by more than a
    negligible amount."""
    shares = motion.chain.shares
    assert shares is not None
    movable = np.arange(np.count_nonzero(motion.touchable))
    ends = edges_on_stent(triangles, movable, len(positions))
    at = fractions_of(positions, motion.chain.line)[ends]
    share = np.linspace(0, 1, MOST_PLACES + 2)
    between = shares.along(at[:, :1] + share * (at[:, 1:] - at[:, :1]))
    straight = between[:, :1] + share * (between[:, -1:] - between[:, :1])
    widest = radius * between.max(axis=1)
    is_steep = (between - straight > NEGLIGIBLE * between).any(axis=1)
    # Inside of a tight bend the nearest place of the axis leaps.
    sides = norm(positions[ends[:, 0]] - positions[ends[:, 1]])
    is_steep |= np.abs(at[:, 1] - at[:, 0]) * motion.chain.length > LEAP * sides
    # The corner of a flattened end lies on an edge that leads beyond it.
    if shares.are_flattened:
        is_beyond = (at <= 0) | (at >= 1)
        is_steep |= is_beyond[:, 0] != is_beyond[:, 1]
    # Longer edges, such as those of a cap elsewhere, cannot follow the stent at all.
    is_steep &= sides < 2 * COARSEST_CHORD * widest
    return _Edges(ends[is_steep], widest[is_steep])


def _places(longest: float) -> Floats:
    """Places to check along an edge, as shares of its length; none of them is an end."""
    count = int(np.clip(np.ceil(longest / SPACING), 3, MOST_PLACES))
    return np.linspace(0, 1, count + 2)[1:-1]


def _along(
    motion: Motion, positions: Points, ends: NDArray[np.int64], share: Floats, radius: float
) -> Floats:
    """`stent_distance` (e, k) at places along edges."""
    first, second = positions[ends[:, 0], None], positions[ends[:, 1], None]
    places = first + share[:, None] * (second - first)
    near = np.repeat(ends[:, 0], len(share))
    return stent_distance(motion, near, places.reshape(-1, 3), radius).reshape(len(ends), -1)
