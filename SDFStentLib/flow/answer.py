"""Pressures and flows before and after treatment, each as a value with a band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Floats, InputError, Points
from .blocks import Method, blocks_of, outlet_diameters, shares_of
from .blood import PASCAL_PER_MMHG, PER_ML, Blood
from .channels import Channel, Widths, widths_of
from .known import Known
from .network import Network, Outlets, State, network_of, steady
from .outlets import NOTHING_KNOWN, SAMPLES, SideClues, Sides, fitted_outlets, sides_of
from .spans import Piece, drop_over, pieces_along

USUAL = Method()

UNCERTAIN = (
    ("loss of a jet", (USUAL._replace(loss=0.8), USUAL._replace(loss=1.52))),
    (
        "viscosity",
        (
            USUAL._replace(blood=Blood(viscosity=0.003)),
            USUAL._replace(blood=Blood(viscosity=0.005)),
        ),
    ),
    ("power of the outlets", (USUAL._replace(power=2.0), USUAL._replace(power=3.0))),
    ("diameters", (USUAL._replace(wider=-0.1), USUAL._replace(wider=0.1))),
)
"""What is uncertain, and how far to both sides; sources in docs/flow.md."""

Solve = Callable[[Network, Outlets, Known], "tuple[Floats, Floats]"]
"""Inlet pressures (t,), Pa, and flows (t, n), m^3/s, through the blocks over a cycle."""


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


class Moment(NamedTuple):
    """A state of the vessel at the mean flow, or at its peak."""

    inlet: Band | None
    """Total pressure at the inlet, mmHg; None where no pressures are known."""
    sides: tuple[Band, Band] | None
    """Shares of the flow to the main branches."""
    drops: tuple[SpanDrop, ...]
    """In the order of the parts that were asked for."""


class FlowAnswer(NamedTuple):
    """Of a vessel before treatment, and after it where there is one."""

    known: Known
    sides: Sides | None
    parts: tuple[str, ...]
    flows: dict[str, float]
    """mL/s by moment: `mean`, and `peak` where it is known."""
    before: dict[str, Moment]
    after: dict[str, Moment] | None
    networks: tuple[Network, ...]
    """Before, and after."""
    outlets: Outlets
    """As they fit what is known before treatment, and are kept for after."""


class Vessels(NamedTuple):
    """What the answer is about: channels before and after, and the parts that are asked for."""

    before: tuple[Channel, ...]
    after: tuple[Channel, ...] | None
    parts: tuple[tuple[str, tuple[Piece, ...]], ...]
    clues: SideClues = NOTHING_KNOWN
    """To the main branches."""


def vessels_of(
    before: tuple[Channel, ...],
    after: tuple[Channel, ...] | None,
    lines: Sequence[tuple[str, Points]],
    clues: SideClues = NOTHING_KNOWN,
) -> Vessels:
    """With the parts along some lines with names, mm."""
    parts = tuple((name, pieces_along(before, line)) for name, line in lines)
    return Vessels(before, after, parts, clues)


def flow_answer(vessels: Vessels, known: Known, solve: Solve | None = None) -> FlowAnswer:
    """Pressures and flows of a vessel, the outlets fitted before treatment and kept after it.

    Parameters
    ----------
    vessels : Vessels
    known : Known
    solve : callable, optional
        What solves the network over a wave; without one its flows are taken as steady ones.

    Raises
    ------
    InputError
        Values that contradict each other, a split without two main branches, or an outlet without
        vessel.
    """
    usual = _Case(vessels, known, USUAL)
    if known.split_right is not None and not (usual.sides and usual.sides.is_known):
        raise InputError(
            "split to the right: expected a vessel of which the right branch is known, got one "
            "that tells no sides; name a place in the right branch, or leave the split out."
        )
    base = usual.values()
    low, high = np.zeros_like(base), np.zeros_like(base)
    for _, pair in UNCERTAIN:
        away = np.array([_Case(vessels, known, one).values() - base for one in pair])
        low += np.minimum(away.min(axis=0), 0.0) ** 2
        high += np.maximum(away.max(axis=0), 0.0) ** 2
    value = base if solve is None or known.wave is None else usual.values(solve)
    spread = np.stack([value, value - np.sqrt(low), value + np.sqrt(high)], axis=-1)
    names = ("mean",) if spread.shape[1] == 1 else ("mean", "peak")
    moments = [
        {name: usual.moment(row) for name, row in zip(names, state, strict=True)}
        for state in spread
    ]
    peak = known.peak if known.wave is None else float(known.wave.flow.max())
    return FlowAnswer(
        known,
        usual.sides,
        tuple(name for name, _ in vessels.parts),
        {"mean": known.mean} | ({} if peak is None else {"peak": peak}),
        moments[0],
        moments[1] if len(moments) > 1 else None,
        tuple(usual.networks),
        usual.outlets,
    )


class _Case:
    """The networks of a vessel by one method."""

    def __init__(self, vessels: Vessels, known: Known, method: Method) -> None:
        self.vessels, self.known, self.method = vessels, known, method
        before = vessels.before
        widths = [widths_of(state) for state in (before, vessels.after) if state is not None]
        weights = outlet_diameters(before, widths[0]) ** method.power
        shares = shares_of(before, weights)
        self.networks = [self._network(size, shares) for size in widths]
        self.sides = sides_of(before, self.networks[0], weights, vessels.clues)
        is_known = self.sides is not None and self.sides.is_known
        if known.split_right is not None and not is_known:
            return
        self.outlets = fitted_outlets(self.networks[0], weights, self.sides, known)

    def _network(self, widths: Sequence[Widths], shares: Floats) -> Network:
        channels = self.vessels.before
        above = np.array([one.above for one in channels])
        return network_of(blocks_of(channels, widths, shares, self.method), above)

    def values(self, solve: Solve | None = None) -> Floats:
        """By state, moment and quantity: inlet, both shares, and two drops for every part."""
        return np.array([self._moments(network, solve) for network in self.networks])

    def moment(self, row: Floats) -> Moment:
        """From the values of one moment with their bands (q, 3)."""
        bands = [Band(*one) for one in row.tolist()]
        drops = tuple(SpanDrop(*bands[k : k + 2]) for k in range(3, len(bands), 2))
        return Moment(
            bands[0] if self.known.has_pressures else None,
            None if self.sides is None else (bands[1], bands[2]),
            drops,
        )

    def _moments(self, network: Network, solve: Solve | None) -> list[Floats]:
        known = self.known
        if known.wave is None:
            flows = [known.mean] if known.peak is None else [known.mean, known.peak]
            return [self._at(network, steady(network, self.outlets, PER_ML * q)) for q in flows]
        if solve is None:
            sampled = PER_ML * np.append(known.wave.sampled(SAMPLES), known.wave.flow.max())
            states = [steady(network, self.outlets, float(q)) for q in sampled]
        else:
            inlets, through = solve(network, self.outlets, known)
            states = [State(*one) for one in zip(through, inlets.tolist(), strict=True)]
        every = np.array([self._at(network, one) for one in states])
        mean = every[:SAMPLES] if solve is None else every
        # Of the flow to a side counts how much goes there in a cycle.
        into = np.array([one.flow[0] for one in states])[: len(mean)]
        averaged = mean.mean(axis=0)
        averaged[1:3] = (mean[:, 1:3] * into[:, None]).sum(axis=0) / into.sum()
        return [averaged, every[int(np.argmax([one.flow[0] for one in states]))]]

    def _at(self, network: Network, state: State) -> Floats:
        found = [state.inlet / PASCAL_PER_MMHG, np.nan, np.nan]
        if self.sides is not None:
            through = float(state.flow[0])
            found[1:] = [
                float(state.flow[k]) / through if through else np.nan for k in self.sides.blocks
            ]
        for _, pieces in self.vessels.parts:
            drop = drop_over(pieces, network, state.flow, self.method)
            found += [drop.recovered / PASCAL_PER_MMHG, drop.maximal / PASCAL_PER_MMHG]
        return np.array(found)
