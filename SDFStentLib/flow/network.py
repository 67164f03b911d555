"""A network of blocks between inlets and outlets that resist, and steady flow through it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..validation import Floats, InputError
from .blocks import Block, Method
from .tree import Tree

_STEPS = 60
"""The most steps of Newton's method; a few are enough, for the equations are those of a convex
minimum."""

_ENOUGH = 1e-10
"""The part of the flow by which the last step may change it."""


class Outlets(NamedTuple):
    """Resistances and pressure beyond the outlets, which are in the order of their channels."""

    resistance: Floats
    """(k,) resistances, Pa s/m^3."""
    pressure: float
    """Pressure beyond them, such as the wedge pressure, Pa."""


class Costs(Protocol):
    """A network as the solver asks for it."""

    @property
    def tree(self) -> Tree:
        """The tree of its n blocks."""

    @property
    def resistance(self) -> Floats:
        """(n,) of the blocks, Pa s/m^3."""

    @property
    def stenosis(self) -> Floats:
        """(n,) of the blocks, Pa s^2/m^6."""


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
        whole = np.array(lost) @ weights
        if method.bent:
            whole += method.bent * np.array([one.bending[-1] for one in self.blocks])
        return method.blood.density * whole

    @property
    def inertance(self) -> Floats:
        """(n,) of the blocks, Pa s^2/m^3."""
        return self.method.blood.density * np.array([block.slenderness for block in self.blocks])


class SteadyFlow(NamedTuple):
    """Steady flow through a network, in SI units."""

    flow: Floats
    """(n,) through the blocks, m^3/s."""
    inlet: float
    """Total pressure at the inlet, Pa."""


def steady(network: Costs, outlets: Outlets, flow: Floats | float) -> SteadyFlow:
    """The state at a steady flow in m^3/s; arguments and errors as of `steady_states`."""
    return steady_states([(network, outlets, flow)])[0]


def steady_states(cases: Sequence[tuple[Costs, Outlets, Floats | float]]) -> list[SteadyFlow]:
    """The states of networks of one tree at steady flows in m^3/s, all at once.

    A flow is the usual one, of which every inlet has its fraction, or an array (i,) of those
    through all inlets. The way to every outlet
    costs the same: `sum of (R + S |Q|) Q` along it, and its own resistance. By Newton's method;
    each step is solved from the outlets to the inlet and back: what begins at a junction is seen
    from there as one pressure and one resistance. What comes from other inlets and through chords
    is laid over that: of chords as much as makes both ways round a loop cost the same.

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
    inflow = np.array([flow * tree.fractions if np.ndim(flow) == 0 else flow for *_, flow in cases])
    most = np.maximum(np.abs(inflow).max(axis=1), 1e-9)
    # Where next to nothing flows, rounding of the pressure beyond the outlets decides.
    least = (beyond + linear[:, tree.outlets]).min(axis=1)
    enough = np.maximum(_ENOUGH * most, 4 * np.finfo(float).eps * np.abs(wedge[:, 0]) / least)
    conductance = 1 / (beyond + linear @ tree.leads_to)
    shares = conductance / conductance.sum(axis=1)[:, None]
    flow = inflow.sum(axis=1)[:, None] * (shares @ tree.leads_to.T)
    if not tree.is_plain:
        others = inflow.shape[1] - 1
        flow -= inflow[:, 1:] @ tree.beyond[:others]
    for _ in range(_STEPS):
        lost = square * np.abs(flow)
        pressure, resistance = -lost * flow, linear + 2 * lost
        pressure[:, tree.outlets] += wedge
        resistance[:, tree.outlets] += beyond
        if tree.is_plain:
            following, inlet = _step(tree, pressure, resistance, inflow[:, 0])
        else:
            following, inlet = _laid_over(tree, pressure, resistance, inflow)
        change = np.abs(following - flow).max(axis=1)
        flow = following
        if (change <= enough).all():
            return [SteadyFlow(*one) for one in zip(tree.signs * flow, inlet.tolist(), strict=True)]
    raise InputError(
        "flow: expected a network with one steady state, got none after "
        f"{_STEPS} steps; check that flow and pressures are in the units that they are said to be."
    )


def _laid_over(
    tree: Tree, pressure: Floats, resistance: Floats, inflow: Floats
) -> tuple[Floats, Floats]:
    """A step as `_step`, with inflows (c, i) at all inlets, and with chords."""
    count = inflow.shape[1] - 1
    flow, inlet = _with_sources(tree, pressure, resistance, inflow, range(count))
    if not len(tree.chords):
        return flow, inlet
    # How much more each way round costs with a unit of flow through each chord.
    none, ones = np.zeros_like(pressure), np.ones((len(pressure), 1))
    units = [
        _with_sources(tree, none, resistance, np.hstack([0 * ones, ones]), [count + k])
        for k in range(len(tree.chords))
    ]
    around = tree.beyond[count:].T
    at_none = (pressure + resistance * flow) @ around
    each = np.stack([(resistance * more) @ around for more, _ in units], axis=2)
    own = resistance[:, tree.chords, None] * np.eye(len(tree.chords))
    through = np.linalg.solve(own - each, (at_none - pressure[:, tree.chords])[..., None])
    for k, (more, seen) in enumerate(units):
        flow += through[:, k] * more
        inlet = inlet + through[:, k, 0] * seen
    flow[:, tree.chords] = through[..., 0]
    return flow, inlet


def _with_sources(
    tree: Tree, pressure: Floats, resistance: Floats, inflow: Floats, which: Sequence[int]
) -> tuple[Floats, Floats]:
    """A step as `_step`, with what comes from some sources behind the root's inflow (c, 1 + s)."""
    more, rows = inflow[:, 1:], list(which)
    flow, inlet = _step(
        tree, pressure.copy(), resistance.copy(), inflow[:, 0], more @ tree.enters[rows]
    )
    return flow - more @ tree.comes_by[rows], inlet


def _step(
    tree: Tree,
    pressure: Floats,
    resistance: Floats,
    inflow: Floats,
    entering: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Flows (c, n) through blocks that cost `pressure + resistance * flow`, and pressures (c,)
    at the root; both arrays (c, n) are changed to those of all that begins with a block.

    `entering` (c, n) comes in where blocks end. What leads to no outlet has no flow.
    """
    seen = []
    for level in reversed(tree.levels):
        conductance = 1 / resistance[:, level.rows]
        whole = np.add.reduceat(conductance, level.starts, axis=1)
        back = np.add.reduceat(conductance * pressure[:, level.rows], level.starts, axis=1)
        if entering is not None:
            back += entering[:, level.parents]
        resistance[:, level.parents] += 1 / whole
        pressure[:, level.parents] += back / whole
        seen.append((conductance, whole, back))
    flow = np.zeros_like(pressure)
    flow[:, tree.order[0]] = inflow
    for level, (conductance, whole, back) in zip(tree.levels, reversed(seen), strict=True):
        at = (flow[:, level.parents] + back) / whole
        away = np.repeat(at, level.counts, axis=1) - pressure[:, level.rows]
        flow[:, level.rows] = conductance * away
    root = tree.order[0]
    return flow, pressure[:, root] + resistance[:, root] * inflow


def lost_to(network: Costs, flow: Floats) -> Floats:
    """Total pressure (..., n) lost from the first inlet to the far end of every block, Pa."""
    cost = (network.resistance + network.stenosis * np.abs(flow)) * flow
    return lost_along(network.tree, cost)


def lost_along(tree: Tree, cost: Floats) -> Floats:
    """Losses as of `lost_to`, by what blocks cost along themselves (..., n), Pa.

    The far end of a block is its end where it leads away from the root of the tree, else where it
    begins.
    """
    lost = tree.signs * cost
    for number in tree.order[1:]:
        lost[..., number] += lost[..., tree.above[number]]
    return lost
