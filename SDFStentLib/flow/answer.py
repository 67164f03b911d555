"""Pressures and flows before and after treatment, each as a value with a band."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..validation import Floats, InputError, Place, as_place
from .blocks import (
    PER_ML,
    Block,
    Blood,
    Method,
    Stream,
    blocks_of,
    outlet_diameters,
    shares_of,
    turns_of,
)
from .channels import Channel, widths_of
from .known import Known
from .network import Network, Outlets, State, steady_states, tree_of
from .outlets import (
    NOTHING_KNOWN,
    SideClues,
    Sides,
    fitted_outlets,
    outlet_shares,
    sides_of,
)
from .profiles import bends_of
from .seen import Case, Seen
from .spans import Part, Ways

USUAL = Method()

UNCERTAIN = (
    ("loss of a jet", (USUAL._replace(loss=0.8), USUAL._replace(loss=1.52))),
    ("flow that divides", (USUAL._replace(divided=0.4), USUAL._replace(divided=1.2))),
    ("turns into branches", (USUAL._replace(turned=0.0), USUAL._replace(turned=1.0))),
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

HALVINGS = 6
"""Of a range of which the known pressures allow a part."""

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
    def right_place(self) -> Place | None:
        """In the right main branch, mm; None where it is not known."""
        if self.sides is None or not self.sides.is_known:
            return None
        return as_place(self.sides.places[1])


def _reach(told: Floats) -> tuple[Floats, Floats]:
    """How far values lie below and above those of the first case, by the pairs of cases after it.

    Uncertainties are independent of each other: their squares add up.
    """
    away = (told[1:] - told[0]).reshape(-1, 2, *told[0].shape)
    low = (np.minimum(away.min(axis=1), 0.0) ** 2).sum(axis=0)
    high = (np.maximum(away.max(axis=1), 0.0) ** 2).sum(axis=0)
    return np.sqrt(low), np.sqrt(high)


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
        self.channels, self.known = tuple(channels), known
        self._widths, self._ways = widths_of(channels), Ways(channels)
        self._tree = tree_of(np.array([one.above for one in channels]))
        # Profiles, and how a jet divides where vessels do, are those of the usual shares.
        self._diameters = outlet_diameters(channels, self._widths)
        weights = self._diameters**USUAL.power
        self._sides = sides_of(channels, self._tree, weights, clues)
        if known.split_right is not None and not (self._sides and self._sides.is_known):
            raise InputError(
                "split to the right: expected a vessel of which the right branch is known, got one "
                "that tells no sides; name a place in the right branch",
                "right",
                end=", or leave the split out.",
            )
        shares = shares_of(channels, outlet_shares(weights, self._sides, known))
        self._stream = Stream(
            PER_ML * known.mean * shares,
            turns_of(channels, self._widths),
            bends_of(channels, self._widths),
        )
        self._flows, self._weights = _flows(known)
        self._blocks: dict[float, tuple[Block, ...]] = {}
        self._usual = self._case(USUAL)
        self._wave_before: Seen | None = None

    @cached_property
    def _others(self) -> list[tuple[Case, Case]]:
        """To both sides of the usual one."""
        return [(self._possible(low), self._possible(high)) for _, (low, high) in UNCERTAIN]

    def _possible(self, method: Method) -> Case:
        """The case of a method, or of the farthest on the way to it that the known pressures allow.

        Where all of a range would cost more than they leave, the patient tells that not all of it
        is true.
        """
        try:
            return self._case(method)
        except InputError:
            found, near, far = self._usual, 0.0, 1.0
        for _ in range(HALVINGS):
            part = (near + far) / 2
            try:
                found, near = self._case(USUAL.towards(method, part)), part
            except InputError:
                far = part
        return found

    def _case(self, method: Method) -> Case:
        weights, wider = self._diameters**method.power, method.wider
        if wider not in self._blocks:
            self._blocks[wider] = blocks_of(self.channels, self._widths, self._stream, wider)
        network = Network(self._blocks[wider], self._tree, method)
        outlets = fitted_outlets(network, weights, self._sides, self.known)
        return Case(network, outlets)

    @cached_property
    def _cases(self) -> list[Case]:
        """The usual one first."""
        return [self._usual, *(case for pair in self._others for case in pair)]

    @cached_property
    def _before(self) -> Seen:
        """Before treatment: the same for every stent that is tried."""
        return self._seen([case.network for case in self._cases])

    def _after(self, channels: Sequence[Channel]) -> Seen:
        """The same with the channels after treatment."""
        widths = widths_of(channels, (self.channels, self._widths))
        each = [case.network for case in self._cases]
        wider = dict.fromkeys(one.method.wider for one in each)
        blocks = {one: blocks_of(channels, widths, self._stream, one) for one in wider}
        return self._seen([one._replace(blocks=blocks[one.method.wider]) for one in each])

    def _seen(self, networks: Sequence[Network]) -> Seen:
        """Networks by case at all flows into them, which are solved at once."""
        flows = (PER_ML * self._flows).tolist()
        both = zip(self._cases, networks, strict=True)
        questions = [(one, case.outlets, q) for case, one in both for q in flows]
        return Seen(self._sides, networks, steady_states(questions))

    def answer(
        self,
        after: Sequence[Channel] | None = None,
        parts: Sequence[Part] = (),
        solve: Solve | None = None,
    ) -> FlowAnswer:
        """Pressures and flows before treatment, and after it.

        Parameters
        ----------
        after : sequence of Channel, optional
            The channels in the treated vessel.
        parts : sequence of Part
        solve : callable, optional
            What solves the network over a wave; without one its flows are taken as steady ones.
        """
        known, usual = self.known, self._usual
        solve = None if known.wave is None else solve
        ways = [self._ways.pieces_along(part.line, part.before) for part in parts]
        seen = [self._before] if after is None else [self._before, self._after(after)]
        told = np.stack([one.moments(known, ways, self._weights) for one in seen], axis=1)
        value = told[0]
        low, high = _reach(told)
        networks = tuple(one.usual for one in seen)
        if solve is not None:
            solved = [self._solved(solve, one) for one in networks]
            value = np.concatenate([one.moments(known, ways) for one in solved])
        lowest = value - low
        # No part of a vessel gives back what is lost, but over a wave in which blood runs back.
        is_bound = np.array([known.wave is None or known.wave.back == 0, True])
        floor = np.where(is_bound, 0.0, -np.inf)[: value.shape[1], None]
        lowest[..., 3:] = np.maximum(lowest[..., 3:], np.minimum(value[..., 3:], floor))
        spread = np.stack([value, lowest, value + high], axis=-1)
        names = {"mean": known.mean} | ({} if known.most is None else {"peak": known.most})
        moments = [dict(zip(names, map(self._moment, state), strict=True)) for state in spread]
        return FlowAnswer(
            known,
            self._sides,
            tuple(part.name for part in parts),
            names,
            moments[0],
            moments[1] if len(moments) > 1 else None,
            networks,
            usual.outlets,
            known.wave is not None and solve is None,
        )

    def _solved(self, solve: Solve, network: Network) -> Seen:
        """Over the wave; that before treatment is the same for every stent that is tried."""
        is_before = network is self._usual.network
        if is_before and self._wave_before is not None:
            return self._wave_before
        inlets, through = solve(network, self._usual.outlets, self.known)
        states = [State(*one) for one in zip(through, inlets.tolist(), strict=True)]
        solved = Seen(self._sides, [network], states)
        if is_before:
            self._wave_before = solved
        return solved

    def _moment(self, row: Floats) -> Moment:
        """From the values of one moment with their bands (q, 3)."""
        bands = [Band(*one) for one in row.tolist()]
        drops = tuple(SpanDrop(*bands[k : k + 2]) for k in range(3, len(bands), 2))
        return Moment(
            bands[0] if self.known.has_pressures else None,
            None if self._sides is None else (bands[1], bands[2]),
            drops,
        )


def _flows(known: Known) -> tuple[Floats, Floats | None]:
    """At which a vessel is looked at (t,), mL/s, and of those of a wave, but the last, the weights.

    They are the mean and the peak; of a wave those that stand for its cycle, and the peak.
    """
    if known.wave is not None:
        flows, weights = known.wave.spread()
        return np.append(flows, known.wave.peak), weights
    return np.array([known.mean] if known.peak is None else [known.mean, known.peak]), None
