"""Vessels in many views: foreshortened, and under the shadows of others.

An X-ray has no front: what lies before a vessel and what lies behind it darken it alike. A ray
through a vessel counts as covered where it meets at least twice as much lumen as the vessel itself
has there, aslant as it is seen: then the greater part of the shadow is not its own. Lumen is the
union of the tree's inscribed spheres; the longest piece on a ray within one of them counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..geometry import Line, dot
from ..validation import Floats, Indices
from .target import Spheres, Target

STRIPS = 5
"""Rays across the width of a vessel, in the middles of as many equal strips."""

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
    """(p,) indices of the places of the target."""
    ball: Indices
    """(p,) indices of the others."""
    away: Floats
    """(p, 3) the way from one to the other, mm."""
    times: Floats
    """(p,) square of how many times the length of the vessel itself the sphere needs on a ray: once
    beside it, twice where it touches the place, and has the vessel's own length in it."""
    reach: Floats
    """(p,) distance that their middles have at most in the picture, mm."""


def obstacles(target: Target, others: Spheres) -> Obstacles:
    """Spheres that can cover places, from wherever one looks.

    Notes
    -----
    With radii r at the place and R of the sphere, and a ray at x r, R^2 less the square of the
    distance to the ray has to be `times` r^2 (1 - x^2) at least.
    """
    own = target.radii[:, None]
    away = others.centers - target.centers[:, None]
    squared = np.einsum("nmi,nmi->nm", away, away)
    times = np.where(squared > (own + others.radii) ** 2, 1.0, 4.0)
    square = others.radii**2 - times * (1 - _OUTMOST**2) * own**2
    station, ball = np.nonzero(square >= 0)
    pairs = station, ball
    reach = _OUTMOST * target.radii[station] + np.sqrt(square[pairs])
    return Obstacles(target, others, station, ball, away[pairs], times[pairs], reach)


def covered_shares(known: Obstacles, axes: Floats) -> Floats:
    """The share of a target's area that lies under other lumen in each view (k, 3, 3), 0 to 1."""
    target = known.target
    covered = np.zeros((len(axes), len(target.centers), STRIPS))
    for view, station, _, strip in _hits(known, axes):
        covered[view, station, strip] = 1.0
    return np.asarray(covered.mean(axis=2) @ target.weights)


def covering_branches(known: Obstacles, axes: Floats) -> Indices:
    """Branches whose spheres cover a target in one view (3, 3), that over most of it first."""
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
        thick = known.times[pair] * width**2 / np.maximum(sines[view, own], 1e-300)
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
