"""The caliber of a vessel as a function of the place along it, and how wide it is for some length.

A width counts where it is kept over a share of a diameter: a morphological opening of the function.
So the bulge of a lumen where a branch leaves it belongs to no vessel.

Where a vessel divides it goes on in one branch, and where it is about as wide as the widest beside
it, its parent goes on in it: healthy vessel beyond a junction tells how wide it should be, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..centerline import SAME_CALIBER
from ..geometry import Line
from ..validation import Flags, Floats, Indices
from .runs import Leaving, VesselRun

KEPT = 0.7
"""Diameters over which a width is kept that counts: the bulge and the funnel of a junction are
shorter. With half as much a quarter more is told in trees that nobody narrowed, with twice as much
healthy vessel between two junctions is none."""

ANEURYSM = 1.5
"""Times the diameter beside it from which a focal widening is an aneurysm
(suggested standards for reporting on arterial aneurysms, J Vasc Surg 1991,
doi:10.1067/mva.1991.26737: a focal dilation by at least half of the normal diameter)."""

EDGE_DEGREE = 0.10
"""A narrowing reaches as far as the lumen is narrower than the reference by more than this."""

_CLOSE = 0.1
"""The part of a vessel's median diameter by which places of its caliber are apart:
stations may lie a third of one apart."""


class Caliber(NamedTuple):
    """Diameters of a vessel at n close places, its known stations among them. All mm."""

    along: Floats
    """(n,) arc lengths from the root,"""
    diameter: Floats
    """(n,) inscribed diameters,"""
    kept: Floats
    """(n,) the widths that are kept about a place; 0 where none is, as beside a junction."""
    is_cut: tuple[bool, bool]
    """Whether an inlet or outlet cuts off its start and its end: it goes on beyond."""


def caliber_of(run: VesselRun) -> Caliber:
    """The caliber along a vessel, which has a station where it is known."""
    along, diameter = _close_places(run)
    goes_on = [one.arc_length < run.along[-1] for one in run.division]
    is_cut = run.parent < 0, all(goes_on)
    half = KEPT * diameter / 2
    first = np.searchsorted(along, along - half)
    last = np.searchsorted(along, along + half, side="right")
    near = first[:, None] + np.arange((last - first).max(initial=0))
    is_within = near < last[:, None]
    near = np.minimum(near, len(along) - 1)
    narrowest = np.where(is_within, diameter[near], np.inf).min(axis=1, initial=np.inf)
    rounding = 1e-9 * max(1.0, float(np.ptp(along)) if len(along) else 0.0)
    is_whole = is_cut[0] | (along - half >= along[:1] - rounding)
    is_whole &= is_cut[1] | (along + half <= along[-1:] + rounding)
    kept = np.zeros(len(along))
    chosen = is_within & is_whole[:, None]
    np.maximum.at(kept, near[chosen], np.broadcast_to(narrowest[:, None], near.shape)[chosen])
    return Caliber(along, diameter, kept, is_cut)


class Basin(NamedTuple):
    """A minimum, and the widest places between it and the ones beside it; indices of places."""

    first: int
    lowest: int
    last: int


def basins(caliber: Caliber) -> list[Basin]:
    """The minima between which a vessel is wider than at both by more than an edge is.

    Its ends are among them: what lies beyond is not known.
    """
    diameter = caliber.diameter.tolist()
    widths = np.where(caliber.kept > 0, caliber.kept, caliber.diameter).tolist()
    found, tops, lowest, highest, rises = [], [0], 0, 0, False
    for at, width in enumerate(widths):
        if rises:
            highest = at if width > widths[highest] else highest
            if width <= (1 - EDGE_DEGREE) * widths[highest]:
                tops.append(highest)
                lowest, rises = at, False
        else:
            is_lower = (width, diameter[at]) < (widths[lowest], diameter[lowest])
            lowest = at if is_lower else lowest
            if widths[lowest] <= (1 - EDGE_DEGREE) * width:
                found.append(lowest)
                highest, rises = at, True
    found += [] if rises else [lowest]
    return [Basin(*one) for one in zip(tops, found, [*tops[1:], len(widths) - 1], strict=True)]


def healthy_caliber(run: VesselRun) -> float:
    """The width of a vessel where it is widest for some length, mm, by which it is called.

    At least its median, which is all that is known of a short one; 0 without a station.
    """
    caliber = caliber_of(run)
    if not len(caliber.along):
        return 0.0
    return float(max(np.median(caliber.diameter), caliber.kept.max()))


def runs_of(chosen: Flags) -> Indices:
    """First and last index (k, 2) of every run of chosen ones."""
    edges = np.flatnonzero(np.diff(np.r_[0, chosen.astype(np.int8), 0]))
    return np.stack([edges[::2], edges[1::2] - 1], axis=1)


def _close_places(run: VesselRun) -> tuple[Floats, Floats]:
    """Arc lengths and diameters of the known stations, and of places on the lines between them."""
    known = np.isfinite(run.diameter)
    along, diameter = run.along[known], run.diameter[known]
    if len(along) < 2:
        return along, diameter
    parts = np.ceil(np.diff(along) / (_CLOSE * np.median(diameter)))
    # Nothing is known between stations that others lie between.
    parts[np.diff(np.flatnonzero(known)) > 1] = 1.0
    steps = [number + np.arange(count) / count for number, count in enumerate(parts.tolist())]
    at, stations = np.concatenate([*steps, [len(along) - 1.0]]), np.arange(len(along))
    return np.interp(at, stations, along), np.interp(at, stations, diameter)


class VesselWay(NamedTuple):
    """A vessel with the one it comes from and the ones it goes on in."""

    run: VesselRun
    """The run with their stations, too. Its parent is that of the first of them."""
    own: tuple[float, float]
    """Arc lengths of the first and last known station of the vessel itself, from the root, mm."""
    rank: int
    """Number of vessels between it and the root that do not go on foremost in the next one."""
    parent: int
    """Index of the vessel that this one itself leaves; -1 for one that begins at a root."""
    begins: tuple[tuple[float, int], ...]
    """Arc length from the root at which each vessel of the way begins, mm, and its index."""
    leaving: tuple[Leaving, ...]
    """What leaves it on its way."""

    def vessel_at(self, along: float) -> int:
        """The vessel of the tree at an arc length from the root, mm; -1 before the first one."""
        return next((vessel for begin, vessel in reversed(self.begins) if begin <= along), -1)

    def begin_of(self, vessel: int) -> float:
        """Arc length from the root at which one of its vessels begins, mm."""
        return next(begin for begin, one in self.begins if one == vessel)

    @property
    def vessels(self) -> list[int]:
        """Indices of the vessels of the way, from the root's side on."""
        return [vessel for _, vessel in self.begins]


def vessel_ways(runs: Sequence[VesselRun]) -> list[VesselWay]:
    """The ways of all vessels of a tree."""
    onward = [_onward(runs, number) for number in range(len(runs))]
    is_foremost = [run.parent >= 0 and onward[run.parent] == n for n, run in enumerate(runs)]
    found: list[VesselWay] = []
    for number, run in enumerate(runs):
        known = run.along[np.isfinite(run.diameter)]
        if run.is_onward or is_foremost[number]:
            # Where it begins lies in its parent's lumen.
            known = known[known > run.along[0]]
        own = (float(known[0]), float(known[-1])) if len(known) else (np.inf, -np.inf)
        rank = 0 if run.parent < 0 else found[run.parent].rank + (not is_foremost[number])
        way, before, beyond = run, number, number
        begins = [(float(run.along[0]), number)]
        # Ends: at a root, or at the ostium of a side branch, at the latest.
        while runs[before].is_onward or is_foremost[before]:
            before = runs[before].parent
            begins.insert(0, (float(runs[before].along[0]), before))
            way = _joined(way, runs[before], way)._replace(parent=runs[before].parent)
        # Ends: at an outlet at the latest.
        while (beyond := onward[beyond]) >= 0:
            begins.append((float(runs[beyond].along[0]), beyond))
            way = _joined(way, way, runs[beyond])
        facts = rank, run.parent, tuple(begins), _leaving(runs, begins)
        found.append(VesselWay(way, own, *facts))
    return found


def _leaving(runs: Sequence[VesselRun], begins: Sequence[tuple[float, int]]) -> tuple[Leaving, ...]:
    """What leaves a way through vessels that begin at some arc lengths, mm."""
    ends = [*(begin for begin, _ in begins[1:]), np.inf]
    parts = zip(begins, ends, strict=True)
    found = [
        one for (_, vessel), end in parts for one in runs[vessel].leaving if one.arc_length < end
    ]
    return tuple(sorted(found))


def _onward(runs: Sequence[VesselRun], number: int) -> int:
    """Index of the vessel in which one that divides goes on: of those alike the widest at its
    start."""
    nodes = {one.arc_length for one in runs[number].division}
    known = [
        child
        for child, run in enumerate(runs)
        if run.parent == number and run.along[0] in nodes and np.isfinite(run.diameter).any()
    ]
    least = SAME_CALIBER * max((runs[child].caliber for child in known), default=0.0)
    alike = [child for child in known if runs[child].caliber >= least]
    return max(alike, key=lambda child: _begins(runs[child]), default=-1)


def _begins(run: VesselRun) -> float:
    """The first known diameter of a vessel, mm."""
    return float(run.diameter[np.isfinite(run.diameter)][0])


def _joined(facts: VesselRun, first: VesselRun, last: VesselRun) -> VesselRun:
    """Stations of a vessel up to the start of another one, then those of that one."""
    known = last.along[np.isfinite(last.diameter)]
    before, beyond = first.along <= last.along[0], last.along > last.along[0]
    # What is not known before is the lumen of the junction.
    beyond &= last.along >= known[:1].sum()

    def both(name: str) -> Any:
        return np.concatenate([getattr(first, name)[before], getattr(last, name)[beyond]])

    columns = {name: both(name) for name in ("along", "diameter", "branch", "branch_along")}
    return facts._replace(line=Line(both("points")), **columns)
