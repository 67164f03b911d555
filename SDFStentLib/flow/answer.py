"""Pressures and flows before and after treatment, each as a value with a band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
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
    is_quasi_steady: bool
    """Whether a wave was taken as a row of steady flows."""

    @property
    def right_place(self) -> tuple[float, float, float] | None:
        """In the right main branch, mm; None where it is not known."""
        if self.sides is None or not self.sides.is_known:
            return None
        x, y, z = self.sides.places[1].tolist()
        return x, y, z


class FlowModel:
    """A vessel before treatment with outlets that fit what is known; kept while stents are tried.

    Parameters
    ----------
    channels : sequence of Channel
    known : Known
    clues : SideClues
        To the main branches; a place in the right one that is known comes first.

    Raises
    ------
    InputError
        Values that contradict each other, a split without two main branches, or an outlet without
        vessel.
    """

    def __init__(
        self, channels: Sequence[Channel], known: Known, clues: SideClues = NOTHING_KNOWN
    ) -> None:
        if known.right is not None:
            clues = clues._replace(right=np.array(known.right))
        self.channels, self.known, self._clues = tuple(channels), known, clues
        self._widths = widths_of(channels)
        self._usual = self._case(USUAL)

    @cached_property
    def _others(self) -> tuple[tuple[_Case, _Case], ...]:
        """To both sides of the usual one."""
        return tuple((self._case(low), self._case(high)) for _, (low, high) in UNCERTAIN)

    def _case(self, method: Method) -> _Case:
        return _Case(self.channels, self._widths, self.known, method, self._clues)

    def answer(
        self,
        after: Sequence[Channel] | None = None,
        lines: Sequence[tuple[str, Points]] = (),
        solve: Solve | None = None,
    ) -> FlowAnswer:
        """Pressures and flows before treatment, and after it.

        Parameters
        ----------
        after : sequence of Channel, optional
            The channels in the treated vessel.
        lines : sequence of names and (n, 3) arrays
            Parts of the vessel whose drop is wanted, mm.
        solve : callable, optional
            What solves the network over a wave; without one its flows are taken as steady ones.
        """
        known, usual = self.known, self._usual
        solve = None if known.wave is None else solve
        parts = [pieces_along(self.channels, line) for _, line in lines]
        widths = None if after is None else widths_of(after)

        def values(case: _Case) -> Floats:
            return np.array([case.moments(one, parts, None) for one in case.networks(widths)])

        networks = usual.networks(widths)
        base = np.array([usual.moments(one, parts, None) for one in networks])
        low, high = np.zeros_like(base), np.zeros_like(base)
        for pair in self._others:
            away = np.array([values(one) - base for one in pair])
            low += np.minimum(away.min(axis=0), 0.0) ** 2
            high += np.maximum(away.max(axis=0), 0.0) ** 2
        value = base
        if solve is not None:
            value = np.array([usual.moments(one, parts, solve) for one in networks])
        spread = np.stack([value, value - np.sqrt(low), value + np.sqrt(high)], axis=-1)
        flows = {"mean": known.mean} | ({} if known.most is None else {"peak": known.most})
        states = [
            {name: usual.moment(row) for name, row in zip(flows, state, strict=True)}
            for state in spread
        ]
        return FlowAnswer(
            known,
            usual.sides,
            tuple(name for name, _ in lines),
            flows,
            states[0],
            states[1] if len(states) > 1 else None,
            tuple(networks),
            usual.outlets,
            known.wave is not None and solve is None,
        )


class _Case:
    """A vessel's network and outlets by one method."""

    def __init__(
        self,
        channels: Sequence[Channel],
        widths: Sequence[Widths],
        known: Known,
        method: Method,
        clues: SideClues,
    ) -> None:
        self.channels, self.known, self.method = channels, known, method
        weights = outlet_diameters(channels, widths) ** method.power
        self.shares = shares_of(channels, weights)
        self.above = np.array([one.above for one in channels])
        blocks = blocks_of(channels, widths, self.shares, method)
        self.network = network_of(blocks, self.above)
        self.sides = sides_of(channels, self.network, weights, clues)
        if known.split_right is not None and not (self.sides and self.sides.is_known):
            raise InputError(
                "split to the right: expected a vessel of which the right branch is known, got one "
                "that tells no sides; name a place in the right branch, or leave the split out."
            )
        self.outlets = fitted_outlets(self.network, weights, self.sides, known)

    def networks(self, after: Sequence[Widths] | None) -> list[Network]:
        """Before, and with the widths after."""
        if after is None:
            return [self.network]
        blocks = blocks_of(self.channels, after, self.shares, self.method)
        return [self.network, self.network._replace(blocks=blocks)]

    def moment(self, row: Floats) -> Moment:
        """From the values of one moment with their bands (q, 3)."""
        bands = [Band(*one) for one in row.tolist()]
        drops = tuple(SpanDrop(*bands[k : k + 2]) for k in range(3, len(bands), 2))
        return Moment(
            bands[0] if self.known.has_pressures else None,
            None if self.sides is None else (bands[1], bands[2]),
            drops,
        )

    def moments(
        self, network: Network, parts: Sequence[Sequence[Piece]], solve: Solve | None
    ) -> list[Floats]:
        """By moment and quantity: inlet, both shares, and two drops for every part."""
        known = self.known
        if known.wave is None:
            flows = [known.mean] if known.peak is None else [known.mean, known.peak]
            states = [steady(network, self.outlets, PER_ML * q) for q in flows]
            return [self._at(network, parts, state) for state in states]
        if solve is None:
            sampled = PER_ML * np.append(known.wave.sampled(SAMPLES), known.wave.peak)
            states = [steady(network, self.outlets, float(q)) for q in sampled]
        else:
            inlets, through = solve(network, self.outlets, known)
            states = [State(*one) for one in zip(through, inlets.tolist(), strict=True)]
        every = np.array([self._at(network, parts, one) for one in states])
        mean = every[:SAMPLES] if solve is None else every
        # Of the flow to a side counts how much goes there in a cycle.
        into = np.array([one.flow[0] for one in states])[: len(mean)]
        averaged = mean.mean(axis=0)
        averaged[1:3] = (mean[:, 1:3] * into[:, None]).sum(axis=0) / into.sum()
        return [averaged, every[int(np.argmax([one.flow[0] for one in states]))]]

    def _at(self, network: Network, parts: Sequence[Sequence[Piece]], state: State) -> Floats:
        found = [state.inlet / PASCAL_PER_MMHG, np.nan, np.nan]
        if self.sides is not None:
            through = float(state.flow[0])
            found[1:] = [
                float(state.flow[k]) / through if through else np.nan for k in self.sides.blocks
            ]
        for pieces in parts:
            drop = drop_over(pieces, network, state.flow, self.method)
            found += [drop.recovered / PASCAL_PER_MMHG, drop.maximal / PASCAL_PER_MMHG]
        return np.array(found)
