"""The check whether the wall lies inside of a stent.

A sphere climbs to where there is room: beside a stent that lies off the middle of a wide lumen, or
where the stent is narrower beside it. So the wall itself is looked at: its distance from the line
that the stent is meant to follow, as well as capsules of the paper would, against the stent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..certificate import NARROWER, NOTICEABLY_NARROWER, WallCheck
from ..field import CapsuleChain, fractions_of
from ..geometry import Line, compacted, norm
from ..validation import Floats, Points, Triangles, as_place

PLACES = 5
"""Number of places checked along every side of a triangle, its corners among them."""

FINE_PLACES = 13
"""Number of places where a triangle crosses the plane at an end of the stent, or may be too
deep."""

CLEARLY = NOTICEABLY_NARROWER
"""Share of the radius up to which wall may lie inside without being looked at."""

ROUNDING = 1e-9


def wall_check(
    points: Points, triangles: Triangles, chain: CapsuleChain, radius: float
) -> WallCheck:
    """The place of the wall that lies deepest inside of a stent, over its radius there.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Points and triangles of the wall, without the caps of inlets and outlets.
    chain : CapsuleChain
    radius : float
        Largest radius of the stent, mm.
    """
    nowhere = WallCheck(radius, 0.0, as_place(chain.nodes[0]))
    if not len(triangles):
        return nowhere
    corners = points[_doubtful(points, triangles, chain, radius)]
    seen = _depths(corners, PLACES, chain, radius)
    again = seen.crosses_end | (seen.share.max(axis=1, initial=0) > NARROWER / 2)
    fine = _depths(corners[again], FINE_PLACES, chain, radius)
    found = max((seen, fine), key=lambda one: one.share.max(initial=0))
    if not found.share.max(initial=0):
        return nowhere
    worst = np.unravel_index(found.share.argmax(), found.share.shape)
    wanted = float(found.wanted[worst])
    return WallCheck(wanted, wanted * float(found.share[worst]), as_place(found.places[worst]))


def _doubtful(
    points: Points, triangles: Triangles, chain: CapsuleChain, radius: float
) -> Triangles:
    """The triangles that may lie inside of the stent."""
    corners, local = compacted(points, triangles)
    # The nodes may lie this far beside the axis, so a distance from them may be off by as much.
    beside = float(chain.line.nearest(chain.followed.points).distances.max())
    distance = chain.axis_distance(corners) - beside
    widest = np.full(len(local), radius)
    if chain.shares is not None:
        at = np.stack(
            [fractions_of(corners, chain.line), fractions_of(corners, chain.followed)], axis=1
        )[local].reshape(len(local), -1)
        share = at.min(axis=1, keepdims=True) + np.ptp(at, axis=1)[:, None] * np.linspace(0, 1, 9)
        widest = radius * chain.shares.along(share).max(axis=1)
    longest = norm((corners[local] - corners[np.roll(local, 1, axis=1)]).reshape(-1, 3))
    longest = longest.reshape(-1, 3).max(axis=1)
    # Round a straight axis no place of a triangle is nearer than this; bends hardly change it.
    nearest = np.sqrt(np.maximum(distance[local].min(axis=1) ** 2 - longest**2 / 3, 0))
    return triangles[nearest < (1 - CLEARLY) * widest]


class _Depths(NamedTuple):
    """Depths inside a stent of places all over some triangles."""

    places: Points
    """(t, p, 3) places, mm."""
    wanted: Floats
    """(t, p) radius of the stent beside each, mm."""
    share: Floats
    """(t, p) depth inside of the stent as a share of that radius."""
    crosses_end: NDArray[np.bool_]
    """(t,) whether some places of a triangle lie beside the stent and others beyond an end."""


def _depths(corners: Points, along: int, chain: CapsuleChain, radius: float) -> _Depths:
    """Depths of places on triangles (t, 3, 3); there are `along` of them on every side."""
    places = np.einsum("pc,tcx->tpx", _weights(along), corners)
    shape, flat = places.shape[:2], places.reshape(-1, 3)
    axis_length, nearest = chain.followed.length, chain.followed.nearest(flat)
    # On a bent axis the place of the axis beside a place of the wall depends on the method, which
    # matters where the profile changes; a place is inside where it is by both methods.
    feet = [nearest.arc_lengths / axis_length]
    if chain.shares is not None:
        feet.append(fractions_of(flat, chain.line))
    wanted, share = np.full(len(flat), radius), np.full(len(flat), np.inf)
    for foot in feet:
        own = _radii(chain, radius, foot)
        inside = np.flatnonzero((foot > 0) & (foot < 1 - ROUNDING))
        inside = inside[nearest.distances[inside] < (1 - CLEARLY) * own[inside]]
        across = np.stack([foot[inside] * axis_length, nearest.distances[inside]], axis=1)
        deep = np.zeros(len(flat))
        deep[inside] = _way_out(across, chain, radius, axis_length) / own[inside]
        less = deep < share
        share[less], wanted[less] = deep[less], own[less]
    is_beside = ((feet[0] > 0) & (feet[0] < 1 - ROUNDING)).reshape(shape)
    near = (nearest.distances < (1 - CLEARLY) * own).reshape(shape)
    crosses = is_beside.any(axis=1) & ~is_beside.all(axis=1) & near.any(axis=1)
    return _Depths(places, wanted.reshape(shape), share.reshape(shape), crosses)


def _way_out(across: Floats, chain: CapsuleChain, radius: float, axis_length: float) -> Floats:
    """Shortest way (n,) out of a stent, mm, from places given along and across its axis (n, 2), mm.

    Where its radius changes steeply, and at an end, the shortest way is along the axis.
    """
    at, own = np.array([0.0, 1.0]), np.array([radius, radius])
    if chain.shares is not None:
        at, own = chain.shares.fractions, radius * chain.shares.shares
    rim = np.stack([at * axis_length, own], axis=1)
    outline = np.concatenate([[[0.0, 0.0]], rim, [[axis_length, 0.0]]])
    flat = ((0, 0), (0, 1))
    return Line(np.pad(outline, flat)).nearest(np.pad(across, flat)).distances


def _radii(chain: CapsuleChain, radius: float, foot: Floats) -> Floats:
    """Radius (n,) of the stent at places given as parts of its length, mm."""
    if chain.shares is None:
        return np.full(len(foot), radius)
    return radius * chain.shares.along(foot)


def _weights(along: int) -> Floats:
    """Barycentric weights (p, 3) of places spread evenly over a triangle."""
    last = along - 1
    grid = [(i, j, last - i - j) for i in range(along) for j in range(along - i)]
    return np.array(grid, dtype=np.float64) / last
