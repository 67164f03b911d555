"""Focal widenings of a vessel: no healthy vessel to measure a narrowing against."""

from __future__ import annotations

import numpy as np

from ..validation import Flags, Floats, Indices

ANEURYSM = 1.5
"""Times the diameter beside it from which a focal widening is an aneurysm and no healthy vessel
(suggested standards for reporting on arterial aneurysms, J Vasc Surg 1991,
doi:10.1067/mva.1991.26737: a focal dilation by at least half of the normal diameter)."""

FOOT = 0.05
"""A widening ends where its slope stops falling: where the vessel is wider again by so much."""


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
