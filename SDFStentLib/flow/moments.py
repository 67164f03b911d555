"""What a network tells of a vessel at one flow: values with bands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Floats


class Band(NamedTuple):
    """A value and between what it lies, by uncertainties that are independent of each other."""

    value: float
    low: float
    high: float


class SpanDrop(NamedTuple):
    """What a part of the vessel costs."""

    recovered: Band
    """Of the total pressure, mmHg."""
    maximal: Band
    """Of the static pressure to its lowest place, mmHg."""


class InletLoss(NamedTuple):
    """What blood of one of several inlets loses on its way to the outlets."""

    drop: Band
    """Of the total pressure, to its mean over the outlets, mmHg."""
    power: Band
    """W."""


class Moment(NamedTuple):
    """A state of the vessel at the mean flow, or at its peak."""

    inlet: Band | None
    """Total pressure at the first inlet, mmHg; None where no pressures are known."""
    sides: tuple[Band, ...] | None
    """Shares of the flow to the main branches, and to others where there are some."""
    drops: tuple[SpanDrop, ...]
    """In the order of the parts that were asked for."""
    inlets: tuple[InletLoss, ...] = ()
    """Of several, in their order;"""
    power: Band | None = None
    """and of all together, W."""
    limbs: tuple[Band, ...] = ()
    """Shares of the flow through limbs that meet again."""


def reach_of(told: Floats) -> tuple[Floats, Floats]:
    """How far values lie below and above those of the first case, by the pairs of cases after it.

    Uncertainties are independent of each other: their squares add up.
    """
    away = (told[1:] - told[0]).reshape(-1, 2, *told[0].shape)
    low = (np.minimum(away.min(axis=1), 0.0) ** 2).sum(axis=0)
    high = (np.maximum(away.max(axis=1), 0.0) ** 2).sum(axis=0)
    return np.sqrt(low), np.sqrt(high)
