"""States of a network at all its flows, and quantities from them, with bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Floats
from .blocks import PASCAL_PER_MMHG, Blood, Method
from .known import Known
from .network import Network, Outlets, SteadyFlow, lost_along
from .outlets import Sides
from .spans import BlockPart, drops_over

USUAL = Method()

UNCERTAIN = (
    ("loss of a jet", (USUAL._replace(loss=0.8), USUAL._replace(loss=1.52))),
    ("flow that divides", (USUAL._replace(divided=0.4), USUAL._replace(divided=1.2))),
    # One pair, for both are turns, and every pair takes time.
    (
        "turns into branches and in sharp bends",
        (USUAL._replace(turned=0.0), USUAL._replace(turned=1.0, bent=1.0)),
    ),
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
"""Uncertain parts of the method, and their ends to both sides; sources in docs/flow.md."""


class Band(NamedTuple):
    """Value and its limits, by uncertainties that are independent of each other."""

    value: float
    low: float
    high: float


class SpanDrop(NamedTuple):
    """Pressure drops over a part of the vessel."""

    recovered: Band
    """The drop of the total pressure, mmHg."""
    maximal: Band
    """The drop of the static pressure to its lowest place, mmHg."""


class InletLoss(NamedTuple):
    """Losses of one inlet's blood on its way to the outlets."""

    drop: Band
    """The drop of the total pressure, to its mean over the outlets, mmHg."""
    power: Band
    """Power lost, W."""


class Moment(NamedTuple):
    """A state of the vessel at the mean flow, or at its peak."""

    inlet: Band | None
    """Total pressure at the first inlet, mmHg; None where no pressures are known."""
    sides: tuple[Band, ...] | None
    """Shares of the flow to the main branches, and to others where there are some."""
    drops: tuple[SpanDrop, ...]
    """Drops, in the order of the parts that were asked for."""
    inlets: tuple[InletLoss, ...] = ()
    """Losses of several inlets, in their order;"""
    power: Band | None = None
    """and power lost by all together, W."""
    limbs: tuple[Band, ...] = ()
    """Shares of the flow through limbs that meet again."""


class PossibleFlow(NamedTuple):
    """A vessel's network and outlets by one method, before treatment."""

    network: Network
    outlets: Outlets


class SeenFlow:
    """The networks of some cases at some flows into them; their states follow case by case."""

    def __init__(
        self,
        sides: Sides | None,
        limbs: Sequence[int],
        inlets: int,
        networks: Sequence[Network],
        states: Sequence[SteadyFlow],
    ) -> None:
        self.usual = networks[0]
        self._shape = len(networks), len(states) // len(networks)
        self._networks = [one for one in networks for _ in range(self._shape[1])]
        self._flows = np.array([one.flow for one in states])
        self._drops: dict[tuple[BlockPart, ...], Floats] = {}
        tree = self.usual.tree
        into = (tree.signs_of_inlets * self._flows[:, tree.inlets]).sum(axis=1)
        # No shares yet: those of a moment at which blood stands still are none.
        aside = np.zeros((len(states), 3)) if sides is None else sides.flows(tree, self._flows)
        pressure = np.array([one.inlet for one in states]) / PASCAL_PER_MMHG
        self._head = np.column_stack([pressure, aside, self._flows[:, limbs]])
        self._into = into.reshape(self._shape)
        self._losses = np.empty((len(states), 0))
        if inlets > 1:
            self._losses = losses_of(self._networks, self._flows, inlets)
            self._losses[:, :inlets] /= PASCAL_PER_MMHG

    def _drop(self, pieces: tuple[BlockPart, ...]) -> Floats:
        """The drop over a part, of all states (c * t, 2), mmHg."""
        known = self._drops.get(pieces)
        if known is None:
            known = drops_over(pieces, self._networks, self._flows) / PASCAL_PER_MMHG
        return known

    def moments(
        self, known: Known, parts: Sequence[tuple[BlockPart, ...]], weights: Floats | None = None
    ) -> Floats:
        """Values by case, moment and quantity: inlet, shares of sides and limbs, drops, losses.

        Of a wave the first states, with weights (t,), make up the mean; without weights the states
        are those of even times of a cycle.
        """
        # Those of this answer are kept: lesions are asked for again, a stent elsewhere is not.
        self._drops = {pieces: self._drop(pieces) for pieces in parts}
        each = [self._head, *map(self._drop, parts), self._losses]
        every = np.hstack(each).reshape(*self._shape, -1)
        into = self._into
        if known.wave is not None:
            count = self._shape[1]
            weights = np.full(count, 1 / count) if weights is None else weights
            peak, cycle = int(np.argmax(into[0])), slice(len(weights))
            into = np.stack([into[:, cycle] @ weights, into[:, peak]], axis=1)
            averaged = np.einsum("ctq,t->cq", every[:, cycle], weights)
            every = np.stack([averaged, every[:, peak]], axis=1)
        # Of the flow to a side counts how much goes there in a cycle; the mean flow is positive.
        every[..., 1 : self._head.shape[1]] /= into[..., None]
        return every


def losses_of(networks: Sequence[Network], flows: Floats, count: int) -> Floats:
    """Losses from the first `count` inlets to the outlets: drops, Pa, powers, W, the whole power.

    Parameters
    ----------
    networks : sequence of c Network
        Networks of one tree.
    flows : (c, n) array
        Flows through their blocks, m^3/s.
    count : int

    Returns
    -------
    (c, 2 count + 1) array
        A drop is of the total pressure, to its mean over the outlets, weighted by their flows. So
        powers, flow times drop, add up to the whole one: what comes in with the flows less what
        leaves with them.
    """
    tree = networks[0].tree
    resistance, stenosis = (
        np.array([getattr(one, name) for one in networks]) for name in ("resistance", "stenosis")
    )
    lost = lost_along(tree, (resistance + stenosis * np.abs(flows)) * flows)
    coming = (tree.signs_of_inlets * flows[:, tree.inlets])[:, :count]
    leaving = tree.signs[tree.outlets] * flows[:, tree.outlets]
    at_inlets = -lost[:, tree.inlets[:count]]
    at_inlets[:, 0] = 0.0  # from there all is lost
    at_outlets = -lost[:, tree.outlets]
    weights = np.abs(leaving)
    whole = weights.sum(axis=1, keepdims=True)
    weights = np.divide(weights, whole, out=np.zeros_like(weights), where=whole > 0)
    drops = at_inlets - (weights * at_outlets).sum(axis=1, keepdims=True)
    power = (coming * at_inlets).sum(axis=1) - (leaving * at_outlets).sum(axis=1)
    return np.column_stack([drops, coming * drops, power])


def reach_of(told: Floats) -> tuple[Floats, Floats]:
    """Distances of values below and above those of the first case, by the pairs of cases after it.

    Uncertainties are independent of each other: their squares add up.
    """
    away = (told[1:] - told[0]).reshape(-1, 2, *told[0].shape)
    low = (np.minimum(away.min(axis=1), 0.0) ** 2).sum(axis=0)
    high = (np.maximum(away.max(axis=1), 0.0) ** 2).sum(axis=0)
    return np.sqrt(low), np.sqrt(high)
