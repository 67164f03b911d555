"""A tree of blocks between one inlet and outlets that resist, and steady flow through it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices, InputError
from .blocks import Block

_STEPS = 60
"""Of Newton's method; a few are enough, for the equations are those of a convex minimum."""

_ENOUGH = 1e-10
"""Of the flow, by which the last step may change it."""


class Outlets(NamedTuple):
    """What lies beyond the outlets, which are in the order of their channels."""

    resistance: Floats
    """(k,) Pa s/m^3."""
    pressure: float
    """Beyond them, such as the wedge pressure, Pa."""


class Network(NamedTuple):
    """Blocks in the order of their channels, every one after that above it."""

    blocks: tuple[Block, ...]
    above: Indices
    """(n,) the block at whose end each begins; -1 at the inlet."""
    leads_to: Flags
    """(n, k) to which outlets each leads."""

    @property
    def outlet_blocks(self) -> Indices:
        """(k,) which blocks end at an outlet."""
        return _ends(self.above)


class State(NamedTuple):
    """Steady flow through a network, in SI units."""

    flow: Floats
    """(n,) through the blocks, m^3/s."""
    inlet: float
    """Total pressure at the inlet, Pa."""


def network_of(blocks: tuple[Block, ...], above: Indices) -> Network:
    """A network from its blocks and what each begins at."""
    ends = _ends(above)
    leads_to = np.zeros((len(above), len(ends)), dtype=bool)
    leads_to[ends, np.arange(len(ends))] = True
    for number in reversed(range(len(above))):
        if above[number] >= 0:
            leads_to[above[number]] |= leads_to[number]
    return Network(blocks, above, leads_to)


def _ends(above: Indices) -> Indices:
    return np.flatnonzero(~np.isin(np.arange(len(above)), above))


def steady(network: Network, outlets: Outlets, flow: float) -> State:
    """The state at a steady flow in m^3/s, by Newton's method for the flows to the outlets.

    The way to every outlet costs the same: `sum of (R + S |Q|) Q` along it, and its own resistance.

    Raises
    ------
    InputError
        No state is found.
    """
    ways = network.leads_to.astype(float)
    linear = np.array([block.resistance for block in network.blocks])
    square = np.array([block.stenosis for block in network.blocks])
    count = ways.shape[1]
    conductance = 1 / (outlets.resistance + ways.T @ linear)
    q = flow * conductance / conductance.sum()
    for _ in range(_STEPS):
        through = ways @ q
        lost = ways.T @ ((linear + square * np.abs(through)) * through) + outlets.resistance * q
        slope = ways.T @ ((linear + 2 * square * np.abs(through))[:, None] * ways)
        slope[np.diag_indices(count)] += outlets.resistance
        # The flows change so that the cost of all ways is one, and their sum stays.
        solved = np.linalg.solve(slope, np.column_stack([np.ones(count), -lost]))
        one, away = solved.T
        inlet = (flow - q.sum() - away.sum()) / one.sum()
        step = inlet * one + away
        q = q + step
        if np.abs(step).max() <= _ENOUGH * max(abs(flow), 1e-9):
            return State(ways @ q, float(inlet) + outlets.pressure)
    raise InputError(
        "flow: expected a network with one steady state, got none after "
        f"{_STEPS} steps; check that flow and pressures are in the units that they are said to be."
    )


def lost_to(network: Network, state_flow: Floats) -> Floats:
    """Total pressure (n,) that is lost from the inlet to the end of every block, Pa."""
    lost = np.zeros(len(network.above))
    for number, block in enumerate(network.blocks):
        q = state_flow[number]
        lost[number] = (block.resistance + block.stenosis * abs(q)) * q
        if network.above[number] >= 0:
            lost[number] += lost[network.above[number]]
    return lost
