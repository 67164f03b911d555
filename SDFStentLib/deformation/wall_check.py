"""Whether the wall lies inside of a stent whose radius changes along its axis.

A sphere in a steep place touches the stent where that is narrower beside it, and does not see wall
that lies inside of the wide part. So the wall itself is looked at: its distance from the axis
against the radius of the stent at its foot.
"""

from __future__ import annotations

import numpy as np

from ..certificate import NARROWER, WallCheck
from ..field import CapsuleChain, fractions_of
from ..geometry import norm
from ..validation import Floats, Points, Triangles

PLACES = 5
"""Looked at along every side of a triangle, its corners among them."""

CLEARLY = 0.01
"""Triangles that for certain lie less than this share of the radius inside are not looked at."""


def wall_check(
    points: Points, triangles: Triangles, chain: CapsuleChain, radius: float
) -> WallCheck:
    """The place of the wall that lies deepest inside of a stent, over its radius there.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Of the wall, without the caps of in- and outlets.
    chain : CapsuleChain
        With shares of its radius.
    radius : float
        The largest of the stent, mm.
    """
    assert chain.shares is not None
    used, local = np.unique(triangles, return_inverse=True)
    corners, local = points[used], local.reshape(-1, 3)
    at, distance = fractions_of(corners, chain.nodes), chain.axis_distance(corners)
    weights = _weights()
    share = chain.shares.along(at[local] @ weights.T)
    longest = norm((corners[local] - corners[np.roll(local, 1, axis=1)]).reshape(-1, 3))
    longest = longest.reshape(-1, 3).max(axis=1)
    # Round a straight axis no place of a triangle is nearer than this; bends hardly change it.
    nearest = np.sqrt(np.maximum(distance[local].min(axis=1) ** 2 - longest**2 / 3, 0))
    doubtful = np.flatnonzero(nearest < (1 - CLEARLY) * radius * share.max(axis=1))
    places = np.einsum("pc,tcx->tpx", weights, corners[local[doubtful]]).reshape(-1, 3)
    return _deepest(places, chain, radius)


def _deepest(places: Points, chain: CapsuleChain, radius: float) -> WallCheck:
    assert chain.shares is not None
    at = fractions_of(places, chain.nodes)
    # Beyond the ends there is no stent, but for what it pushes out of its way; an end may be
    # missed along the axis by as much as the wall across it.
    first, last = NARROWER * radius * chain.shares.shares[[0, -1]] / chain.length
    beside = (at > first) & (at < 1 - last)
    places, at = places[beside], at[beside]
    wanted, distance = radius * chain.shares.along(at), chain.axis_distance(places)
    if not len(places):
        return WallCheck(radius, radius, _place(chain.nodes[0]))
    worst = int((distance / wanted).argmin())
    found = min(float(distance[worst]), float(wanted[worst]))
    return WallCheck(float(wanted[worst]), found, _place(places[worst]))


def _weights() -> Floats:
    """Barycentric weights (p, 3) of places spread evenly over a triangle."""
    last = PLACES - 1
    grid = [(i, j, last - i - j) for i in range(PLACES) for j in range(PLACES - i)]
    return np.array(grid, dtype=np.float64) / last


def _place(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
