"""Limbs that part and meet again, against closed forms, Newton's method and svZeroDSolver."""

import json

import numpy as np
import pytest
from scipy.optimize import brentq
from seeds import seeds
from test_flow_graphs import by_nodes

from SDFStentLib.centerline import Centerline, joined_lumens
from SDFStentLib.flow import (
    Channel,
    FlowModel,
    known_flow,
    solved_by_svzerod,
    steady,
)
from SDFStentLib.flow.limbs import joined_limbs
from SDFStentLib.report import flow_document, flow_sentences

MMHG = 133.322
RHO, MU = 1060.0, 0.004


def a_channel(start, length, diameter, above, joins=-1):
    """A straight one along x; of a limb only its length and its widths matter."""
    x = np.linspace(0, length, max(int(4 * length), 41))
    size = diameter(x) if callable(diameter) else np.full(len(x), diameter)
    line = np.column_stack([start + x, 0 * x, 0 * x])
    none = np.zeros(len(x), dtype=np.int64)
    return Channel(line, start + x, size, size, none, x, above, joins=joins)


def parallel(first, second, outlet=10.0):
    """Two limbs, each (length, diameter), between an inlet and an outlet of 10 mm."""
    return (
        a_channel(0.0, 30.0, 10.0, -1),
        a_channel(30.0, *first, 0),
        a_channel(30.0 + first[0], 30.0, outlet, 1),
        a_channel(30.0, *second, 0, joins=1),
    )


def shares_of(model, moment="mean"):
    return [band.value for band in model.answer().before[moment].limbs]


def test_limbs_that_are_alike_share_the_flow():
    assert shares_of(FlowModel(parallel((50.0, 6.0), (50.0, 6.0)), known_flow(20.0))) == (
        pytest.approx([0.5, 0.5], abs=1e-6)
    )


@pytest.mark.parametrize(("length", "diameter"), [(900.0, 5.0), (1500.0, 6.0), (700.0, 4.0)])
def test_long_limbs_share_the_flow_by_poiseuilles_law(length, diameter):
    """What blood rubs more where it enters is little there."""
    limbs = parallel((1000.0, 5.0), (length, diameter))
    first, second = shares_of(FlowModel(limbs, known_flow(0.5)))
    conductances = np.array([5.0**4 / 1000, diameter**4 / length])
    assert [first, second] == pytest.approx(conductances / conductances.sum(), abs=0.01)


def test_a_narrowed_limb_has_the_flow_that_its_narrowing_lets_through():
    """A limb of 8 mm with 60 % beside one of 6 mm and 79 mm, of 50 mL/s: 13 to 16 % for losses of 1
    to 1.52 times Borda's and Carnot's of even flow. Of a parabola they are twice that."""

    def narrowed(x):
        return 8 * (1 - 0.6 * np.exp(-(((x - 25) / 4) ** 2)))

    model = FlowModel(parallel((50.0, narrowed), (79.0, 6.0)), known_flow(50.0))
    x = np.linspace(0, 0.05, 4001)
    radius = 0.5e-3 * narrowed(1e3 * x)
    rubbed = 8 * MU / np.pi * np.trapezoid(radius**-4.0, x)
    beside = 8 * MU / np.pi * 0.079 / 0.003**4
    borda = RHO / 2 * (1 / (np.pi * 0.0016**2) - 1 / (np.pi * 0.004**2)) ** 2

    def share(times):
        def wrong(q):
            return (rubbed + times * borda * q) * q - beside * (50e-6 - q)

        return brentq(wrong, 0, 50e-6) / 50e-6

    low, high = share(1.52), share(1.0)
    assert 0.12 < low < high < 0.17
    told = model.answer().before["mean"].limbs[0]
    assert share(2 * 1.52) < told.value < high
    assert told.low < share(2.0) < told.high


def random_loops(random):
    """A trunk, two to four limbs to where it goes on, and a branch behind them."""
    made = [a_channel(0.0, 20.0, 10.0, -1)]
    spine = [0]
    for _ in range(int(random.integers(1, 4))):
        made.append(a_channel(0.0, random.uniform(20, 60), random.uniform(4, 9), spine[-1]))
        spine.append(len(made) - 1)
    made.append(a_channel(0.0, 30.0, random.uniform(4, 8), spine[-1]))
    made.append(a_channel(0.0, 30.0, random.uniform(4, 8), spine[-1]))
    for _ in range(int(random.integers(1, 4))):
        begin, end = sorted(random.choice(len(spine), 2, replace=False).tolist())
        depth = random.uniform(0, 0.7) * (random.random() < 0.5)
        width, length = random.uniform(3, 8), random.uniform(20, 90)

        def diameter(x, width=width, depth=depth, length=length):
            return width * (1 - depth * np.exp(-(((x - length / 2) / 5) ** 2)))

        made.append(a_channel(0.0, length, diameter, spine[begin], joins=spine[end]))
    along = [0.0]
    for one in made[1:]:
        along.append(float(along[one.above] + made[one.above].along[-1] - made[one.above].along[0]))
    return tuple(
        one._replace(along=one.along - one.along[0] + at)
        for one, at in zip(made, along, strict=True)
    )


@pytest.mark.parametrize("seed", seeds(8, 150))
def test_random_loops_are_solved_as_by_pressures_at_nodes_and_by_svzerod(seed):
    random = np.random.default_rng(seed)
    pressures = {"inlet": 90.0, "wedge": 8.0} if random.random() < 0.5 else {}
    known = known_flow(float(random.uniform(1, 40)), **pressures)
    model = FlowModel(random_loops(random), known)
    answer = model.answer()
    (network,), moment = answer.networks, answer.before["mean"]
    tree, mean = network.tree, 1e-6 * known.mean
    assert len(tree.outlets) == 2
    state = steady(network, answer.outlets, mean)
    flow, _ = by_nodes(
        tree.ends, tree.inlets.tolist(), network, answer.outlets, tree.fractions * mean
    )
    assert state.flow == pytest.approx(flow, abs=3e-6 * mean)
    inlet, through = solved_by_svzerod(network, answer.outlets, known)
    assert through[-1] == pytest.approx(state.flow, abs=1e-6 * mean)
    assert inlet[-1] == pytest.approx(state.inlet, abs=1e-3 * MMHG)
    # The profiles are those of the flows that come of them.
    assert state.flow[state.flow > 1e-3 * mean].min() > 0
    assert np.isfinite([(*band,) for band in moment.limbs]).all()
    if moment.sides:
        assert sum(band.value for band in moment.sides) == pytest.approx(1.0, abs=1e-9)
    words = flow_sentences(flow_document(answer, {}))
    json.dumps(flow_document(answer, {}), allow_nan=False)
    assert any("meet again" in one for one in words)


def an_arc(radius=3.0):
    """A straight line of which an arc parts and meets it again: a tree, with where that is."""
    line = np.column_stack([np.zeros((121, 2)), np.linspace(-30, 90, 121)])
    turn = np.linspace(-np.pi / 2, np.pi / 2, 81)[1:-1]
    arc = np.column_stack([25 * np.cos(turn), 0 * turn, 30 + 30 * np.sin(turn)])
    parent = np.r_[np.arange(121) - 1, [30], 121 + np.arange(78)]
    tree = Centerline(np.vstack([line, arc]), np.r_[np.full(121, 5.0), np.full(79, radius)], parent)
    object.__setattr__(tree, "loops", np.array([[199, 90]]))
    return tree


def test_a_vessel_is_parted_where_a_limb_meets_it_again():
    tree = an_arc()
    found, joins = joined_limbs(joined_lumens(tree.lumens).stretches, tree)
    assert len(found) == 4
    ((limb, end),) = joins.items()
    assert all(one.above < number for number, one in enumerate(found))
    above = [one.above for one in found]
    assert above[limb] == above[end] == 0
    (onward,) = (k for k in range(4) if above[k] == end)
    meeting = found[end].points[-1]
    assert np.linalg.norm(meeting - [0, 0, 60]) < 2.0
    assert found[limb].points[-1] == pytest.approx(meeting)
    assert found[onward].points[0] == pytest.approx(meeting)
    assert found[onward].points[-1] == pytest.approx([0, 0, 90])
    # Nothing of the limb lies in the vessel that it meets but its end.
    assert np.linalg.norm(found[limb].points[:-1] - meeting, axis=1).min() > 5.0 - 1e-6
    for one in found:
        assert (np.diff(one.along) > 0).all()
    assert found[onward].along[0] == found[end].along[-1]
