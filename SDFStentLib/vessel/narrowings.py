"""Narrowings of one vessel: its diameter against the healthy vessel beside them.

Healthy is a plateau: a stretch at least as long as the vessel is wide, as wide as the narrowest
place in it. That leaves out what bulges, as a lumen does where a branch leaves it, and what slopes,
as it does at an ostium. The reference goes from a plateau proximal of a narrowing to one distal of
it, in steps where branches leave (`Reference`). A vessel that only tapers, however unevenly, is
nowhere narrower than both: it has no narrowing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats
from .plateaus import (
    PLATEAU,
    REFERENCE_REACH,
    Plateau,
    Plateaus,
    Reference,
    known_stations,
    medians,
    parts_of,
    plateaus_of,
    tapered,
    tapers,
)
from .runs import MURRAY_EXPONENT, VesselRun

SMALLEST_DEGREE = 0.15
"""Of the reference diameter; less is the unevenness of healthy vessels and of segmentations."""

SMALLEST_ONE_SIDED = 0.35
"""The same where healthy vessel lies on one side only, as at an ostium: branches of real trees
begin narrower than they go on. Of one with 70 ends, which nobody narrowed, nearly all that widen
within `ONE_SIDED_REACH` do by less, the narrowest by 41 %."""

SMALLEST_FOCAL = 0.30
"""The same where the vessel is healthy within `FOCAL`: in 96 trees hardly a vessel that nobody
narrowed begins so; within half as much again 30 do."""

FOCAL = 0.8
"""Diameters within which a focal narrowing at an ostium ends."""

SMALLEST_RECOVERY = 1 / 8
"""A narrowing is at least so much narrower than the narrower one of its two references: beyond it
the vessel is wider again. Where it is not, the vessel tapers or divides."""

SHORT = 0.5
"""Diameters over which healthy vessel that is too short for a plateau keeps its width;"""

DIVIDED = 2 ** (1 / MURRAY_EXPONENT)
"""Times the healthy vessel on the other side of a narrowing up to which it is healthy: a vessel
that divides into two alike is so much wider. What is wider still is the flare of an ostium."""

TAKES_PLACE = 1.2
"""It counts in place of a plateau from so many times the width of that on."""

SHORT_RECOVERY = 0.25
"""a narrowing beside it is at least so much narrower than that, and than its reference."""

EDGE_DEGREE = 0.10
"""A narrowing reaches as far as the lumen is narrower than the reference by more than this."""

ONE_SIDED_REACH = 2.0
"""Diameters within which a narrowing with healthy vessel on one side only ends: what widens more
slowly than that tapers."""

FLARE = 1.25
"""Times the reference from which the vessel at its end is the ostium's flare, no healthy vessel."""

HEALTHY_AGAIN = 0.78
"""Share of the other side's diameter from which a plateau between a lesion and the vessel's end at
a junction is healthy; less is a throat of the lesion."""

CLIMB = 1 / 3
"""A plateau may be the foot of a narrowing: of those that begin within so much of its width beyond
it, the widest counts in its place,"""

GAIN = 0.02
"""if it is so much wider, and so on: up a slope, not across a vessel that keeps its caliber. A bell
four diameters across is measured to a point against what lies beyond it (`benchmarks.idealized`);
with 0.03 one of 40 % lost four."""

REGAINED = 0.5
"""Share of what a narrowing lost that its vessel has regained where a plateau is healthy although
a farther one is wider: healthy vessels widen, too. A valley between two throats has less."""


class Narrowing(NamedTuple):
    """Part of a vessel, arc lengths from the root, mm."""

    start: float
    end: float
    narrowest: float
    reference: Reference


class _Sides(NamedTuple):
    """For every station the plateau on one side: its middle, NaN without one, and its width."""

    along: Floats
    diameter: Floats
    narrowest: Floats
    """Its diameter where it is narrowest, mm,"""
    taper: Floats
    """and by which share of its width the vessel is narrower beyond it, per mm."""


def may_be_narrowed(run: VesselRun, eased: float) -> bool:
    """Whether some place of a vessel is in a narrowing, or nearly: by so much of its reference."""
    along, diameter = known_stations(run)
    if len(along) < 3:
        return False
    before, after = _sides(run, along, diameter, plateaus_of(run))
    return bool(_degrees(along, diameter, before, after, eased)[1].any())


def narrowings(run: VesselRun) -> list[Narrowing]:
    """The narrowings of a vessel from its start to its end."""
    along, diameter = known_stations(run)
    if len(along) < 3:
        return []
    before, after = _sides(run, along, diameter, plateaus_of(run))
    degree, counts = _degrees(along, diameter, before, after)
    parts = parts_of(along, degree > EDGE_DEGREE, diameter / (1 - degree))
    found: list[Narrowing] = []
    # Ends: each round drops a part, or at least the throat of one. What lies in the narrowing
    # round a deeper throat is measured against the reference of that.
    while counts.any():
        throats = [
            first + int(np.where(counts, diameter, np.inf)[first : last + 1].argmin())
            for first, last in parts
            if counts[first : last + 1].any()
        ]
        at = max(throats, key=lambda throat: float(degree[throat]))
        one = _extent(along, diameter, at, _reference(run, at, before, after))
        if one and all(one.end <= other.start or other.end <= one.start for other in found):
            found.append(one)
            counts &= (along < one.start) | (along > one.end)
        else:
            first, last = next(part for part in parts if part[0] <= at <= part[1])
            counts[first : last + 1] = False
    return sorted(found, key=lambda one: one.start)


def _sides(
    run: VesselRun, along: Floats, diameter: Floats, plateaus: Plateaus
) -> tuple[_Sides, _Sides]:
    """The plateaus on both sides of every station; what stands for one at a junction."""
    # Where nothing proximal is as wide, no healthy branch is wider than the vessel it leaves.
    most = np.maximum(run.origin, np.maximum.accumulate(diameter))
    before = _nearest(along, diameter, plateaus, 1, most)
    after = _nearest(along, diameter, plateaus, -1, most)
    short = plateaus_of(run, SHORT)
    # One that an in- or outlet cuts off is shorter still.
    is_whole = (short.start > along[0]) & (short.end < along[-1])
    short = Plateaus(*(column[is_whole] for column in short))
    before = _or_short(before, after, _nearest(along, diameter, short, 1, most))
    after = _or_short(after, before, _nearest(along, diameter, short, -1, most))
    own = before, after
    if run.parent >= 0:
        wanted = np.minimum(_widest_seen(diameter, own[1].diameter), most)
        before = _where_lost(own[0], own[1], wanted, (along, diameter))
    calibers = np.array([one.caliber for one in run.division])
    # A branch of which nothing is known leaves open what the others ask for.
    if len(calibers) and calibers.all():
        expected = float(np.sum(calibers**MURRAY_EXPONENT) ** (1 / MURRAY_EXPONENT))
        # Branches of a vessel that stays wide to its end are narrower than the rule says.
        beyond = medians(diameter, along[None, :] > along[:, None])
        beyond[-1] = diameter[-1]
        wanted = np.fmin(np.fmax(expected, beyond), own[0].diameter)
        after = _where_lost(own[1], own[0], wanted, (along, diameter))
    return before, after


def _nearest(along: Floats, diameter: Floats, plateaus: Plateaus, way: int, most: Floats) -> _Sides:
    """On one side of every station the nearest plateau that is nearly as wide as any in reach.

    What is wider than the `most` (n,) asks for no more than that.

    One in which a station lies is on both of its sides.
    """
    if not len(plateaus.start):
        unknown = np.full(len(along), np.nan)
        return _Sides(unknown, unknown, unknown, unknown)
    near, far = (plateaus.end, plateaus.start) if way > 0 else (plateaus.start, plateaus.end)
    width, at = plateaus.narrowest[None, :], along[:, None]
    distance = np.maximum(way * (at - near), 0.0)
    can_be = (way * (at - far) >= 0) & (distance <= REFERENCE_REACH * width)
    widest = np.minimum(np.where(can_be, width, -np.inf).max(axis=1), most)
    enough = np.minimum(diameter + REGAINED * (widest - diameter), widest)
    is_wide = can_be & (width >= enough[:, None])
    nearest = np.where(is_wide, distance, np.inf).min(axis=1)
    found = np.isfinite(nearest)
    chosen = np.where(is_wide & (distance == nearest[:, None]), width, -np.inf).argmax(axis=1)
    rows, is_wider = np.arange(len(along)), found
    # Ends: each round finds a wider one, or returns.
    while is_wider.any():
        own, step = distance[rows, chosen], CLIMB * plateaus.narrowest[chosen]
        # Where the slope is just too steep for a plateau, the next one still overlaps this one.
        following = np.where(can_be & (distance > own[:, None]), distance, np.inf).min(axis=1)
        following[following >= own + (plateaus.end - plateaus.start)[chosen]] = 0.0
        beyond = np.maximum(own + step, following)
        wider = np.where(can_be & (distance <= beyond[:, None]), width, -np.inf).argmax(axis=1)
        gain = plateaus.narrowest[wider] / plateaus.narrowest[chosen] - 1
        is_wider = found & (gain > GAIN * (beyond - own) / step)
        chosen = np.where(is_wider, wider, chosen)
    columns = (
        (plateaus.start + plateaus.end) / 2,
        plateaus.usual,
        plateaus.narrowest,
        tapers(plateaus, way),
    )
    return _Sides(*(np.where(found, column[chosen], np.nan) for column in columns))


def _or_short(own: _Sides, other: _Sides, short: _Sides) -> _Sides:
    """One side with what is healthy there for less than a plateau, where no plateau is as wide."""
    lacks = np.isnan(own.along) | (short.narrowest > TAKES_PLACE * own.diameter)
    ratio = short.diameter / other.diameter
    is_healthy = lacks & (ratio >= 1) & (ratio <= DIVIDED)
    return _Sides(*np.where(is_healthy, short, own))


def _widest_seen(diameter: Floats, distal: Floats) -> Floats:
    """How wide (n,) a vessel may be toward its ostium, against what is healthy distal of it, mm.

    It tapers from there where it is seen to widen up to it, and goes on into its parent's lumen
    before it is as wide.
    """
    seen = np.maximum.accumulate(diameter)
    # By degrees: how far a vessel is seen into its ostium hangs on little.
    widens = (1 - diameter / seen) / SMALLEST_DEGREE
    flare = 1 + (FLARE - 1) * np.clip(widens - 1, 0.0, 1.0)
    is_lost = (diameter[0] >= (1 - EDGE_DEGREE) * seen) & (seen < (1 - EDGE_DEGREE) * distal)
    return np.asarray(np.where(is_lost, flare, 1.0) * distal)


def _where_lost(
    own: _Sides, other: _Sides, wanted: Floats, stations: tuple[Floats, Floats]
) -> _Sides:
    """The side of an end at a junction: as wide as wanted, where no place there is healthy.

    Stations (n,) are arc lengths and diameters. A short throat may look like a plateau itself.
    """
    along, diameter = stations
    healthy = np.fmin(wanted, other.diameter)
    half_way = diameter + REGAINED * (healthy - diameter)
    is_beside = np.abs(along - own.along) > PLATEAU * own.diameter / 2
    is_healthy = is_beside & (own.diameter >= HEALTHY_AGAIN * healthy) | (own.narrowest >= half_way)
    is_lost = ~is_healthy & np.isfinite(wanted)
    return own._replace(
        along=np.where(is_lost, np.nan, own.along),
        diameter=np.where(is_lost, wanted, own.diameter),
    )


def _degrees(
    along: Floats, diameter: Floats, before: _Sides, after: _Sides, eased: float = 0.0
) -> tuple[Floats, Flags]:
    """How much narrower (n,) than the line from plateau to plateau, and where that counts."""
    span = after.along - before.along
    share = np.divide(along - before.along, span, out=np.zeros(len(along)), where=span > 0)
    line = before.diameter + share * (after.diameter - before.diameter)
    wider = tapered(along, after.along, after.diameter, after.taper, before.diameter)
    line = np.where(np.isnan(before.along), wider, line)
    narrower = np.fmin(before.diameter, after.diameter)
    line = np.where(np.isnan(after.along), narrower, line)
    line = np.where(np.isfinite(line), line, diameter)
    degree = 1 - diameter / line
    # Healthy vessel may be there, but shorter than a plateau: as wide as it should be, not wider.
    ends = np.maximum.accumulate(diameter), np.maximum.accumulate(diameter[::-1])[::-1]
    has_short = [(widest >= (1 - EDGE_DEGREE) * line) & (widest <= FLARE * line) for widest in ends]
    is_one_sided = np.isnan(before.along) & ~has_short[0] | np.isnan(after.along) & ~has_short[1]
    # Where the line widens toward an ostium, healthy vessel is no wider than the plateau beyond.
    is_healthy = diameter >= (1 - EDGE_DEGREE) * np.fmin(line, after.diameter)[:, None]
    away = np.where(is_healthy, np.abs(along[:, None] - along), np.inf).min(axis=1)
    one_sided = np.where(away <= FOCAL * line, SMALLEST_FOCAL, SMALLEST_ONE_SIDED)
    enough = np.where(is_one_sided, one_sided, SMALLEST_DEGREE)
    is_told = ~is_one_sided | (away <= ONE_SIDED_REACH * line)
    regained = _regained(along, diameter, line, (before, after))
    recovers = (1 - diameter / narrower >= SMALLEST_RECOVERY - eased) | regained
    return degree, is_told & (degree >= enough - eased) & recovers


def _regained(along: Floats, diameter: Floats, line: Floats, sides: tuple[_Sides, _Sides]) -> Flags:
    """Where (n,) a vessel is healthy on both sides, if for less than a plateau.

    Beyond that it may be narrower than it is here, as where another narrowing follows.
    """
    near = np.abs(along[:, None] - along) <= SHORT * diameter[:, None] / 2
    kept = np.where(near, diameter, np.inf).min(axis=1)
    before, after = sides
    is_before = (along < along[:, None]) & (along > before.along[:, None])
    is_after = (along > along[:, None]) & (along < after.along[:, None])
    widest = [
        np.fmax(np.where(between, kept, 0.0).max(axis=1), side.diameter)
        for between, side in ((is_before, before), (is_after, after))
    ]
    return np.asarray(diameter <= (1 - SHORT_RECOVERY) * np.fmin(np.fmin(*widest), line))


def _reference(run: VesselRun, at: int, before: _Sides, after: _Sides) -> Reference:
    """What the narrowest station is measured against."""
    sides = [
        Plateau(float(side.along[at]), float(side.diameter[at]))
        if np.isfinite(side.diameter[at])
        else None
        for side in (before, after)
    ]
    if run.parent >= 0 and sides[0] is not None and np.isnan(sides[0].arc_length):
        # At an ostium the other side stands for this one, and is told alone.
        sides[0] = None
    taper, widest = float(after.taper[at]), float(before.diameter[at])
    return Reference(sides[0], sides[1], run.side_branches, taper, widest)


def _extent(along: Floats, diameter: Floats, at: int, reference: Reference) -> Narrowing | None:
    """From where the vessel leaves its reference to where it is back, whatever leaves between."""
    healthy = reference.at(along)
    degree = 1 - diameter / healthy
    parts = parts_of(along, degree > EDGE_DEGREE, healthy)
    for first, last in parts:
        if first <= at <= last:
            at = first + int(np.argmin(diameter[first : last + 1]))
            if degree[at] < SMALLEST_DEGREE:
                return None
            start = _edge(along, degree, first, first - 1, is_throat=first == at)
            end = _edge(along, degree, last, last + 1, is_throat=last == at)
            return Narrowing(start, end, float(along[at]), reference)
    return None


def _edge(along: Floats, degree: Floats, inner: int, outer: int, *, is_throat: bool) -> float:
    """Where the degree falls to that of an edge between two neighbors.

    Beside the narrowest station no line does: between the two it may be narrower still.
    """
    if not 0 <= outer < len(along) or not degree[outer] <= EDGE_DEGREE:
        return float(along[inner])
    if is_throat:
        return float(along[outer])
    share = (degree[inner] - EDGE_DEGREE) / (degree[inner] - degree[outer])
    return float(along[inner] + share * (along[outer] - along[inner]))
