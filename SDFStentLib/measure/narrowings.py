"""Narrowings of one vessel: its diameter against a reference that tapers with it.

The reference of a place is the straight line between the widest places on both sides of it, each no
farther away than `REFERENCE_REACH` of its own diameters. A vessel that only tapers, however
unevenly, is nowhere narrower than both: it has no narrowing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .vessel_runs import VesselEnd, VesselRun

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.int64]

SMALLEST_DEGREE = 0.15
"""Of the reference diameter; less is the unevenness of healthy vessels and of segmentations."""

SMALLEST_RECOVERY = 0.10
"""A narrowing is at least so much narrower than the narrower one of its two references: beyond it
the vessel is wider again. Where it is not, the vessel tapers or divides."""

EDGE_DEGREE = 0.10
"""A narrowing reaches as far as the lumen is narrower than the reference by more than this."""

REFERENCE_REACH = 4.0
"""Diameters, counted from the narrowest place. Measured on 100 random vessels with 120 lesions
(`benchmarks/lesions.py`): from 3 to 8 all are found, none is invented, and degrees are right within
1.8 percentage points; 2 does not reach beyond long lesions, whose degrees come out up to 60 points
too low."""

ANEURYSM = 1.5
"""Times the diameter beside it from which a focal widening is an aneurysm and no healthy vessel
(suggested standards for reporting on arterial aneurysms, J Vasc Surg 1991,
doi:10.1067/mva.1991.26737: a focal dilation by at least half of the normal diameter)."""

HEALTHY_AGAIN = 0.95
"""Share of the other side's diameter from which vessel between a lesion and a junction is healthy;
less is the lesion's own slope."""

FOOT = 0.05
"""A widening ends where its slope stops falling: where the vessel is wider again by so much."""


class _Side(NamedTuple):
    """The widest healthy place on one side of every station: where it is, and how wide."""

    along: Floats
    diameter: Floats


class Reference(NamedTuple):
    """The healthy vessel of a place, mm along the run and diameter, mm.

    A side that has no place of its own has NaN as position, and the diameter expected there.
    """

    before: float
    before_diameter: float
    after: float
    after_diameter: float


class Narrowing(NamedTuple):
    """Part of a vessel run, mm along it."""

    start: float
    end: float
    narrowest: float
    reference: Reference


def narrowings(run: VesselRun) -> list[Narrowing]:
    """The narrowings of a vessel from one end to the other."""
    known = np.flatnonzero(np.isfinite(run.diameter))
    if len(known) < 3:
        return []
    along, diameter = run.along[known], run.diameter[known]
    steady, is_apart = run.steady[known], run.is_apart[known]
    before, after = _sides(
        along, steady, is_apart & ~_in_aneurysm(along, steady, is_apart), run.ends
    )
    reference = _on_line(along, before, after)
    with np.errstate(invalid="ignore", divide="ignore"):
        degree = 1 - diameter / reference
        recovery = 1 - diameter / np.minimum(before.diameter, after.diameter)
    counts = (degree >= SMALLEST_DEGREE) & (recovery >= SMALLEST_RECOVERY)
    found = []
    for first, last in _parts(along, degree > EDGE_DEGREE, reference):
        inside = first + np.flatnonzero(counts[first : last + 1])
        if len(inside):
            at = int(inside[np.argmax(degree[inside])])
            sides = (before.along, before.diameter, after.along, after.diameter)
            edges = (_edge(along, degree, first, first - 1), _edge(along, degree, last, last + 1))
            healthy = Reference(*(float(values[at]) for values in sides))
            found.append(Narrowing(*edges, float(along[at]), healthy))
    return found


def _sides(
    along: Floats, steady: Floats, healthy: Bools, ends: tuple[VesselEnd, VesselEnd]
) -> tuple[_Side, _Side]:
    """References on both sides; at a junction without one of its own, what stands for it."""
    before = _widest(along, steady, healthy)
    turned = _widest(-along[::-1], steady[::-1], healthy[::-1])
    after = _Side(-turned.along[::-1], turned.diameter[::-1])
    own = before, after
    is_branch = [end.is_junction and not end.is_trunk for end in ends]
    # Of a branch that ends as one on both sides one side tells what is healthy, or none.
    steep = _is_steep(along, steady, healthy), _is_steep(-along[::-1], steady[::-1], healthy[::-1])
    tells = steep[1] and not steep[0], steep[0] and not steep[1]
    if ends[0].is_trunk:
        before = _at_trunk_end(along - along[0], own[0], own[1], ends[0].expected)
    elif is_branch[0] and (not is_branch[1] or tells[1]):
        before = _at_ostium(along - along[0], own[0], own[1])
    if ends[1].is_trunk:
        after = _at_trunk_end(along[-1] - along, own[1], own[0], ends[1].expected)
    elif is_branch[1] and (not is_branch[0] or tells[0]):
        after = _at_ostium(along[-1] - along, own[1], own[0])
    return before, after


def _is_steep(along: Floats, steady: Floats, healthy: Bools) -> bool:
    """Whether the vessel still widens toward the junction where it is apart from it: a slope."""
    apart = np.flatnonzero(healthy)
    if not len(apart):
        return False
    own = steady[apart[0]]
    nearer = np.interp(along[apart[0]] - own / 4, along, steady)
    return bool(nearer > (1 + FOOT) * own)


def _widest(along: Floats, steady: Floats, healthy: Bools) -> _Side:
    """The widest healthy place up to each station, of those that are within their own reach."""
    distance = along[:, None] - along[None]
    can_be = healthy & (distance >= 0) & (distance <= REFERENCE_REACH * steady)
    best = np.where(can_be, steady, -np.inf).argmax(axis=1)
    found = can_be.any(axis=1)
    return _Side(np.where(found, along[best], np.nan), np.where(found, steady[best], np.nan))


def _at_ostium(distance: Floats, own: _Side, other: _Side) -> _Side:
    """The side of a junction where a branch begins: as wide as on its other side, if not wider."""
    is_lost = distance <= REFERENCE_REACH * other.diameter
    is_lost &= ~(own.diameter >= HEALTHY_AGAIN * other.diameter)
    return _replaced(own, is_lost, other.diameter)


def _at_trunk_end(distance: Floats, own: _Side, other: _Side, expected: float) -> _Side:
    """The side of a junction where a trunk ends: as wide as its branches ask for, if not wider."""
    wanted = np.minimum(expected, other.diameter)
    is_lost = distance <= REFERENCE_REACH * wanted
    is_lost &= ~(own.diameter >= HEALTHY_AGAIN * wanted)
    return _replaced(own, is_lost, wanted)


def _replaced(own: _Side, is_lost: Bools, diameter: Floats) -> _Side:
    return _Side(np.where(is_lost, np.nan, own.along), np.where(is_lost, diameter, own.diameter))


def _on_line(along: Floats, before: _Side, after: _Side) -> Floats:
    span = after.along - before.along
    share = np.divide(along - before.along, span, out=np.zeros(np.shape(span)), where=span > 0)
    line = before.diameter + share * (after.diameter - before.diameter)
    return np.where(np.isnan(before.along), after.diameter, line)


def _in_aneurysm(along: Floats, steady: Floats, is_apart: Bools) -> Bools:
    """Stations in focal widenings: much wider than the vessel on both sides, and not most of it."""
    found = np.zeros(len(along), dtype=bool)
    # Ends: every round finds more stations, the widest at least, or returns.
    while True:
        rest = np.flatnonzero(is_apart & ~found)
        if len(rest) < 3:
            return found
        is_wide = steady[rest] > steady[rest].max() / ANEURYSM
        weight = np.gradient(along[rest])
        is_focal = not (is_wide[0] or is_wide[-1]) and weight[is_wide].sum() < weight.sum() / 2
        if not is_focal:
            return found
        for first, last in _runs(is_wide):
            before, after = _foot(steady, rest[first], -1), _foot(steady, rest[last], 1)
            found[min(before + 1, rest[first]) : max(after, rest[last] + 1)] = True


def _foot(steady: Floats, start: int, step: int) -> int:
    """The lowest station down the slope of a widening."""
    lowest, at = start, start
    # Ends: with the stations.
    while 0 <= at + step < len(steady):
        at += step
        if steady[at] < steady[lowest]:
            lowest = at
        elif steady[at] > (1 + FOOT) * steady[lowest]:
            break
    return lowest


def _runs(chosen: Bools) -> Indices:
    """First and last index of every run of chosen ones."""
    edges = np.flatnonzero(np.diff(np.r_[0, chosen.astype(np.int8), 0]))
    return np.stack([edges[::2], edges[1::2] - 1], axis=1)


def _parts(along: Floats, is_narrow: Bools, reference: Floats) -> list[tuple[int, int]]:
    """Runs of narrow stations; those less than a radius of healthy vessel apart are one."""
    parts: list[tuple[int, int]] = []
    for first, last in _runs(is_narrow).tolist():
        if parts and along[first] - along[parts[-1][1]] < reference[first] / 2:
            parts[-1] = (parts[-1][0], last)
        else:
            parts.append((first, last))
    return parts


def _edge(along: Floats, degree: Floats, inner: int, outer: int) -> float:
    """Where the degree falls to that of an edge between two neighbors."""
    if not 0 <= outer < len(along) or not degree[outer] <= EDGE_DEGREE:
        return float(along[inner])
    share = (degree[inner] - EDGE_DEGREE) / (degree[inner] - degree[outer])
    return float(along[inner] + share * (along[outer] - along[inner]))
