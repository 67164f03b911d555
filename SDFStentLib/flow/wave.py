"""Flow over a cycle: its rows, the even steps that meet them, and how long it flows how fast."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..validation import Floats, InputError

CLOSED = 0.05
"""Share of a wave's range by which its last flow may differ from its first."""

LEAST_ROWS = 4
"""The fewest rows of a wave."""

STEPS, USUAL, MOST = 100, 1000, 2000
"""Steps of a cycle: the fewest, how many where the rows of a wave are on no even steps, and the
most."""

ON_STEP = 1e-3
"""The part of a step by which a row may lie beside it: times are written with six digits or so."""

WITHIN = 0.01
"""Share of the range within which rows that fall on one step have to agree."""

RATES = 30.0, 250.0
"""Cycles in a minute: the least of a heart in bradycardia, and more than any newborn's."""

NODES = 8
"""Flows that stand for all forward, and as many for all backward."""


@dataclass(frozen=True)
class Wave:
    """Flow over one cycle; the last time is the first of the next one.

    Rows that lie beside the steps of a solver, of which there are `steps`, are moved to them.
    """

    time: tuple[float, ...]
    """s, from 0."""
    flow: tuple[float, ...]
    """mL/s; the last one is the first."""

    def __post_init__(self) -> None:
        time, flow = np.array(self.time, dtype=float), np.array(self.flow, dtype=float)
        _check(time, flow)
        flow[-1] = flow[0]
        time -= time[0]
        if _steps(time) is None:
            time, flow = _moved(time, flow)
        object.__setattr__(self, "time", tuple(time.tolist()))
        object.__setattr__(self, "flow", tuple(flow.tolist()))
        if self.mean <= 0:
            raise InputError(
                f"wave: expected one whose mean flow is positive, got {self.mean:g}; flow into "
                "the vessel is positive."
            )

    @cached_property
    def steps(self) -> int:
        """Even ones of a cycle, on which all rows lie."""
        found = _steps(np.array(self.time))
        assert found is not None
        return found

    @property
    def mean(self) -> float:
        """The mean flow, mL/s."""
        return _mean(np.array(self.time), np.array(self.flow))

    @property
    def peak(self) -> float:
        """The largest flow, mL/s."""
        return max(self.flow)

    @property
    def cycle(self) -> float:
        """s."""
        return self.time[-1]

    @property
    def rate(self) -> float:
        """Cycles in a minute."""
        return 60 / self.time[-1]

    @cached_property
    def back(self) -> float:
        """The regurgitant fraction: what flows back over what flows forward."""
        flow, weights = self.spread()
        return float(weights @ np.maximum(-flow, 0) / (weights @ np.maximum(flow, 0)))

    def scaled(self, mean: float) -> Wave:
        """Wave of the same shape with another mean flow, mL/s."""
        factor = mean / self.mean
        return Wave(self.time, tuple(factor * one for one in self.flow))

    def spread(self) -> tuple[Floats, Floats]:
        """Flows (k,), mL/s, with shares of time (k,), for means over the cycle.

        Means of what is a polynomial of the flow forward and another one backward, as losses
        nearly are, up to degree `2 NODES - 1`: Gauss' quadrature for the time that blood flows as
        fast as that.
        """
        return _spread(np.array(self.time), np.array(self.flow))


def _check(time: Floats, flow: Floats) -> None:
    if len(time) != len(flow) or len(time) < LEAST_ROWS:
        raise InputError(
            f"wave: expected as many times as flows, at least {LEAST_ROWS}, got {len(time)} "
            f"and {len(flow)}; correct them."
        )
    if not np.isfinite([time, flow]).all() or (np.diff(time) <= 0).any():
        raise InputError("wave: expected times that go up, got others; sort the rows.")
    if not closes(flow):
        raise InputError(
            f"wave: expected one that closes, got {flow[0]:g} at its begin and {flow[-1]:g} "
            "at its end; end it with the flow with which it begins."
        )


def on_common_steps(waves: Sequence[Wave]) -> tuple[list[Wave], Floats]:
    """Waves of one cycle whose rows lie on the same even steps, and the times of all rows, s.

    Where no steps meet the rows of all, these are moved as those of one wave are.

    Raises
    ------
    InputError
        Waves that last longer than others, by more than a row may lie beside its step.
    """
    cycle = waves[0].cycle
    for one in waves:
        if not math.isclose(one.cycle, cycle, rel_tol=ON_STEP / STEPS):
            raise InputError(
                f"inlets: expected waves of one length, got {cycle:.6g} and {one.cycle:.6g} s; "
                "stretch the times of one to the length of the other, for a heart has one rate."
            )
    rows = [(np.array(one.time) * (cycle / one.cycle), np.array(one.flow)) for one in waves]
    steps = _steps(np.concatenate([time for time, _ in rows]))
    if steps is None:
        rows, steps = [_moved(*both) for both in rows], USUAL
    every = np.concatenate([time for time, _ in rows])
    found = [Wave(tuple(time.tolist()), tuple(flow.tolist())) for time, flow in rows]
    return found, np.unique(np.rint(every / cycle * steps)) * cycle / steps


def closes(flow: Floats) -> bool:
    """Whether the last flow of a wave (n,) may repeat the first."""
    return bool(abs(flow[-1] - flow[0]) <= CLOSED * np.ptp(flow))


def _mean(time: Floats, flow: Floats) -> float:
    return float((flow[1:] + flow[:-1]) @ np.diff(time) / (2 * time[-1]))


def _steps(time: Floats) -> int | None:
    """Least number of even steps, from `STEPS` to `MOST`, of which one is at every time (n,) from
    0.

    The last one is that of the cycle.
    """
    for first in range(STEPS, MOST + 1, STEPS):
        counts = np.arange(first, min(first + STEPS, MOST + 1))
        at = np.outer(counts, time / time[-1])
        fits = (np.abs(at - np.rint(at)) <= ON_STEP).all(axis=1)
        if fits.any():
            return int(counts[np.argmax(fits)])
    return None


def _moved(time: Floats, flow: Floats) -> tuple[Floats, Floats]:
    """Times and flows of a wave whose rows go to the nearest of `USUAL` steps; its mean stays."""
    step = np.rint(time / time[-1] * USUAL).astype(np.int64)
    step, group = np.unique(step[:-1] % USUAL, return_inverse=True)
    merged = np.bincount(group, flow[:-1]) / np.bincount(group)
    away = float(np.abs(merged[group] - flow[:-1]).max())
    if away > WITHIN * np.ptp(flow):
        raise InputError(
            "wave: expected one that changes more slowly, got one that jumps by "
            f"{2 * away:.3g} mL/s within a {USUAL:,}th of its cycle; leave rows out there."
        )
    at, flows = np.append(step * time[-1] / USUAL, time[-1]), np.append(merged, merged[0])
    return at, flows + _mean(time, flow) - _mean(at, flows)


def _spread(time: Floats, flow: Floats) -> tuple[Floats, Floats]:
    first, last, share = flow[:-1], flow[1:], np.diff(time) / time[-1]
    # What begins on one side of zero and ends on the other is cut there.
    cut = np.flatnonzero(first * last < 0)
    part = first[cut] / (first[cut] - last[cut])
    zero = np.zeros(len(cut))
    first = np.concatenate([first, zero])
    ends = np.concatenate([last, last[cut]])
    ends[cut] = 0.0
    share = np.concatenate([share, share[cut] * (1 - part)])
    share[cut] *= part
    at, weights = np.polynomial.legendre.leggauss(NODES)
    values = (first + ends)[:, None] / 2 + (ends - first)[:, None] / 2 * at
    each = share[:, None] * weights / 2
    found = [_gauss(values[way], each[way]) for way in (values > 0, values < 0) if each[way].any()]
    still = float(each[values == 0].sum())
    found += [(np.zeros(1), np.array([still]))] if still else []
    flows, shares = (np.concatenate(column) for column in zip(*found, strict=True))
    return flows, shares


def _gauss(values: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """`NODES` values and weights with the same sums of powers (Golub and Welsch, Math Comput 1969;
    23:221; the recurrence by Lanczos)."""
    basis, diagonal, beside = [np.sqrt(weights / weights.sum())], list[float](), list[float]()
    for _ in range(NODES):
        following = values * basis[-1]
        diagonal.append(float(following @ basis[-1]))
        for _ in range(2):
            every = np.array(basis)
            following = following - every.T @ (every @ following)
        size = float(np.linalg.norm(following))
        if size <= 1e-10 * np.abs(values).max():
            break
        beside.append(size)
        basis.append(following / size)
    off = np.diag(beside[: len(diagonal) - 1], 1)
    nodes, vectors = np.linalg.eigh(np.diag(diagonal) + off + off.T)
    return nodes, weights.sum() * vectors[0] ** 2
