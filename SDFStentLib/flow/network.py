"""A tree of blocks between one inlet and outlets that resist, and steady flow through it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices, InputError
from .blocks import Block, Method

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


class Level(NamedTuple):
    """The blocks of a tree that are equally many junctions away from its inlet."""

    rows: Indices
    """(r,) those that begin at one junction side by side."""
    starts: Indices
    """(j,) where those of each junction begin,"""
    counts: Indices
    """how many they are,"""
    parents: Indices
    """and the block that ends there."""


class Tree(NamedTuple):
    """How blocks are joined, every one after that above it."""

    above: Indices
    """(n,) the block at whose end each begins; -1 at the inlet."""
    outlets: Indices
    """(k,) which blocks end at an outlet."""
    leads_to: Flags
    """(n, k) to which outlets each leads."""
    levels: tuple[Level, ...]
    """From the first junctions on."""


class Network(NamedTuple):
    """Blocks in the order of their channels, with what a method takes them for."""

    blocks: tuple[Block, ...]
    tree: Tree
    method: Method = Method()

    @property
    def resistance(self) -> Floats:
        """(n,) of the blocks, Pa s/m^3."""
        viscosity = self.method.blood.viscosity
        return viscosity * np.array([block.friction[-1] for block in self.blocks])

    @property
    def stenosis(self) -> Floats:
        """(n,) of the blocks, Pa s^2/m^6."""
        lost = [
            (
                one.mixing[-1] + (1 - one.taken[-1]) * one.beyond,
                one.dividing[-1] + one.taken[-1] * one.beyond,
                one.turning,
            )
            for one in self.blocks
        ]
        method = self.method
        weights = [method.loss, method.divided, method.turned]
        return method.blood.density * (np.array(lost) @ weights)

    @property
    def inertance(self) -> Floats:
        """(n,) of the blocks, Pa s^2/m^3."""
        return self.method.blood.density * np.array([block.slenderness for block in self.blocks])


class State(NamedTuple):
    """Steady flow through a network, in SI units."""

    flow: Floats
    """(n,) through the blocks, m^3/s."""
    inlet: float
    """Total pressure at the inlet, Pa."""


def tree_of(above: Indices) -> Tree:
    """A tree from the block above each block, -1 for the first one."""
    count = len(above)
    ends = np.flatnonzero(~np.isin(np.arange(count), above))
    leads_to = np.zeros((count, len(ends)), dtype=bool)
    leads_to[ends, np.arange(len(ends))] = True
    depth = np.zeros(count, dtype=np.int64)
    for number in range(1, count):
        depth[number] = depth[above[number]] + 1
    for number in reversed(range(1, count)):
        leads_to[above[number]] |= leads_to[number]
    levels = []
    for one in range(1, int(depth.max()) + 1):
        rows = np.flatnonzero(depth == one)
        rows = rows[np.argsort(above[rows], kind="stable")]
        parents, starts, counts = np.unique(above[rows], return_index=True, return_counts=True)
        levels.append(Level(rows, starts, counts, parents))
    return Tree(above, ends, leads_to, tuple(levels))


def steady(network: Network, outlets: Outlets, flow: float) -> State:
    """The state at a steady flow in m^3/s; errors as of `steady_states`."""
    return steady_states([(network, outlets, flow)])[0]


def steady_states(cases: Sequence[tuple[Network, Outlets, float]]) -> list[State]:
    """The states of networks of one tree at steady flows in m^3/s, all at once.

    The way to every outlet costs the same: `sum of (R + S |Q|) Q` along it, and its own resistance.
    By Newton's method; each step is solved from the outlets to the inlet and back: what begins at
    a junction is seen from there as one pressure and one resistance.

    Raises
    ------
    InputError
        No state is found.
    """
    tree = cases[0][0].tree
    linear = np.array([network.resistance for network, _, _ in cases])
    square = np.array([network.stenosis for network, _, _ in cases])
    beyond = np.array([outlets.resistance for _, outlets, _ in cases])
    wedge = np.array([[outlets.pressure] for _, outlets, _ in cases])
    inflow = np.array([flow for _, _, flow in cases])
    conductance = 1 / (beyond + linear @ tree.leads_to)
    shares = conductance / conductance.sum(axis=1)[:, None]
    flow = inflow[:, None] * (shares @ tree.leads_to.T)
    for _ in range(_STEPS):
        lost = square * np.abs(flow)
        pressure, resistance = -lost * flow, linear + 2 * lost
        pressure[:, tree.outlets] += wedge
        resistance[:, tree.outlets] += beyond
        following, inlet = _step(tree, pressure, resistance, inflow)
        change = np.abs(following - flow).max(axis=1)
        flow = following
        if (change <= _ENOUGH * np.maximum(np.abs(inflow), 1e-9)).all():
            return [State(*one) for one in zip(flow, inlet.tolist(), strict=True)]
    raise InputError(
        "flow: expected a network with one steady state, got none after "
        f"{_STEPS} steps; check that flow and pressures are in the units that they are said to be."
    )


def _step(
    tree: Tree, pressure: Floats, resistance: Floats, inflow: Floats
) -> tuple[Floats, Floats]:
    """Flows (c, n) through blocks that cost `pressure + resistance * flow`, and pressures (c,)
    at the inlet; both arrays (c, n) are changed to those of all that begins with a block."""
    seen = []
    for level in reversed(tree.levels):
        conductance = 1 / resistance[:, level.rows]
        whole = np.add.reduceat(conductance, level.starts, axis=1)
        back = np.add.reduceat(conductance * pressure[:, level.rows], level.starts, axis=1)
        resistance[:, level.parents] += 1 / whole
        pressure[:, level.parents] += back / whole
        seen.append((conductance, whole, back))
    flow = np.empty_like(pressure)
    flow[:, 0] = inflow
    for level, (conductance, whole, back) in zip(tree.levels, reversed(seen), strict=True):
        at = (flow[:, level.parents] + back) / whole
        away = np.repeat(at, level.counts, axis=1) - pressure[:, level.rows]
        flow[:, level.rows] = conductance * away
    return flow, pressure[:, 0] + resistance[:, 0] * inflow


def lost_to(network: Network, state_flow: Floats) -> Floats:
    """Total pressure (n,) that is lost from the inlet to the end of every block, Pa."""
    above = network.tree.above
    lost = (network.resistance + network.stenosis * np.abs(state_flow)) * state_flow
    for number in range(1, len(lost)):
        lost[number] += lost[above[number]]
    return lost
