"""The caliber of a vessel as a function of the place along it, and how wide it is for some length.

A width counts where it is kept over a share of a diameter: a morphological opening of the function.
So the bulge of a lumen where a branch leaves it belongs to no vessel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices
from .runs import VesselRun

KEPT = 0.7
"""Diameters over which a width is kept that counts: the bulge and the funnel of a junction are
shorter. With half as much a quarter more is told in trees that nobody narrowed, with twice as much
healthy vessel between two junctions is none."""

ANEURYSM = 1.5
"""Times the diameter beside it from which a focal widening is an aneurysm
(suggested standards for reporting on arterial aneurysms, J Vasc Surg 1991,
doi:10.1067/mva.1991.26737: a focal dilation by at least half of the normal diameter)."""

_CLOSE = 0.1
"""Of a vessel's median diameter by which the places are apart at which its caliber is looked at:
stations may lie a third of one apart."""


class Caliber(NamedTuple):
    """How wide a vessel is at n close places, its known stations among them. All mm."""

    along: Floats
    """(n,) arc lengths from the root,"""
    diameter: Floats
    """(n,) inscribed diameters,"""
    kept: Floats
    """(n,) the widths that are kept about a place; 0 where none is, as beside a junction."""
    is_cut: tuple[bool, bool]
    """Whether it goes on beyond where it begins and ends: an inlet or outlet cuts it off, or its
    parent goes on in it."""


def caliber_of(run: VesselRun) -> Caliber:
    """The caliber along a vessel, which has a station where it is known."""
    along, diameter = _close_places(run)
    is_cut = run.parent < 0 or run.is_onward, not run.division
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


def healthy_caliber(run: VesselRun) -> float:
    """The width of a vessel where it is widest for some length, mm, by which it is called.

    At least its median, which is all that is known of a short one; 0 without a station.
    """
    caliber = caliber_of(run)
    if not len(caliber.along):
        return 0.0
    return float(max(np.median(caliber.diameter), caliber.kept.max()))


def runs_of(chosen: Flags) -> Indices:
    """First and last index of every run of chosen ones."""
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
