"""Healthy vessel: stretches about as long as a vessel is wide that neither slope nor bulge."""

from __future__ import annotations

import numpy as np

from ..validation import Flags, Floats, Indices
from .runs import VesselRun

REFERENCE_REACH = 4.0
"""Diameters of a plateau over which it may stand for the healthy vessel."""

PLATEAU = 1.0
"""Diameters over which healthy vessel is that wide."""

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


def healthy_caliber(run: VesselRun) -> float:
    """How wide a vessel is where it is widest and healthy, mm: what it is called by.

    At least its median, which is all that is known of one that only slopes; 0 without a station.
    """
    along, diameter = known_stations(run)
    if not len(along):
        return 0.0
    plateaus = plateaus_of(run)
    typical = diameter[typical_stations(along, diameter, plateaus)]
    return float(max([np.median(diameter), *typical[np.isfinite(plateaus)]]))


def known_stations(run: VesselRun) -> tuple[Floats, Floats]:
    """Arc lengths (n,) and diameters (n,) of the stations at which there is one."""
    known = np.isfinite(run.diameter)
    return run.along[known], run.diameter[known]


def plateaus_of(run: VesselRun) -> Floats:
    """`_opening` of a vessel's known stations (n,), NaN in aneurysms, too."""
    along, diameter = known_stations(run)
    found = _opening(along, diameter, run.parent >= 0, bool(run.division))
    found[in_aneurysm(along, found, REFERENCE_REACH)] = np.nan
    return found


def _opening(along: Floats, diameter: Floats, has_ostium: bool, divides: bool) -> Floats:
    """The widest of the plateaus (n,) in which every station lies, by their narrowest places.

    A plateau is no shorter than `PLATEAU`, or than the vessel, but at an in- or outlet, where the
    vessel goes on beyond the model; NaN where there is none.
    """
    half = PLATEAU * np.minimum(diameter, np.ptp(along)) / 2
    distance = np.abs(along[:, None] - along[None, :])
    is_within = distance <= half[:, None]
    narrowest = np.where(is_within, diameter[None, :], np.inf).min(axis=1)
    is_flat = narrowest >= FLAT * medians(diameter, is_within)
    # One that would reach beyond the end of the vessel is shorter than it should be.
    rounding = 1e-9 * max(1.0, float(np.ptp(along)))
    fits = is_flat
    if has_ostium:
        fits &= along - half >= along[0] - rounding
    if divides:
        fits &= along + half <= along[-1] + rounding
    widest = np.where(is_within & fits[:, None], narrowest[:, None], -np.inf).max(axis=0)
    return np.where(np.isfinite(widest), widest, np.nan)


def typical_stations(along: Floats, diameter: Floats, plateaus: Floats) -> Indices:
    """By station the place (n,) in the plateau round it, half of it on both sides, that is about
    as wide as the median there."""
    near = np.abs(along[:, None] - along[None, :]) <= PLATEAU * plateaus[:, None] / 2
    near &= diameter[None, :] >= plateaus[:, None]
    middle = medians(diameter, near)
    # On a slope what lies beside is none of the plateau.
    wanted = np.fmin(middle, plateaus / NEARLY_WIDEST)
    off = np.where(near, np.abs(diameter[None, :] - wanted[:, None]), np.inf)
    return np.asarray(off.argmin(axis=1))


def medians(diameter: Floats, chosen: Flags) -> Floats:
    """By row (k, n) the lower median of the chosen diameters; infinite where none is."""
    values = np.sort(np.where(chosen, diameter[None, :], np.inf), axis=1)
    return np.asarray(values[np.arange(len(chosen)), np.maximum(chosen.sum(axis=1) - 1, 0) // 2])


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
