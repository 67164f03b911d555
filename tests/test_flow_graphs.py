"""Networks with several inlets and loops, against Newton's method for pressures at their nodes."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import root
from seeds import seeds

from SDFStentLib.flow import Outlets, Tree, steady, tree_between
from SDFStentLib.flow.network import lost_to
from SDFStentLib.validation import Floats


class Blocks(NamedTuple):
    """What a network tells the solver, with any resistances."""

    tree: Tree
    resistance: Floats
    stenosis: Floats


def a_graph(random, *, inlets, loops, inner=6):
    """Nodes between which blocks lead, all of them at least once; tips are inlets and outlets."""
    edges = [(int(random.integers(node)), node) for node in range(1, inner)]
    # Ends: there are pairs enough.
    while loops:
        one, other = sorted(random.choice(inner, 2, replace=False).tolist())
        if (one, other) not in edges:
            edges.append((one, other))
            loops -= 1
    degree = np.bincount(np.array(edges).ravel(), minlength=inner)
    tips = [int(node) for node in np.flatnonzero(degree == 1)] + random.integers(
        inner, size=3 + inlets
    ).tolist()
    edges += [(node, inner + k) for k, node in enumerate(tips)]
    blocks = np.array(edges)
    first = len(edges) - len(tips)
    entering = random.permutation(np.arange(first, len(edges)))[:inlets].tolist()
    turned = random.random(len(edges)) < 0.4
    turned[first:] = False
    turned[entering] = True
    blocks[turned] = blocks[turned, ::-1]
    return blocks, entering


def by_nodes(blocks, inlets, network, outlets, inflow):
    """Flows, and pressures at the inlets, by pressures at nodes at which flows add up to none."""
    count = int(blocks.max()) + 1
    ends = network.tree.outlets

    def through(cost, r, s):
        """Of `r q + s q |q| = cost`."""
        return 2 * cost / (r + np.sqrt(r**2 + 4 * s * np.abs(cost)))

    def missing(x):
        pressure = np.abs(inflow).sum() * outlets.resistance.mean() * x
        flow = through(
            pressure[blocks[:, 0]] - pressure[blocks[:, 1]], network.resistance, network.stenosis
        )
        left = np.zeros(count)
        np.add.at(left, blocks[:, 1], flow)
        np.add.at(left, blocks[:, 0], -flow)
        left[blocks[ends, 1]] -= (pressure[blocks[ends, 1]] - outlets.pressure) / outlets.resistance
        left[blocks[inlets, 0]] += inflow
        missing.found = flow, pressure
        return left / np.abs(inflow).sum()

    found = root(missing, np.full(count, 0.5), tol=1e-14)
    # Firm outlets have pressures ten thousand times what blocks cost.
    assert np.abs(missing(found.x)).max() < 1e-6
    flow, pressure = missing.found
    return flow, pressure[blocks[inlets, 0]]


@pytest.mark.parametrize("seed", seeds(40, 400))
def test_any_network_is_solved_as_by_pressures_at_its_nodes(seed):
    random = np.random.default_rng(seed)
    inlets, loops = int(random.integers(1, 4)), int(random.integers(0, 4))
    blocks, entering = a_graph(random, inlets=inlets, loops=loops)
    tree = tree_between(blocks, dict.fromkeys(blocks[entering, 0].tolist(), 1.0))
    assert len(tree.chords) == loops
    count = len(blocks)
    resistance = 1e7 * np.exp(random.normal(0, 1.5, count))
    network = Blocks(
        tree, resistance, 1e12 * np.exp(random.normal(0, 2, count)) * (random.random(count) < 0.7)
    )
    outlets = Outlets(1e8 * np.exp(random.normal(0, 1, len(tree.outlets))), 1000.0)
    inflow = 1e-6 * random.uniform(0, 40, inlets) * (random.random(inlets) < 0.8)
    if random.random() < 0.3:
        inflow = -inflow
    inflow[0] += 1e-6
    state = steady(network, outlets, inflow)
    flow, pressure = by_nodes(blocks, entering, network, outlets, inflow)
    assert state.flow == pytest.approx(flow, abs=1e-8 * np.abs(inflow).sum())
    told = state.inlet - np.r_[0.0, lost_to(network, state.flow)[tree.inlets[1:]]]
    assert told == pytest.approx(pressure, abs=1e-4 * 133.322)
    left = state.flow[tree.outlets].sum()
    assert left == pytest.approx(inflow.sum(), rel=1e-9)
