"""Flow through networks: against closed forms, axisymmetric references, and svZeroDSolver."""

import json
import re
import shutil
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from seeds import seeds

from benchmarks.phantoms import (
    arch_with_coarctation,
    stenosed_tube,
    straight_tube,
    vascular_tree,
)
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.flow import (
    FlowModel,
    FollowedChannels,
    Network,
    Outlets,
    Part,
    Wave,
    channels_of,
    flow_value,
    known_flow,
    read_wave,
    solved_by_svzerod,
    steady,
    svzerod_document,
    tree_between,
)
from SDFStentLib.flow.blocks import Method, Stream, blocks_of, turns_of
from SDFStentLib.flow.channels import Channel, Widths, widths_of
from SDFStentLib.flow.profiles import (
    ChannelStations,
    bends_of,
    deans_of,
    layers_of,
    profile_of,
    swept_of,
)
from SDFStentLib.flow.spans import BlockPart, drop_over
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import equivalent_diameters, inscribed_spheres
from SDFStentLib.validation import DeploymentError, InputError

MMHG = 133.322
RHO, MU = 1060.0, 0.004


def block(x, narrow, wide=None, flow=10.0):
    """Of ellipses along a straight vessel, mm, at a flow in mL/s."""
    x, narrow = np.asarray(x, float), np.asarray(narrow, float)
    line = np.column_stack([x, 0 * x, 0 * x])
    none = np.zeros(len(x), dtype=np.int64)
    channel = Channel(line, x, narrow, narrow, none, x, -1)
    widths = Widths(narrow, narrow if wide is None else np.asarray(wide, float))
    stream = Stream(np.array([1e-6 * flow]), np.zeros(1), np.zeros(len(x)))
    blocks = blocks_of([channel], (widths,), stream)
    return Network(blocks, tree_between(np.array([[0, 1]]), {0: 1.0}))


def area(diameter):
    return np.pi / 4 * (1e-3 * diameter) ** 2


def throat(x, depth, middle=30.0, half=8.0, healthy=6.0):
    """A raised cosine, as the phantom has it."""
    return healthy * (1 - depth / 2 * (1 + np.cos(np.pi * np.clip((x - middle) / half, -1, 1))))


def test_a_tube_costs_what_poiseuille_says_and_an_ellipse_what_white_says():
    x = np.linspace(0, 40, 41)
    tube = block(x, np.full(41, 6.0))
    assert tube.resistance[0] == pytest.approx(8 * MU * 0.04 / (np.pi * 0.003**4), rel=1e-12)
    assert tube.inertance[0] == pytest.approx(RHO * 0.04 / area(6.0), rel=1e-12)
    assert tube.stenosis[0] == 0.0
    a, b = 0.004, 0.002
    oval = block(x, np.full(41, 4.0), np.full(41, 8.0))
    white = 4 * MU * 0.04 * (a**2 + b**2) / (np.pi * a**3 * b**3)
    assert oval.resistance[0] == pytest.approx(white, rel=1e-12)


@pytest.mark.parametrize("radius", [12.0, 40.0, 400.0])
@pytest.mark.parametrize("flow", [2.0, 20.0, 55.0])
def test_a_bend_costs_what_was_measured_in_coils(radius, flow):
    """White, Proc R Soc A 1929;123:645: friction over that of a straight tube by Dean's number."""
    x = np.linspace(0, 600, 1501)
    line = radius * np.column_stack([np.cos(x / radius), np.sin(x / radius), 0 * x])
    size, none = np.full(len(x), 4.0), np.zeros(len(x), dtype=np.int64)
    channel, widths = Channel(line, x, size, size, none, x, -1), (Widths(size, size),)
    bends = bends_of([channel], widths)
    assert bends[x < 7.5] == pytest.approx(0.0)  # the way before it is not known
    assert bends[x > 8.5] == pytest.approx(1e3 / radius, rel=0.02)
    stream = Stream(np.array([1e-6 * flow]), np.zeros(1), bends)
    (found,) = blocks_of([channel], widths, stream)
    told = (found.friction[-1] - found.friction[1000]) / (8 * 0.2 / (np.pi * 0.002**4))
    dean = RHO * 1e-6 * flow / area(4.0) * 0.004 / MU * (2 / radius) ** 0.5
    white = 1 / (1 - (1 - (11.6 / dean) ** 0.45) ** (1 / 0.45)) if dean > 11.6 else 1.0
    assert told == pytest.approx(white, rel=0.08)


DEVELOPING = [
    (100, 1.0, 1.0, 1.585),
    (300, 1.0, 1.0, 2.475),
    (845, 1.0, 1.0, 4.22),
    (845, 1.61, 0.6, 3.43),
    (845, 3.1, 0.3, 2.93),
    (300, 3.1, 0.3, 2.07),
]
"""By Dean's number, and by how much a mouth narrows before (so thin is the layer over the radius
then), what is lost in a bend of 194 degrees over what a straight tube loses: Navier-Stokes
equations marched along it (docs/flow.md)."""


@pytest.mark.parametrize(("dean", "mouth", "layer", "reference"), DEVELOPING)
def test_a_bend_costs_what_blood_loses_that_it_sweeps_across(dean, mouth, layer, reference):
    """A bend of 7.8 radii, 26.4 radii long; radius and mean speed are 1."""
    steps = 1000
    reynolds = dean / 0.128**0.5  # by the diameter
    way = ChannelStations([0, steps + 2], [[]], np.r_[1e-9, np.full(steps, 26.4 / steps), 0.0])
    area, spread = np.full(steps + 2, np.pi), np.full(steps + 2, 2 / (np.pi * reynolds))
    area[0] *= mouth
    bends = np.full(steps + 2, 0.128)
    layers = layers_of(way, area, spread, deans_of(area, spread, bends))
    assert layers[1] == pytest.approx(layer, abs=0.01)
    swept = swept_of(way, area, layers, deans_of(area, spread, bends))[1:]
    friction = profile_of(layers[1:]).friction
    lost = (friction[1:] + friction[:-1]).mean() / 2
    # Of density and the square of the speed a straight tube loses 16 lengths over Reynolds' number.
    lost += np.pi**2 * swept.sum() / (16 * 26.4 / reynolds)
    assert lost == pytest.approx(reference, rel=0.11)


def test_a_sudden_expansion_before_a_long_vessel_loses_what_borda_and_carnot_say():
    x = np.r_[0.0, 10.0, 10.0 + 1e-6, np.linspace(11, 600, 6000)]
    lost = block(x, np.where(x <= 10, 3.0, 6.0)).stenosis[0]
    # Of even speeds that carry the energy of a parabola, twice that of the mean one.
    expected = RHO * (1 / area(3.0) - 1 / area(6.0)) ** 2
    assert lost == pytest.approx(expected, rel=0.01)


def test_blood_that_enters_a_tube_costs_what_was_measured_there():
    """Behind a wide vessel layers begin thin: more than Poiseuille's by 1.33 heads (Shah 1978),
    one of which is what a parabola has more than an even profile."""
    x = np.r_[np.linspace(0, 20, 41), 20 + np.geomspace(0.01, 500, 3000)]
    narrow = np.where(x <= 20, 40.0, 4.0)
    tube = block(x, narrow, flow=10.0)
    speed = 10e-6 / area(4.0)
    reynolds = RHO * speed * 0.004 / MU
    even = speed * area(4.0) * tube.blocks[0].jet
    developed = x[np.searchsorted(even, 1.99**0.5 * speed)] - 20
    assert developed == pytest.approx(0.0288 * reynolds * 4.0, rel=0.15)  # Schiller 1922
    poiseuille = 128 * MU * 10e-6 * 0.5 / (np.pi * 0.004**4)
    lost = tube.resistance[0] * 10e-6 + RHO / 2 * speed**2 * (2 - 1)
    assert (lost - poiseuille) / (RHO / 2 * speed**2) == pytest.approx(1.33, rel=0.1)


def a_branch(angle, diameter, share=0.3):
    """That leaves a tube of 6 mm with 10 mL/s."""
    x = np.linspace(0, 300, 601)
    none = np.zeros(len(x), dtype=np.int64)
    trunk = np.column_stack([x, 0 * x, 0 * x])
    side = trunk[-1] + np.outer(x, [np.cos(angle), np.sin(angle), 0.0])
    channels = [
        Channel(line, start + x, size + 0 * x, size + 0 * x, none, x, above)
        for line, start, size, above in ((trunk, 0.0, 6.0, -1), (side, 300.0, diameter, 0))
    ]
    widths = [Widths(one.inscribed, one.inscribed) for one in channels]
    flow = 1e-6 * np.array([10.0, 10.0 * share])
    stream = Stream(flow, turns_of(channels, widths), np.zeros(2 * len(x)))
    return blocks_of(channels, widths, stream)[1]


def branch(angle, diameter=4.0, share=0.3):
    """What it loses, Pa, and the speeds before it and in it."""
    found = a_branch(angle, diameter, share)
    speeds = 10e-6 / area(6.0), 10e-6 * share / area(diameter)
    lost = found.mixing[-1] + found.dividing[-1] + found.turning
    return RHO * lost * (10e-6 * share) ** 2, speeds


@pytest.mark.parametrize("degrees", [0, 30, 60, 90])
def test_a_branch_costs_what_its_angle_and_its_speed_say(degrees):
    """Mynard 2015: half of the square of the change of speed, at three quarters of the angle."""
    lost, (first, second) = branch(np.radians(degrees), 5.0)
    turned = 0.75 * np.radians(degrees)
    whole = first**2 + second**2 - 2 * first * second * np.cos(turned)
    # Twice, for both are parabolas.
    assert lost == pytest.approx(RHO * whole, rel=0.02)


def test_blood_that_speeds_up_into_a_branch_loses_only_what_moves_across():
    lost, (first, second) = branch(np.radians(60), 2.0)
    assert second > first
    assert lost == pytest.approx(RHO * (first * np.sin(np.radians(45))) ** 2, rel=0.02)


def test_a_narrowing_and_flow_that_divides_are_uncertain_on_their_own():
    x, tree, flow = (
        np.linspace(0, 300, 601),
        tree_between(np.array([[0, 1]]), {0: 1.0}),
        np.array([3e-6]),
    )
    (narrowing,) = block(x, throat(x, 0.6), flow=3.0).blocks
    for one, own, other in (
        (narrowing, "loss", "divided"),
        (a_branch(0.0, 5.0), "divided", "loss"),
    ):
        usual, none, whole, same = (
            Network((one,), tree, Method(**method))
            for method in ({}, {own: 0.0}, {own: 1.5}, {other: 0.4})
        )
        assert usual.stenosis[0] > 0
        assert none.stenosis[0] == pytest.approx(0, abs=1e-9 * usual.stenosis[0])
        assert whole.stenosis == pytest.approx(1.5 * usual.stenosis)
        assert same.stenosis == pytest.approx(usual.stenosis)
        # What a branch takes over is not lost by the branch, however much that is.
        drops = [drop_over([BlockPart(0, 0, 600)], each, flow).recovered for each in (usual, whole)]
        rubbed = float(usual.resistance[0] * flow[0])
        grows = 1.5 if own == "loss" else 1.0
        assert drops[1] - rubbed == pytest.approx(grows * (drops[0] - rubbed), abs=0.02 * MMHG)


@pytest.mark.parametrize("wider", [0.2, 0.4, -0.3])
def test_blood_hardly_faster_than_its_branch_costs_what_blood_as_fast_does(wider):
    """It ran along the wall wherever that went, where blood as fast as its branch parts from it."""
    x = np.linspace(0, 60, 241)
    shape = 1 + wider * np.exp(-(((x - 30) / 6) ** 2))

    def costs(diameter):
        """Friction, mixing and jet of half the flow of a tube of 10 mm."""
        made = []
        for start, size, above in ((0, 10 + 0 * x, -1), (60, diameter * shape, 0)):
            line = np.column_stack([0 * x, 0 * x, start + x])
            made.append(Channel(line, start + x, size, size, np.zeros(241, dtype=int), x, above))
        widths = [Widths(one.inscribed, one.inscribed) for one in made]
        stream = Stream(np.array([1e-5, 5e-6]), np.zeros(2), np.zeros(482))
        found = blocks_of(made, widths, stream)[1]
        lost = found.mixing[-1] + found.dividing[-1]
        return np.array([found.friction[-1], lost, found.jet[-1]])

    found = np.array([costs(share * 10 * 0.5**0.5) for share in np.linspace(0.995, 1.005, 21)])
    assert np.abs(np.diff(found, axis=0) / found[1:]).max() < 0.01


@pytest.mark.parametrize("seed", seeds(20, 100))
def test_a_branch_that_is_dilated_takes_no_smaller_share(seed):
    """Of a fork whose outlets resist as before; narrowings of two fifths and more."""
    rng = np.random.default_rng(seed)
    x, none = np.linspace(0, 60, 241), np.zeros(241, dtype=np.int64)
    angles = np.array([0.0, *rng.uniform(0, 1.5, 2) * [1, -1]])
    sizes = rng.uniform(6, 12) * np.array([1.0, *rng.uniform(0.45, 0.95, 2)])
    narrow = throat(x, rng.uniform(0.4, 0.7), rng.uniform(9, 40), healthy=sizes[1])
    split = rng.uniform(0.15, 0.85)
    flow = 1e6 * area(sizes[0]) * rng.uniform(0.1, 0.7) * np.array([1.0, split, 1 - split])
    stream = Stream(1e-6 * flow, np.abs(angles), np.zeros(3 * len(x)))
    outlets = Outlets(rng.uniform(2, 20) * MMHG / stream.flow[1:], 0.0)
    shares = []
    for wide in (narrow, 0 * x + sizes[1]):
        diameters = [0 * x + sizes[0], wide, 0 * x + sizes[2]]
        channels = []
        for k, (angle, size) in enumerate(zip(angles, diameters, strict=True)):
            start = 60.0 * (k > 0)
            line = np.array([start, 0, 0]) + np.outer(x, [np.cos(angle), np.sin(angle), 0])
            channels.append(Channel(line, start + x, size, size, none, x, min(k, 1) - 1))
        widths = [Widths(size, size) for size in diameters]
        network = Network(
            blocks_of(channels, widths, stream),
            tree_between(np.array([[0, 1], [1, 2], [1, 3]]), {0: 1.0}),
        )
        state = steady(network, outlets, float(stream.flow[0]))
        shares.append(state.flow[1] / state.flow[0])
    assert shares[1] >= shares[0]


def test_narrowings_on_both_sides_of_any_share_tell_nearly_the_same():
    x = np.linspace(0, 200, 1001)
    depths = np.r_[0.0, np.linspace(0.003, 0.499, 125)]  # 0.4 % apart
    for flow in (2e-6, 20e-6):
        tubes = [block(x, throat(x, depth), flow=1e6 * flow) for depth in depths]
        costs = np.array([one.resistance[0] * flow + one.stenosis[0] * flow**2 for one in tubes])
        costs = (costs[1:] - costs[0]) / MMHG
        steps = np.diff(costs)
        # Where blood begins to part from the wall, at some 4 %, friction ends there.
        assert steps.min() > -0.02
        assert (steps[depths[1:-1] >= 0.1] > 0).all()
        low, high = np.searchsorted(depths, [0.1485, 0.1505]) - 1
        assert (high - low, costs[high] / costs[low]) < (2, 1.06)


@pytest.mark.parametrize(
    ("depth", "half", "flow"), [(0.54, 4, 6.0), (0.54, 4, 12.0), (0.7, 8, 5.0)]
)
def test_a_narrowing_costs_the_same_wherever_stations_lie(depth, half, flow):
    """They are 0.4 diameters of the throat apart, while a jet parts within a tenth of one."""

    def cost(x):
        tube = block(x, throat(x, depth, 60.0, half), flow=flow)
        ends = np.searchsorted(x, [60.0 - half - 3, 60.0 + half + 3]).tolist()
        return drop_over([BlockPart(0, *ends)], tube, np.array([1e-6 * flow])).recovered

    close = cost(np.linspace(0, 220, 4401))
    apart, near = 2.4 * (1 - depth), 0.6 * (1 - depth) * np.arange(-2, 3)
    for shift in np.linspace(0, apart, 12):
        x = np.arange(shift, 220, apart)
        x = np.union1d(x[np.abs(x - 60) > 1.2 * near[-1]], 60 + near)
        assert cost(x) == pytest.approx(close, rel=0.15)


@pytest.mark.parametrize("seed", seeds(10, 40))
def test_no_part_of_a_vessel_gives_back_what_is_lost(seed):
    """Not one in the jet of a narrowing before it either, of which it spares some."""
    rng = np.random.default_rng([seed, 9])
    x = np.linspace(0, 120, 481)
    size = np.interp(x, np.sort(rng.uniform(0, 120, 5)), rng.uniform(2.5, 7.0, 5))
    vessel = block(x, size, flow=20.0)
    drops = []
    for start, end in np.sort(rng.uniform(0, 480, (100, 2)), axis=1).tolist():
        drops.append(drop_over([BlockPart(0, start, end)], vessel, np.array([20e-6])))
        assert drops[-1].recovered >= 0
    assert max(one.recovered for one in drops) > MMHG


@pytest.mark.parametrize("wide", [6.6, 7.2, 7.8, 8.4])
def test_no_range_of_a_drop_begins_below_zero(wide):
    """A part costs nothing or something, whatever in it is uncertain."""
    x = np.linspace(0, 60, 241)
    size = np.interp(x, [22, 24, 31, 33], [6.0, wide, wide, 6.0])
    line = np.column_stack([0 * x, 0 * x, x])
    vessel = Channel(line, x, size, size, np.zeros(241, dtype=np.int64), x, -1)
    parts = [Part("", line[start : start + 40]) for start in range(60, 140, 4)]
    for flow in (2.0, 20.0, 90.0):
        answer = FlowModel([vessel], known_flow(flow, peak=2 * flow)).answer(None, parts)
        for moment in answer.before.values():
            for drop in moment.drops:
                assert 0 <= drop.recovered.low <= drop.recovered.value <= drop.recovered.high
                assert 0 <= drop.maximal.low <= drop.maximal.value <= drop.maximal.high


REFERENCE = {
    (0.5, 16): {2: 0.34, 5: 1.36, 10: 4.24, 20: 14.2},
    (0.54, 8): {3: 0.75, 6: 2.50, 12: 8.78, 16: 15.0},
    (0.7, 16): {2: 2.88, 5: 14.3, 8: 33.7},
}
"""Recovered drops, mmHg, 1,200 mm behind a narrowing, by it, its mm, and mL/s, of an axisymmetric
P2-P1 reference."""

AT_150 = {
    (0.5, 16): {2: 0.34, 5: 1.37, 10: 4.57, 20: 18.7},
    (0.54, 8): {3: 0.75, 6: 2.53, 12: 10.1, 16: 18.9},
    (0.7, 16): {2: 2.90, 5: 14.7, 8: 37.4},
}
"""The same 150 mm behind it, where fast jets have not mixed yet."""

LOWEST = {
    (0.5, 16): {2: 0.64, 5: 2.70, 10: 9.42, 20: 34.0},
    (0.54, 8): {3: 1.32, 6: 4.70, 12: 17.4, 16: 30.1},
    (0.7, 16): {2: 4.03, 5: 20.7, 8: 49.3},
}
"""Static drops on the axis, to its lowest pressure."""


def static(tube, flow):
    """Static pressure along a vessel that is lost from its start, mmHg."""
    (one,) = tube.blocks
    return (MU * one.friction + RHO * (one.mixing + one.jet**2 / 2) * flow) * flow / MMHG


@pytest.mark.parametrize(("depth", "length"), AT_150)
def test_a_jet_has_mixed_as_far_as_the_navier_stokes_equations_say(depth, length):
    x = np.linspace(0, 260, 1301)
    ends = [60 - length / 2 - 3, 60 + length / 2 + 153]
    for flow, reference in AT_150[depth, length].items():
        lost = static(block(x, throat(x, depth, 60.0, length / 2), flow=flow), 1e-6 * flow)
        healthy = 8 * MU * 1e-6 * flow * 0.15 / (np.pi * 0.003**4) / MMHG
        assert np.diff(np.interp(ends, x, lost)) - healthy == pytest.approx(reference, rel=0.15)


BEHIND = {
    7.0: (16.5, 15.1, 12.7),
    4.2: (15.5, 14.8, 12.4),
    2.0: (14.6, 14.4, 13.0),
    1.0: (14.1, 14.0, 13.5),
}
"""Static drops 15, 40 and 110 mm behind the throat of the arch, were it straight, mmHg, at 60 mL/s,
by how many times more viscous blood is."""


@pytest.mark.parametrize("times", BEHIND)
def test_behind_a_throat_pressure_is_what_the_navier_stokes_equations_say(times):
    x = np.linspace(0, 220, 1101)
    lost = static(
        block(x, throat(x, 1 - 3.2 / 7, 60.0, 10.0, 14.0), flow=60 / times), 60e-6 / times
    )
    told = np.interp([75.0, 100.0, 170.0], x, lost) - np.interp(45.0, x, lost)
    # As thin blood that is slower by as much.
    assert times**2 * told == pytest.approx(BEHIND[times], rel=0.1)


@pytest.mark.parametrize(("depth", "length"), REFERENCE)
def test_stenosed_tubes_cost_what_the_navier_stokes_equations_say(depth, length):
    phantom = stenosed_tube(3.0, 3.0 * (1 - depth), 200.0, 0.5, stenosis_length=length)
    channels = channels_of(phantom.surface, phantom.centerline)
    along, line = channels[0].along, channels[0].points
    lines = [Part("throat", line[np.abs(along - 100) <= length / 2 + 3])]
    for flow, recovered in REFERENCE[depth, length].items():
        drop = FlowModel(channels, known_flow(flow)).answer(None, lines).before["mean"].drops[0]
        assert drop.recovered.value == pytest.approx(recovered, rel=0.15)
        assert drop.recovered.low < recovered < drop.recovered.high
        static = LOWEST[depth, length][flow]
        assert drop.maximal.value == pytest.approx(static, rel=0.15)
        assert drop.maximal.low < static < drop.maximal.high


ARCH = {60 / 4.2: 1.012, 30: 4.08, 60 / 1.4: 8.06, 50: 10.83}
"""Static drops to the throat of the arch by mL/s, mmHg, on which two meshes of hexahedra agree, but
that at 50 mL/s, which is of the finer one."""


def test_a_narrowing_behind_a_bend_costs_what_the_navier_stokes_equations_say():
    phantom = arch_with_coarctation()
    channels = channels_of(phantom.surface, phantom.centerline)
    line = channels[0].points
    near = np.linalg.norm(line - phantom.throat.point, axis=1) <= 15
    for flow, reference in ARCH.items():
        model = FlowModel(channels, known_flow(flow))
        maximal = model.answer(None, [Part("throat", line[near])]).before["mean"].drops[0].maximal
        assert maximal.value == pytest.approx(reference, rel=0.03)
        assert maximal.low < reference < maximal.high


@pytest.mark.parametrize("flow", [1e-13, 1e-10, 1e-8])
def test_next_to_no_flow_has_a_state_above_any_pressure(flow):
    """Rounding of the pressure beyond outlets that resist little kept flows from staying."""
    made = vascular_tree(8, 0.8, {1: 0.5, 4: 0.6, 8: 0.4})
    channels = channels_of(made.surface, made.centerline)
    network = FlowModel(channels, known_flow(30.0)).answer().networks[0]
    outlets = Outlets(np.full(8, 200.0), 100 * MMHG)
    for own in (flow, -flow):
        state = steady(network, outlets, own)
        assert state.inlet == pytest.approx(100 * MMHG, rel=1e-3)
        through = state.flow[network.tree.outlets].sum()
        assert through == pytest.approx(own, rel=1e-3, abs=1e-14)


def test_an_artery_costs_what_the_navier_stokes_equations_say(data_dir):
    """docs/flow.md: by finite volumes, mmHg, of which what the jet loses is told till 11 mm."""
    surface = read_surface(data_dir / "su0243_surface_mm.vtp").surface
    tree = read_centerline(data_dir / "su0243_centerline_mm.vtp")
    ends = [[2.3, -91.1, -49.2], [12.9, -69.5, -65.1]]
    known = known_flow(2500 / 60, split_right=0.8, right=(-3.3, -96.4, -58.0))
    model = FlowModel(channels_of(surface, tree), known)
    part = Part("artery", tree.path(*tree.ends_of_path(*np.array(ends))).points)
    (drop,) = model.answer(None, [part]).before["mean"].drops
    assert drop.recovered.value == pytest.approx(6.60, rel=0.2)
    assert drop.recovered.low < 6.60 < drop.recovered.high
    assert drop.maximal.value == pytest.approx(8.23, rel=0.15)
    assert drop.maximal.low < 8.23 < drop.maximal.high


@pytest.fixture(scope="module")
def a_tree():
    """Of eight outlets that are all alike, with narrowings, and what its own centerline tells."""
    made = vascular_tree(8, 0.8, {1: 0.5, 4: 0.6, 8: 0.4})
    return made, lost_to_outlets(channels_of(made.surface, made.centerline))


def lost_to_outlets(channels):
    """Shares of the outlets, and what is lost on the way to each, mmHg, the least first."""
    answer = FlowModel(channels, known_flow(40.0)).answer()
    network, outlets = answer.networks[0], answer.outlets
    state = steady(network, outlets, 40e-6)
    flow = state.flow[network.tree.outlets]
    lost = state.inlet - outlets.pressure - outlets.resistance * flow
    return flow / 40e-6, np.sort(lost) / MMHG


@pytest.mark.parametrize("seed", seeds(1, 4))
def test_lines_that_wander_in_their_lumen_tell_the_same_flow(a_tree, seed):
    made, (shares, lost) = a_tree
    assert shares == pytest.approx(8 * [1 / 8], rel=0.03)
    random, tree = np.random.default_rng([seed, 3]), made.centerline
    pieces, radii = [], []
    for leaf in tree.leaves.tolist():
        way = tree.ancestry(leaf)
        wave = np.cumsum(random.normal(size=(len(way), 3)), axis=0)
        wave = np.column_stack([np.convolve(x, np.ones(9) / 9, mode="same") for x in wave.T])
        radii.append(tree.inscribed_radius[way])
        pieces.append(tree.points[way] + 0.1 * radii[-1][:, None] * wave / np.abs(wave).max())
    ends = np.cumsum([0, *map(len, pieces)])
    lines = [np.arange(*both) for both in pairwise(ends.tolist())]
    radius = np.concatenate(radii) if seed % 2 else None
    tree = Centerline.from_lines(np.concatenate(pieces), lines, radius)
    again, lost_again = lost_to_outlets(channels_of(made.surface, tree))
    assert again == pytest.approx(8 * [1 / 8], rel=0.03)
    # At forks jets go on in the directions of the lines, which differ.
    assert lost_again == pytest.approx(lost, rel=0.25)


def answer_of(a_fork, flow=40.0, **more):
    channels, right = a_fork
    return FlowModel(channels, known_flow(flow, right=right, **more)).answer()


def test_the_larger_branch_stays_the_first_where_another_power_makes_it_the_smaller_one():
    """Two outlets of 4.6 mm take more than one of 6 mm at the powers 2 and 7/3, less at 3."""
    x = np.linspace(0, 40, 81)
    ways = {-1: [(1, 0, 0)], 0: [(1, 1, 0), (1, -1, 0)], 2: [(1, -1, 1), (1, -1, -1)]}
    channels, size = [], iter((8.0, 6.0, 6.5, 4.6, 4.6))
    for above, directions in ways.items():
        for direction in directions:
            start, at = (channels[above].points[-1], 40) if above >= 0 else (np.zeros(3), 0)
            line, wide = start + np.outer(x, direction), np.full(81, next(size))
            none = np.zeros(81, dtype=np.int64)
            channels.append(Channel(line, at + x, wide, wide, none, x, above))
    first, other = FlowModel(channels, known_flow(40.0)).answer().before["mean"].sides
    assert first.low < 0.5 < first.value
    assert first.low + other.high == pytest.approx(1)


PRESSURES = {"inlet": 30.0, "wedge": 10.0, "split_right": 0.7}


def test_outlets_are_fitted_to_pressures_and_split(a_fork):
    answer = answer_of(a_fork, **PRESSURES)
    moment = answer.before["mean"]
    assert moment.inlet.value == pytest.approx(30.0, rel=1e-5)
    assert answer.sides.names == ("left", "right")
    assert [one.value for one in moment.sides] == pytest.approx([0.3, 0.7], abs=1e-5)
    # Mass, and energy from the inlet to every outlet, by hand.
    network, outlets = answer.networks[0], answer.outlets
    state = steady(network, outlets, 40e-6)
    ends = network.tree.outlets
    assert state.flow[ends].sum() == pytest.approx(40e-6, rel=1e-9)
    for end, resistance in zip(ends, outlets.resistance, strict=True):
        pressure, number = outlets.pressure + resistance * state.flow[end], end
        while number >= 0:
            q = state.flow[number]
            pressure += (network.resistance[number] + network.stenosis[number] * q) * q
            number = network.tree.above[number]
        assert pressure == pytest.approx(state.inlet, rel=1e-9)


@pytest.mark.parametrize("more", [PRESSURES, {}])
def test_svzerod_runs_the_document_unchanged_and_says_the_same(a_fork, more):
    svzerod = pytest.importorskip("svzerod")
    answer = answer_of(a_fork, **more)
    known = answer.known
    network, outlets = answer.networks[0], answer.outlets
    document = json.loads(json.dumps(svzerod_document(network, outlets, known)))
    table = svzerod.simulate(document)
    names = [one["vessel_name"] for one in document["vessels"]]
    assert not any(set(name) & set(", ") for name in names)
    state = steady(network, outlets, 40e-6)
    for name, flow in zip(names, state.flow, strict=True):
        rows = table[table.name == name]
        assert 1e-6 * rows.flow_in.iloc[-1] == pytest.approx(flow, rel=1e-6)
    first = table[table.name == names[0]]
    assert first.pressure_in.iloc[-1] / 10 == pytest.approx(state.inlet, rel=1e-6)
    inlet, flows = solved_by_svzerod(network, outlets, known)
    assert inlet[-1] == pytest.approx(state.inlet, rel=1e-6)
    assert flows[-1] == pytest.approx(state.flow, rel=1e-6)


def half_sine():
    time = np.linspace(0, 0.8, 81)
    flow = 5 + 100 * np.maximum(np.sin(2 * np.pi * time / 0.8), 0)
    flow[-1] = flow[0]
    return Wave(tuple(time.tolist()), tuple(flow.tolist()))


def test_over_a_wave_more_is_lost_than_at_its_mean_and_svzerod_agrees(a_fork):
    pytest.importorskip("svzerod")
    channels, right = a_fork
    lines = [Part("all", np.vstack([channels[0].points, channels[-1].points]))]
    steady_one, slow_one = (
        FlowModel(channels, known_flow(40.0, wave, right=right, **PRESSURES))
        for wave in (None, half_sine())
    )
    at_mean = steady_one.answer(None, lines)
    slow = slow_one.answer(None, lines)
    solved = slow_one.answer(None, lines, solved_by_svzerod)
    assert (slow.is_quasi_steady, solved.is_quasi_steady) == (True, False)
    drops = [one.before["mean"].drops[0].recovered.value for one in (at_mean, slow, solved)]
    # The loss of jets goes with the square of the flow, friction does not.
    assert drops[1] > 1.2 * drops[0]
    assert drops[2] == pytest.approx(drops[1], rel=0.02)
    assert solved.before["mean"].inlet.value == pytest.approx(30.0, rel=0.01)
    assert solved.flows["peak"] > 2.5 * solved.flows["mean"]


def test_over_a_wave_what_is_before_is_solved_once_and_after_for_every_stent(a_fork):
    channels, right = a_fork
    model = FlowModel(channels, known_flow(40.0, half_sine(), right=right, **PRESSURES))
    asked = []

    def solve(network, outlets, known):
        asked.append(network)
        at = np.arange(20) / 20 * known.wave.cycle
        flows = 1e-6 * np.interp(at, known.wave.time, known.wave.flow)
        states = [steady(network, outlets, float(flow)) for flow in flows]
        return np.array([one.inlet for one in states]), np.array([one.flow for one in states])

    first, again = (model.answer(channels, (), solve) for _ in range(2))
    assert asked == [first.networks[0], first.networks[1], again.networks[1]]
    assert first.before == again.before
    assert first.after == again.after


def test_a_solver_that_dies_or_does_not_converge_is_a_sentence(a_fork, monkeypatch):
    answer = answer_of(a_fork, **PRESSURES)
    known = answer.known
    run = "SDFStentLib.flow.svzerod._RUN"
    for code, words in (
        ("import os; os._exit(3)", "exit code 3, and it said: nothing"),
        ("raise RuntimeError('no convergence')", "it said: RuntimeError: no convergence"),
        ("import no_such_package", "ModuleNotFoundError"),
    ):
        monkeypatch.setattr(run, code)
        with pytest.raises(DeploymentError, match=words) as error:
            solved_by_svzerod(answer.networks[0], answer.outlets, known)
        # Its log and what it was asked are kept.
        log = Path(re.search(r"is in (\S+solver\.log)", str(error.value))[1])
        assert log.stat().st_size > 0 or words.endswith("nothing")
        assert json.loads((log.parent / "network.json").read_text(encoding="utf-8"))["vessels"]
        shutil.rmtree(log.parent)


@pytest.mark.parametrize(
    "text", ["41.7", "fast", "4 L", "0mL/s", "-3mL/s", "1.2.3mL/s", "1e9L/min"]
)
def test_a_flow_without_a_unit_or_none_is_refused(text):
    with pytest.raises(InputError, match="flow"):
        flow_value(text)


def test_a_place_in_the_right_branch_lies_in_the_vessel(a_fork):
    channels, right = a_fork
    with pytest.raises(InputError, match="expected a place in the right main branch"):
        FlowModel(channels, known_flow(40.0, right=tuple(10 * np.array(right))))
    with pytest.raises(InputError, match="beyond their junction"):
        FlowModel(channels, known_flow(40.0, right=tuple(channels[0].points[2])))


def test_a_split_needs_sides():
    tube = straight_tube(edge_length=1.2)
    channels = channels_of(tube.surface, tube.centerline)
    with pytest.raises(InputError, match="right branch is known"):
        FlowModel(channels, known_flow(40.0, split_right=0.7))
    assert FlowModel(channels, known_flow(40.0)).answer().before["mean"].sides is None


def write(folder, text):
    path = folder / "wave.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,1\n1,5\n2,2\n3,1\n", "unit of the flow"),
        ("s,mL/s\n0,1\n1,5\n2,2\n4,4\n", "one that closes"),
        ("s,mL/s\n0,1\n1,5\n1,2\n3,1\n", "times that go up"),
        ("s,mL/s\n0,1\n1,x\n2,2\n3,1\n", "rows of two numbers"),
        ("s,mL/s\n0,-1\n1,-5\n2,-2\n3,-1\n", "mean flow is positive"),
        ("", "rows of two numbers"),
    ],
)
def test_a_wave_that_is_none_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        read_wave(write(tmp_path, text))


def test_an_outlet_outside_of_the_vessel_is_refused():
    nowhere = np.full(5, np.nan)
    line = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    branch = np.zeros(5, dtype=np.int64)
    lost = Channel(line, np.arange(5.0), nowhere, nowhere, branch, np.arange(5.0), -1)
    with pytest.raises(InputError, match="a lumen at the outlet near"):
        widths_of([lost])


def test_a_vessel_without_junctions_runs_in_svzerod():
    svzerod = pytest.importorskip("svzerod")
    tube = straight_tube(edge_length=1.2)
    known = known_flow(40.0, inlet=20.0, wedge=8.0)
    answer = FlowModel(channels_of(tube.surface, tube.centerline), known).answer()
    table = svzerod.simulate(svzerod_document(answer.networks[0], answer.outlets, known))
    assert table.pressure_in.iloc[-1] / 1333.22 == pytest.approx(20.0, rel=1e-6)


def opened(tube, middle=20.0, half=9.0):
    """The tube with its narrowing pushed to a diameter of 5.6, as smoothly as a stent does."""
    points = tube.surface.points.copy()
    along = np.abs(points[:, 2] - middle) < half
    radius = np.linalg.norm(points[along, :2], axis=1)
    points[along, :2] *= (np.maximum(radius, 2.8) / np.maximum(radius, 1e-9))[:, None]
    return tube.surface.with_points(points)


@pytest.mark.parametrize("inscribed", [np.nan, 0.0])
def test_a_channel_whose_lumen_is_nowhere_known_is_followed_by_its_sections(inscribed):
    """As of a branch of a voxel or two, that ends in its wall."""
    tube = stenosed_tube(edge_length=1.2)
    (known,) = channels_of(tube.surface, tube.centerline)
    channel = known._replace(inscribed=np.full(len(known.points), inscribed))
    followed = FollowedChannels(tube.surface, tube.centerline, (channel,))
    (after,) = followed.after(tube.centerline, opened(tube))
    np.testing.assert_array_equal(after.inscribed, channel.inscribed)
    (other,) = FollowedChannels(tube.surface, tube.centerline, (known,)).after(
        tube.centerline, opened(tube)
    )
    assert np.nanmax(other.section - known.section) > 1
    np.testing.assert_array_equal(after.section, other.section)


def test_what_no_wall_moved_near_is_as_it_was_and_the_rest_is_as_measured_anew():
    tube = stenosed_tube(edge_length=1.2)
    channels = channels_of(tube.surface, tube.centerline)
    surface = opened(tube)
    (before,), followed = channels, FollowedChannels(tube.surface, tube.centerline, channels)
    assert followed.after(tube.centerline, tube.surface)[0] is before
    for _ in range(2):
        (after,) = followed.after(tube.centerline, surface)
        far = np.abs(before.along - 20) > 16
        for name in ("points", "along", "inscribed", "section"):
            same = getattr(before, name)[far], getattr(after, name)[far]
            assert np.array_equal(*same, equal_nan=True)
        # The plain way: everything is measured anew.
        ways = Line(after.points).directions
        wall = surface.points, surface.triangles
        inscribed = 2 * inscribed_spheres(*wall, after.points, ways).radii
        known = np.isfinite(before.inscribed)
        assert after.inscribed[known] == pytest.approx(inscribed[known], rel=0.02)
        section = equivalent_diameters(*wall, after.points, ways)
        known = np.isfinite(section) & np.isfinite(after.section)
        assert after.section[known] == pytest.approx(section[known], rel=0.005)


def test_a_narrowing_at_an_ostium_costs_from_the_vessel_above_on(a_fork):
    channels, _ = a_fork
    model = FlowModel(channels, known_flow(40.0))
    branch = next(one for one in channels if one.above == 0)
    even = np.full(len(branch.points), 0.5 * np.nanmedian(branch.inscribed))
    narrow = branch._replace(inscribed=even, section=even)
    after = [narrow if one is branch else one for one in channels]
    line = branch.points[3:8]
    lines = [Part("alone", line), Part("from above on", line, 12.0)]
    alone, whole = model.answer(after, lines).after["mean"].drops
    # Its lowest pressure lies below that in the vessel above by what the narrow one's speed holds.
    assert whole.maximal.value > 3 * alone.maximal.value
    # Out of a vessel as narrow, which has twice the flow: the pressure there is low already.
    narrowed = [
        one._replace(inscribed=0 * one.inscribed + even[0], section=even[0] + 0 * one.section)
        for one in channels
    ]
    (drop,) = model.answer(narrowed, lines[1:]).after["mean"].drops
    assert drop.maximal.value >= drop.recovered.value > 0
    assert model.answer(None, [Part("all", branch.points, 1e6)]).before["mean"].drops


def test_a_centerline_that_leaves_the_vessel_before_its_end_is_refused():
    tube = straight_tube(edge_length=1.2)
    (whole,) = channels_of(tube.surface, tube.centerline)
    outside = whole.along > 20.0
    lost = whole._replace(
        inscribed=np.where(outside, np.nan, whole.inscribed),
        section=np.where(outside, np.nan, whole.section),
    )
    with pytest.raises(InputError, match="goes on outside of the surface"):
        FlowModel([lost], known_flow(40.0))


def test_a_line_that_ends_in_the_vessel_is_not_told_to_leave_it_however_narrow_that_is():
    """Stations are 1 mm apart: in a twig of a voxel none is within two diameters of its end."""
    tube = straight_tube(edge_length=1.2)
    points = tube.surface.points * (0.4 / 6.0, 0.4 / 6.0, 1.0)
    (channel,) = channels_of(tube.surface.with_points(points), tube.centerline)
    (widths,) = widths_of([channel])
    assert widths.narrow == pytest.approx(0.4, rel=0.021)  # the chords lie inside of the circle


@pytest.mark.parametrize("beyond", [(0.0, 0.0), (3.0, 0.0)])
def test_a_line_that_goes_on_behind_a_cap_is_refused(beyond):
    """At a station exactly on the cap a sphere has no width: 10^16 others were to lie near."""
    tube = straight_tube(edge_length=1.2)
    end = tube.centerline.points[-1]
    outside = end + np.array([(*beyond, 1.0)]) * np.arange(1, 11)[:, None]
    line = np.vstack([tube.centerline.points, outside])
    channels = channels_of(tube.surface, Centerline.from_lines(line, [np.arange(len(line))]))
    with pytest.raises(InputError, match="goes on outside of the surface"):
        widths_of(channels)
