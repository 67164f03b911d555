"""Bends sharper than about a diameter: how far and how tightly they turn, what may be lost there.

Sources, and how little is known of it: docs/flow.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import norm
from ..validation import Flags, Floats, Indices
from .channels import Channel, Widths

STEP = 0.05
"""Diameters between the places at which lines are looked at."""

SMOOTH = 0.2
"""Diameters: standard deviation of the weights by which directions along a line are averaged."""

SIDE = round(3 * SMOOTH / STEP)
"""Steps up to which they count to each side."""

APART, FAR = 2.0, 4.0
"""Distance in diameters of channels laid out one after the other, and largest one of stations: what
is as good as closed is long in diameters."""

GENTLE = 1.5
"""Radius over diameter from which on a bend is none of these; up to 1 all of it counts."""

_TURNS = np.radians([0.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0, 110.0, 130.0, 150.0, 180.0])
_ROUND = np.array([0.0, 0.31, 0.45, 0.60, 0.78, 0.90, 1.00, 1.13, 1.20, 1.28, 1.40])
"""Loss of a bend of such an angle over that of one of 90 degrees: Idelchik, diagram 6-1."""
_CORNER = np.array([2.5, 2.5, 2.22, 1.87, 1.50, 1.28, 1.20, 1.20, 1.20, 1.20, 1.20])
"""Factor of a corner's `0.95 s + 2.05 s^2`, s = sin^2 of half the angle: Idelchik, diagram 6-5."""
_RADII, _SLOW = np.array([0.525, 0.625, 0.70]), np.array([1.40, 1.67, 2.00])
"""Factor by radius over diameter at a Reynolds number of 10^4, the lowest of Idelchik, diagram 6-1;
corners as the first."""


class SharpBends(NamedTuple):
    """Stations (k,) of all channels one after the other that lie in such bends."""

    station: Indices
    part: Floats
    """(k,) of the energy that flows there what may be lost by it."""
    ends: Indices
    """(k,) stations behind the bends: most of it is lost there."""


NONE = SharpBends(np.empty(0, np.int64), np.empty(0), np.empty(0, np.int64))


def bend_loss(turn: Floats, radius: Floats) -> Floats:
    """Parts (n,) of the energy that flows into bends that are lost, beside friction.

    Parameters
    ----------
    turn : (n,) array
        Radians.
    radius : (n,) array
        Radius of the axis, over the diameter.
    """
    tight = 0.21 / np.maximum(np.minimum(radius**2.5, radius**0.5), 1e-3)
    rounded = np.interp(turn, _TURNS, _ROUND) * tight * np.interp(radius, _RADII, _SLOW)
    half = np.sin(np.minimum(turn, np.pi) / 2) ** 2
    corner = np.interp(turn, _TURNS, _CORNER) * (0.95 * half + 2.05 * half**2) * _SLOW[0]
    # A rounded bend costs no more than a corner.
    return np.minimum(rounded, corner)


def sharpness(radius: Floats) -> Floats:
    """Weight (n,) of a bend by its radius over the diameter: nothing jumps."""
    part = np.clip((GENTLE - radius) / (GENTLE - 1.0), 0.0, 1.0)
    return np.asarray(part**2 * (3 - 2 * part))


def sharp_bends(
    channels: Sequence[Channel],
    widths: Sequence[Widths],
    before: tuple[Sequence[Channel], Sequence[Widths], SharpBends] | None = None,
) -> SharpBends:
    """Sharp bends within channels; those between channels are in `turns_of`.

    A bend is where directions, smoothed, turn faster than on a circle of `GENTLE` diameters, and as
    far around that as smoothing spreads it. That takes nothing of the turn, and widens a bend by
    what is known: its radius is that of the arc that turns as far and, by the second moment, over
    as much of the line. So neither hangs on the stations.

    Of channels before treatment, those that are the same values after it keep their bends.
    """
    if before is None:
        return _bends_of(channels, widths)
    is_new = [
        one is not old or size is not known
        for one, size, old, known in zip(channels, widths, *before[:2], strict=True)
    ]
    moved = np.repeat(is_new, [len(one.along) for one in channels])
    new = np.flatnonzero(is_new).tolist()
    kept = ~moved[before[2].station]
    found = _bends_of([channels[k] for k in new], [widths[k] for k in new]) if new else NONE
    own = np.flatnonzero(moved)
    found = SharpBends(own[found.station], found.part, own[found.ends])
    columns = zip(before[2], found, strict=True)
    return SharpBends(*(np.concatenate([old[kept], one]) for old, one in columns))


def _bends_of(channels: Sequence[Channel], widths: Sequence[Widths]) -> SharpBends:
    points = np.concatenate([one.points for one in channels])
    at, last = _laid_out(points, channels, widths)
    places: Floats = np.arange(1, int(at[-1] / STEP) + 1) * np.float64(STEP)
    if len(places) < 3:
        return NONE
    before = np.searchsorted(at, places, side="right") - 1
    is_inner = np.ones(len(points), dtype=bool)
    is_inner[last] = False
    turn = _turning(points, at, places, is_inner[before])
    inside, before = places[1:-1], before[1:-1]
    bends = _stretches(turn * GENTLE > STEP)
    if not bends:
        return NONE
    # Averaging spreads a turn, and so do straight lines between stations, as hats.
    width = SMOOTH**2 + np.diff(at)[before] ** 2 / 6
    each = [slice(max(begin - SIDE, 0), end + SIDE) for begin, end in bends]
    parts = np.array([_part(turn[near], inside[near], width[near]) for near in each])
    which = np.repeat(np.arange(len(bends)), [end - begin for begin, end in bends])
    inner = np.concatenate([np.arange(begin, end) for begin, end in bends])
    share = turn[inner] / np.bincount(which, turn[inner])[which]
    stations, part = before[inner], parts[which] * share
    behind = np.searchsorted(at, places[[end for _, end in bends]])[which]
    behind = np.minimum(behind, last[np.searchsorted(last, stations)])
    # A place has the energy of the stations on both sides.
    onward = (inside[inner] - at[stations]) / (at[stations + 1] - at[stations])
    return SharpBends(
        np.concatenate([stations, stations + 1]),
        np.concatenate([part * (1 - onward), part * onward]),
        np.concatenate([behind, behind]),
    )


def _laid_out(
    points: Floats, channels: Sequence[Channel], widths: Sequence[Widths]
) -> tuple[Floats, Indices]:
    """Places (m,) of stations of channels one after the other, in diameters, and the last of each.

    Each begins in the middle between two places, whatever is before it.
    """
    diameter = np.sqrt(np.concatenate([one.narrow * one.wide for one in widths]))
    counts = [len(one.along) for one in channels]
    last = np.cumsum(counts) - 1
    steps = np.minimum(2 * norm(np.diff(points, axis=0)) / (diameter[1:] + diameter[:-1]), FAR)
    steps[last[:-1]] = 0.0
    along = np.concatenate([[0.0], np.cumsum(steps)])
    ends = along[last]
    cells = np.ceil((np.diff(ends, prepend=0.0) + APART) / STEP)
    shifts = (np.cumsum(cells) - cells + 0.5) * STEP - np.concatenate([[0.0], ends[:-1]])
    return along + np.repeat(shifts, counts), last


def _part(turn: Floats, place: Floats, width: Floats) -> float:
    """The part of the energy that a bend may lose, by how much it turns at places (k,)."""
    angle = turn.sum()
    middle = turn @ place / angle
    spread = turn @ ((place - middle) ** 2 - width) / angle
    radius = np.sqrt(12 * max(spread, 0.0)) / angle
    # What hardly turns faster than a gentle circle hardly counts.
    gentlest = np.maximum(radius, STEP / turn.max())
    return float(bend_loss(angle, radius) * sharpness(gentlest))


def _stretches(is_sharp: Flags) -> list[tuple[int, int]]:
    """Begins and ends of stretches; those that smoothing would run into each other are one."""
    edges = np.flatnonzero(np.diff(is_sharp, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2]
    if not len(edges):
        return []
    apart = begins[1:] - ends[:-1] > 2 * SIDE
    begins, ends = begins[np.append(True, apart)], ends[np.append(apart, True)]
    return list(zip(begins.tolist(), ends.tolist(), strict=True))


def _turning(points: Floats, at: Floats, places: Floats, is_inner: Flags) -> Floats:
    """Angles by which smoothed directions turn at places but the first and last one, radians."""
    line = np.column_stack([np.interp(places, at, column) for column in points.T])
    known = is_inner[1:] & is_inner[:-1]
    ways = np.where(known[:, None], np.diff(line, axis=0), 0.0)
    weights = np.exp(-0.5 * (np.arange(-SIDE, SIDE + 1) * STEP / SMOOTH) ** 2)
    ahead = np.column_stack(
        [np.convolve(column, weights)[SIDE : SIDE + len(ways)] for column in ways.T]
    )
    ahead /= np.maximum(norm(ahead), 1e-12)[:, None]
    return np.where(known[1:] & known[:-1], norm(np.diff(ahead, axis=0)), 0.0)
