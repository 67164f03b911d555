"""Healthy vessel: stretches about as long as a vessel is wide that neither slope nor bulge.

And what it tells of the vessel between two of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import SAME_CALIBER, USUAL
from ..validation import Flags, Floats, Indices
from .runs import MURRAY_EXPONENT, SideBranch, VesselRun

REFERENCE_REACH = 4.0
"""Diameters of a plateau over which it may stand for the healthy vessel."""

PLATEAU = 1.0
"""Diameters over which healthy vessel is that wide."""

CLOSE = 0.1
"""Of a vessel's median diameter by which the places are apart at which plateaus are looked for:
stations may lie a third of one apart, and few in a window tell neither slope nor median."""

FLAT = 0.92
"""Share of its median diameter that a plateau is wide at its narrowest place: slopes of more than
about a sixth over a diameter are none, what an ostium or a branch widens does not matter."""

NEARLY_WIDEST = 0.93
"""Share of the widest plateau within reach from which the nearest one is the reference: farther
ones are of a vessel that tapers, or wide by chance."""

ANEURYSM = 1.5
"""Times the diameter beside it from which a focal widening is an aneurysm and no healthy vessel
(suggested standards for reporting on arterial aneurysms, J Vasc Surg 1991,
doi:10.1067/mva.1991.26737: a focal dilation by at least half of the normal diameter)."""

FOOT = 0.05
"""A widening ends where its slope stops falling: where the vessel is wider again by so much."""

IN_STEPS = 0.5
"""Share of the difference between two plateaus that may fall at branches: vessels of real trees
taper between them, too."""


class Plateau(NamedTuple):
    """Healthy vessel on one side of a narrowing."""

    arc_length: float
    """From the root, mm; NaN for one beyond a division, that its branches tell."""
    diameter: float
    """mm."""


class Reference(NamedTuple):
    """The healthy vessel along a narrowing, as quantitative angiography interpolates it.

    Between both plateaus D^(7/3) falls where branches leave by what the rule says that these take
    (`MURRAY_EXPONENT`), but by no more than `IN_STEPS` of the difference, and what is left of it
    goes evenly along the vessel. A branch as wide as the vessel beyond it makes a step by the rule.
    With one plateau the reference is as wide as that, but for a vessel that tapers from an ostium.
    """

    proximal: Plateau | None
    distal: Plateau | None
    side_branches: tuple[SideBranch, ...] = ()
    taper: float = 0.0
    """Share by which it widens per mm from the distal plateau, which is alone, to an ostium,"""
    widest: float = 0.0
    """up to this diameter, mm."""

    def at(self, along: Floats) -> Floats:
        """Healthy diameters (n,) at some arc lengths from the root, mm."""
        known = [side for side in (self.proximal, self.distal) if side is not None]
        if len(known) == 1 or any(np.isnan(side.arc_length) for side in known):
            # A plateau that has no place is no wider than the other one.
            narrower = min(known, key=lambda side: side.diameter)
            return tapered(along, *narrower, self.taper, self.widest)
        (first, before), (last, after) = known
        share = np.clip((along - first) / max(last - first, 1e-300), 0.0, 1.0)
        if before <= after:
            return np.asarray(before + share * (after - before))
        fall = before**MURRAY_EXPONENT - after**MURRAY_EXPONENT
        between = [one for one in self.side_branches if first < one.arc_length < last]
        taken = np.array([one.caliber**MURRAY_EXPONENT for one in between])
        parts = any(one.caliber >= SAME_CALIBER * after for one in between)
        taken *= min(1.0, (1.0 if parts else IN_STEPS) * fall / max(taken.sum(), 1e-300))
        places = np.array([one.arc_length for one in between])
        stepped = (along[:, None] >= places) @ taken if between else 0.0
        left = before**MURRAY_EXPONENT - stepped - share * (fall - taken.sum())
        return np.asarray(left ** (1 / MURRAY_EXPONENT))


def tapered(
    along: Floats,
    middle: Floats | float,
    diameter: Floats | float,
    taper: Floats | float,
    widest: Floats | float,
) -> Floats:
    """How wide (n,) a vessel is that widens from a plateau toward its ostium, mm; not where NaN."""
    wider = diameter * (1 + taper * np.nan_to_num(middle - along))
    return np.asarray(np.fmax(np.minimum(wider, widest), diameter))


class Plateaus(NamedTuple):
    """Stretches of healthy vessel; they overlap. All mm, from the root."""

    start: Floats
    """(n,)"""
    end: Floats
    """(n,)"""
    narrowest: Floats
    """(n,) their diameters where they are narrowest,"""
    usual: Floats
    """(n,) and their usual ones, as of a vessel (`centerline.USUAL`)."""


def healthy_caliber(run: VesselRun) -> float:
    """How wide a vessel is where it is widest and healthy, mm: what it is called by.

    At least its median, which is all that is known of one that only slopes; 0 without a station.
    """
    along, diameter = _close_places(run)
    if not len(along):
        return 0.0
    return float(max([np.median(diameter), *plateaus_of(run).usual]))


def plateaus_of(run: VesselRun, length: float = PLATEAU) -> Plateaus:
    """The plateaus of a vessel, or stretches of another length, in its diameters."""
    along, diameter = _close_places(run)
    half = length * np.minimum(diameter, np.ptp(along) if len(along) else 0.0) / 2
    first = np.searchsorted(along, along - half)
    last = np.searchsorted(along, along + half, side="right")
    near = first[:, None] + np.arange((last - first).max(initial=0))
    is_within = near < last[:, None]
    near = np.minimum(near, len(along) - 1)
    narrowest = np.where(is_within, diameter[near], np.inf).min(axis=1, initial=np.inf)
    is_healthy = narrowest >= FLAT * medians(diameter[near], is_within)
    is_healthy &= _fits(along, half, run)
    of_place = np.full(len(along), np.nan)
    chosen = is_within & is_healthy[:, None]
    np.fmax.at(of_place, near[chosen], np.broadcast_to(narrowest[:, None], near.shape)[chosen])
    whole = _undivided(along, of_place, run.side_branches)
    bulging = np.r_[0, np.cumsum(in_aneurysm(along, whole, REFERENCE_REACH))]
    is_healthy &= bulging[first] == bulging[last]
    ends = np.maximum(along - half, along[:1]), np.minimum(along + half, along[-1:])
    # A part of it may lie on a slope, and what is in it is no narrowing of itself.
    usual = np.fmin(medians(diameter[near], is_within, USUAL), narrowest / NEARLY_WIDEST)
    return Plateaus(*(column[is_healthy] for column in (*ends, narrowest, usual)))


def tapers(plateaus: Plateaus, way: int) -> Floats:
    """By which share per mm (n,) those are narrower that follow plateaus; 0 where none does."""
    middle, width = (plateaus.start + plateaus.end) / 2, plateaus.usual
    following = np.abs(middle - (middle - way * PLATEAU * width)[:, None]).argmin(axis=1)
    apart = np.abs(middle[following] - middle)
    falls = np.maximum(1 - width[following] / width, 0.0)
    is_next = apart >= PLATEAU * width / 2
    return np.asarray(np.divide(falls, apart, out=np.zeros(len(width)), where=is_next))


def known_stations(run: VesselRun) -> tuple[Floats, Floats]:
    """Arc lengths (n,) and diameters (n,) of the stations at which there is one."""
    known = np.isfinite(run.diameter)
    return run.along[known], run.diameter[known]


def _close_places(run: VesselRun) -> tuple[Floats, Floats]:
    """Arc lengths and diameters of the known stations, and of places on the lines between them."""
    along, diameter = known_stations(run)
    if len(along) < 2:
        return along, diameter
    parts = np.ceil(np.diff(along) / (CLOSE * np.median(diameter)))
    # Nothing is known between stations that others lie between.
    parts[np.diff(np.flatnonzero(np.isfinite(run.diameter))) > 1] = 1.0
    steps = [number + np.arange(count) / count for number, count in enumerate(parts.tolist())]
    at, stations = np.concatenate([*steps, [len(along) - 1.0]]), np.arange(len(along))
    return np.interp(at, stations, along), np.interp(at, stations, diameter)


def _fits(along: Floats, half: Floats, run: VesselRun) -> Flags:
    """Round which places (n,) so much of the vessel lies on both sides.

    At an in- or outlet it goes on beyond the model, and elsewhere a plateau that would reach beyond
    the end of the vessel is shorter than it should be.
    """
    rounding = 1e-9 * max(1.0, float(np.ptp(along)) if len(along) else 0.0)
    begins = run.parent < 0 or along - half >= along[:1] - rounding
    ends = not run.division or along + half <= along[-1:] + rounding
    return np.asarray(np.full(len(along), True) & begins & ends)


def _undivided(along: Floats, diameter: Floats, leaving: Sequence[SideBranch]) -> Floats:
    """How wide (n,) a vessel would be with all that has left it: no branch ends a widening."""
    taken = np.array([one.caliber**MURRAY_EXPONENT for one in leaving])
    has_left = along[:, None] >= [one.arc_length for one in leaving]
    return np.asarray((diameter**MURRAY_EXPONENT + has_left @ taken) ** (1 / MURRAY_EXPONENT))


def medians(diameter: Floats, chosen: Flags, share: float = 0.5) -> Floats:
    """By row (k, n) the lower median, or another quantile, of the chosen diameters.

    They are (n,) or (k, n); infinite where none is chosen.
    """
    values = np.sort(np.where(chosen, diameter, np.inf), axis=1)
    last = np.maximum(chosen.sum(axis=1) - 1, 0)
    return np.asarray(values[np.arange(len(chosen)), (share * last).astype(np.int64)])


def in_aneurysm(along: Floats, plateaus: Floats, reach: float) -> Flags:
    """Stations in focal widenings: much wider than the vessel on both sides, and not most of it.

    Parameters
    ----------
    along : (n,) array
        Arc lengths of the stations, mm.
    plateaus : (n,) array
        Their plateaus, mm; NaN without one.
    reach : float
        Diameters within which a widening ends on both sides.
    """
    found = np.zeros(len(along), dtype=bool)
    # Ends: every round finds more stations, the widest at least, or returns.
    while True:
        rest = np.flatnonzero(np.isfinite(plateaus) & ~found)
        if len(rest) < 3:
            return found
        is_wide = plateaus[rest] > plateaus[rest].max() / ANEURYSM
        weight = np.gradient(along[rest])
        is_focal = not (is_wide[0] or is_wide[-1]) and weight[is_wide].sum() < weight.sum() / 2
        focal = [
            (first, last)
            for first, last in runs_of(is_wide).tolist()
            if is_focal and _falls_on_both_sides(along[rest], plateaus[rest], reach, (first, last))
        ]
        if not focal:
            return found
        for first, last in focal:
            before, after = _foot(plateaus, rest[first], -1), _foot(plateaus, rest[last], 1)
            found[min(before + 1, rest[first]) : max(after, rest[last] + 1)] = True


def _falls_on_both_sides(
    along: Floats, plateaus: Floats, reach: float, ends: tuple[int, int]
) -> bool:
    """Whether a widening ends within reach of its widest place on both sides, as no taper does."""
    first, last = ends
    widest = first + int(np.argmax(plateaus[first : last + 1]))
    near = np.abs(along - along[widest]) <= reach * plateaus[widest]
    is_narrow = near & (plateaus <= plateaus[widest] / ANEURYSM)
    return bool(is_narrow[:first].any() and is_narrow[last + 1 :].any())


def _foot(widths: Floats, start: int, step: int) -> int:
    """The lowest station down the slope of a widening."""
    lowest, at = start, start
    # Ends: with the stations.
    while 0 <= at + step < len(widths):
        at += step
        if widths[at] < widths[lowest]:
            lowest = at
        elif widths[at] > (1 + FOOT) * widths[lowest]:
            break
    return lowest


def runs_of(chosen: Flags) -> Indices:
    """First and last index of every run of chosen ones."""
    edges = np.flatnonzero(np.diff(np.r_[0, chosen.astype(np.int8), 0]))
    return np.stack([edges[::2], edges[1::2] - 1], axis=1)


def parts_of(along: Floats, is_narrow: Flags, reference: Floats) -> list[tuple[int, int]]:
    """Runs of narrow stations; those less than a radius of healthy vessel apart are one."""
    parts: list[tuple[int, int]] = []
    for first, last in runs_of(is_narrow).tolist():
        if parts and along[first] - along[parts[-1][1]] < reference[first] / 2:
            parts[-1] = (parts[-1][0], last)
        else:
            parts.append((first, last))
    return parts
