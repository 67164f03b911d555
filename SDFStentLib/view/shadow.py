"""How a vessel looks in many views: foreshortened, and under the shadows of others.

An X-ray has no front: what lies before a vessel and what lies behind it darken it alike. A ray
through a vessel counts as covered where lumen elsewhere, on either side, lies on it over at least
the length that the vessel itself has there: then the greater part of the shadow is not its own.
Lumen is the union of the tree's inscribed spheres. What can be reached from the place on a straight
way within it is the same lumen: foreshortened, but not covered by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..geometry import Line, dot, norm, search_tree
from ..validation import Flags, Floats, Indices
from .target import Spheres, Target

STRIPS = 5
"""Rays across the width of a vessel, in the middles of as many equal strips."""

BETWEEN = (0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875)
"""Where a way between two spheres is looked at, as shares of what lies between their surfaces: it
leaves the lumen where one of these places is out of it."""

_OUTMOST = 1 - 1 / STRIPS
"""Share of the radius at which the outmost rays are."""

_PAIRS = 1 << 20
"""Pairs of a view and two spheres that are held at a time, in a processor's own memory."""


def foreshortenings(line: Line, axes: Floats) -> Floats:
    """The share of a line's length that each view (k, 3, 3) loses, 0 to 1.

    The length in the picture is that of the projected curve, not of its chord.
    """
    pieces = np.diff(line.points, axis=0)
    along = np.einsum("pi,kji->kjp", pieces, axes[:, :2])
    return np.asarray(1 - np.hypot(along[:, 0], along[:, 1]).sum(axis=1) / line.length)


class Obstacles(NamedTuple):
    """Places to be shown, the spheres that can cover them, and the p pairs of both."""

    target: Target
    others: Spheres
    station: Indices
    """(p,) of the target."""
    ball: Indices
    """(p,) of the others."""
    away: Floats
    """(p, 3) the way from one to the other, mm."""
    reach: Floats
    """(p,) how near their middles have to be in the picture."""


def obstacles(target: Target, others: Spheres) -> Obstacles:
    """Which spheres can cover which places, from wherever one looks.

    Notes
    -----
    With radii r at the place and R of the sphere, and a ray at x r, R^2 less the square of the
    distance to the ray has to be r^2 (1 - x^2) at least. The way between both has to leave the
    lumen.
    """
    own = target.radii[:, None]
    square = others.radii**2 - (1 - _OUTMOST**2) * own**2
    away = others.centers - target.centers[:, None]
    squared = np.einsum("nmi,nmi->nm", away, away)
    station, ball = np.nonzero((squared > (own + others.radii) ** 2) & (square >= 0))
    if not len(station):
        return Obstacles(target, others, station, ball, np.empty((0, 3)), np.empty(0))
    leaves = _leaves(target, others, station, ball)
    station, ball = station[leaves], ball[leaves]
    reach = _OUTMOST * target.radii[station] + np.sqrt(square[station, ball])
    return Obstacles(target, others, station, ball, away[station, ball], reach)


def _leaves(target: Target, others: Spheres, station: Indices, ball: Indices) -> Flags:
    """Whether the straight ways between pairs of spheres (p,) leave the lumen."""
    # In four dimensions the nearest point is the sphere with the least power: one search tells
    # whether a place is within any of them.
    largest = float(others.radii.max())
    lifted = np.column_stack([others.centers, np.sqrt(largest**2 - others.radii**2)])
    tree = search_tree(lifted)
    away = others.centers[ball] - target.centers[station]
    length = norm(away)
    first, last = target.radii[station] / length, 1 - others.radii[ball] / length
    leaves = np.zeros(len(station), dtype=bool)
    for share in BETWEEN:
        left = np.flatnonzero(~leaves)
        at = (1 - share) * first[left] + share * last[left]
        places = target.centers[station[left]] + at[:, None] * away[left]
        power, _ = tree.query(np.pad(places, ((0, 0), (0, 1))), distance_upper_bound=largest)
        leaves[left] = ~(power <= largest)
    return leaves


def covered_shares(known: Obstacles, axes: Floats) -> Floats:
    """The share of a target's area that lies under other lumen in each view (k, 3, 3), 0 to 1."""
    target = known.target
    covered = np.zeros((len(axes), len(target.centers), STRIPS))
    for view, station, _, strip in _hits(known, axes):
        covered[view, station, strip] = 1.0
    return np.asarray(covered.mean(axis=2) @ target.weights)


def covering_branches(known: Obstacles, axes: Floats) -> Indices:
    """The branches whose spheres cover a target in one view (3, 3), most of it first."""
    hits = [
        (known.others.branches[ball], station * STRIPS + strip)
        for _, station, ball, strip in _hits(known, axes[None])
    ]
    if not hits:
        return np.empty(0, dtype=np.int64)
    branch, place = (np.concatenate(one) for one in zip(*hits, strict=True))
    pairs = np.unique(np.stack([branch, place], axis=1), axis=0)
    numbers, counts = np.unique(pairs[:, 0], return_counts=True)
    return np.asarray(numbers[np.argsort(-counts, kind="stable")])


def _hits(known: Obstacles, axes: Floats) -> Iterator[tuple[Indices, Indices, Indices, Indices]]:
    """Views, stations, spheres and strips that belong together: the sphere covers that strip."""
    # The shadows are near enough where the way between the centers is as steep as that; in single
    # precision, a little less is asked for.
    target, radii, away = known.target, known.others.radii, known.away
    steep = np.sqrt(np.maximum(dot(away, away) - known.reach**2, 0)).astype(np.float32)
    steep *= np.float32(1 - 1e-5)
    flat = away.astype(np.float32)
    toward = np.ascontiguousarray(axes[:, 2].T.astype(np.float32))
    sides, sines = _sides(target, axes)
    size = max(1, _PAIRS // max(1, len(axes)))
    for first in range(0, len(away), size):
        deep = flat[first : first + size] @ toward
        near = np.flatnonzero(np.abs(deep, out=deep) >= steep[first : first + size, None])
        pair, view = np.divmod(near, len(axes))
        pair += first
        own, other, way = known.station[pair], known.ball[pair], away[pair]
        # Squares of half the length on the ray through the station, and of that of the vessel.
        left = radii[other] ** 2 - dot(way, way) + dot(way, axes[view, 2]) ** 2
        width, beside = target.radii[own], dot(way, sides[view, own])
        thick = width**2 / np.maximum(sines[view, own], 1e-300)
        for strip in range(STRIPS):
            share = (2 * strip + 1) / STRIPS - 1
            offset = share * width
            hit = left + offset * (2 * beside - offset) >= (1 - share**2) * thick
            yield view[hit], own[hit], other[hit], np.full(int(hit.sum()), strip)


def _sides(target: Target, axes: Floats) -> tuple[Floats, Floats]:
    """The direction across each station in each view, (k, n, 3), and the squared sine (k, n) of the
    angle between vessel and view."""
    sides = np.cross(axes[:, None, 2], target.ways)
    squares = np.einsum("kni,kni->kn", sides, sides)
    lengths = np.sqrt(squares)[..., None]
    # Seen along the vessel any side will do.
    sides = np.where(lengths > 0, sides / np.where(lengths > 0, lengths, 1.0), axes[:, None, 0])
    return sides, squares
