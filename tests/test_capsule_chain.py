"""The distance field of a stent, against the plain fold of the paper and closed forms."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from deployment_cases import ANATOMIES, AXES, anatomy_case
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import PlainField
from oracle import field as fold_from_the_distal_end

from SDFStentLib.field import FOLDS, CapsuleChain, Field

EXACT = 1e-9  # mm: what the issue demands; rounding leaves 1e-13


def points_round(chain, count=400, seed=1, near=12.0):
    """Points near the axis, exactly on it, on its nodes, at its ends and far away."""
    rng = np.random.default_rng(seed)
    nodes = chain.nodes
    along = rng.uniform(0, 1, count)[:, None]
    pick = rng.integers(0, len(nodes) - 1, count)
    on_axis = nodes[pick] + along * (nodes[pick + 1] - nodes[pick])
    away = rng.normal(size=(count, 3))
    away *= (rng.uniform(0, near, count) / np.linalg.norm(away, axis=1))[:, None]
    ends = nodes[[0, -1]].repeat(20, axis=0) + rng.normal(size=(40, 3))
    far = nodes.mean(axis=0) + 200 * rng.normal(size=(30, 3))
    return np.concatenate([on_axis + away, on_axis[:30], nodes, ends, far])


def plain_field(points, chain):
    """By the paper from the distal end; from both ends the mean of it and of the axis reversed."""
    nodes, k = chain.nodes, chain.smoothing_width
    distal = fold_from_the_distal_end(points, nodes, k)
    if chain.fold == "distal":
        return distal
    proximal = fold_from_the_distal_end(points, nodes[::-1], k)
    return PlainField(*((one + other) / 2 for one, other in zip(distal, proximal, strict=True)))


def assert_equals_the_plain_fold(chain, points):
    for fold in FOLDS:
        assert_field_equals_the_plain_one(replace(chain, fold=fold), points)


def assert_field_equals_the_plain_one(chain, points):
    plain = plain_field(points, chain)
    field = chain.field(points)
    # The engine subtracts squares of up to (100 mm)^2: rounding of 1e-12 mm^2, hence of
    # 1e-12 / distance in the distance itself and, on the axis, of its root. No wall is there.
    off_axis = chain.axis_distance(points) > 1e-3
    np.testing.assert_allclose(
        field.distance[off_axis], plain.distance[off_axis], rtol=0, atol=EXACT
    )
    np.testing.assert_allclose(field.distance, plain.distance, rtol=0, atol=1e-6)
    # On the axis the direction is undefined, and next to it the quotient of two roundings.
    slope = np.linalg.norm(plain.gradient, axis=1)
    np.testing.assert_allclose(field.slope[off_axis], slope[off_axis], rtol=0, atol=1e-8)
    # Opposite pulls nearly cancel between the legs of a hairpin; there the unit vector amplifies
    # rounding by one over the slope.
    steep = off_axis & (slope > 1e-3)
    np.testing.assert_allclose(
        field.direction[steep], plain.gradient[steep] / slope[steep, None], rtol=0, atol=1e-8
    )


@pytest.mark.parametrize("k", [0.0, 0.4, 1.5])
@pytest.mark.parametrize("name", list(AXES))
def test_the_field_is_the_plain_fold_on_every_axis(name, k):
    chain = CapsuleChain.along(AXES[name], smoothing_width=k)
    assert_equals_the_plain_fold(chain, points_round(chain))


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.2, 0.4, 2.0]), st.integers(2, 40))
def test_the_field_is_the_plain_fold_on_random_walks_that_cross_themselves(seed, k, count):
    rng = np.random.default_rng(seed)
    chain = CapsuleChain(np.cumsum(rng.normal(size=(count, 3)), axis=0), k)
    assert_equals_the_plain_fold(chain, points_round(chain, 60, seed))


def test_the_field_is_exact_far_from_the_origin():
    # A vessel a meter from the origin: squared distances must not lose digits to it.
    shift = np.array([1000.0, -700, 300])
    chain = CapsuleChain.along(AXES["bent"] + shift)
    assert_equals_the_plain_fold(chain, points_round(chain))


@pytest.mark.parametrize("k", [0.0, 0.4])
@pytest.mark.parametrize("name", list(AXES))
def test_the_gradient_is_that_of_the_distance(name, k):
    chain = CapsuleChain.along(AXES[name], smoothing_width=k)
    points = points_round(chain, 150, near=8)
    away = chain.axis_distance(points)
    points = points[(away > 0.5) & (away < 20)]
    h = 1e-5
    field = chain.field(points)
    quotient = np.stack(
        [
            (chain.field(points + step).distance - chain.field(points - step).distance) / (2 * h)
            for step in h * np.eye(3)
        ],
        axis=1,
    )
    error = np.abs(quotient - field.slope[:, None] * field.direction).max(axis=1)
    # Curvature 1/(4k) and 1/distance leave h of error; a joint of the piecewise quadratic, or a
    # crease of the hard minimum, between two samples may spoil a few points.
    assert np.quantile(error, 0.95) < 1e-4
    if k:
        assert error.max() < 1e-4


def test_the_distance_to_one_capsule_is_known_in_closed_form():
    chain = CapsuleChain(np.array([[0.0, 0, 0], [0, 0, 10]]))
    points = np.array([[3.0, 4, 5], [3, 0, -4], [0, 5, 22]])
    np.testing.assert_allclose(chain.field(points).distance, [5, 5, 13], atol=1e-13)
    field = chain.field(points)
    expected = [[0.6, 0.8, 0], [0.6, 0, -0.8], [0, 5 / 13, 12 / 13]]
    np.testing.assert_allclose(field.direction, expected, atol=1e-13)
    np.testing.assert_allclose(chain.axis_distance(points), [5, 5, 13], atol=1e-13)


def test_the_axis_distance_is_that_of_every_segment_tried():
    from oracle import capsule_distance

    for axis in AXES.values():
        chain = CapsuleChain.along(axis)
        points = points_round(chain)
        distances = [capsule_distance(points, a, b)[0] for a, b in pairwise(chain.nodes)]
        # On the axis squares cancel; see assert_equals_the_plain_fold.
        nearest = np.min(distances, axis=0)
        off_axis = nearest > 1e-3
        found = chain.axis_distance(points)
        np.testing.assert_allclose(found[off_axis], nearest[off_axis], rtol=0, atol=EXACT)
        np.testing.assert_allclose(found, nearest, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", list(ANATOMIES))
def test_an_axis_the_other_way_round_has_the_same_nodes_and_field_to_the_last_bit(data_dir, name):
    case = anatomy_case(data_dir, name, 30, 40)
    there, back = CapsuleChain.along(case.axis), CapsuleChain.along(case.axis[::-1])
    np.testing.assert_array_equal(back.nodes, there.nodes[::-1])
    for one, other in zip(there.field(case.points), back.field(case.points), strict=True):
        np.testing.assert_array_equal(one, other)
    distal = replace(there, fold="distal"), replace(back, fold="distal")
    apart = np.abs(distal[0].field(case.points).distance - distal[1].field(case.points).distance)
    assert apart.max() > 1e-3


def windowed(chain, points, near):
    """The field from windows round the given nodes, in the order that keeps them together."""
    order = np.argsort(near, kind="stable")
    field = chain.folding.at(points[order], near[order])
    back = np.argsort(order)
    return Field(field.distance[back], field.direction[back], field.slope[back])


@pytest.mark.parametrize("fold", FOLDS)
@pytest.mark.parametrize("name", ["hairpin", "helix"])
def test_a_wrong_guess_of_the_nearest_node_costs_time_and_nothing_else(name, fold):
    # Points must prove their window: those with a window at the other end are folded again.
    chain = CapsuleChain.along(AXES[name], fold=fold)
    points = points_round(chain, 3000)
    points = points[chain.axis_distance(points) > 1e-3]
    guess = np.random.default_rng(3).integers(0, len(chain.nodes), len(points)).astype(np.int32)
    whole, part = chain.field(points), windowed(chain, points, guess)
    np.testing.assert_allclose(part.distance, whole.distance, atol=1e-11)
    order = np.argsort(guess, kind="stable")
    true = chain.folding.axis_distance(points[order], guess[order])
    np.testing.assert_allclose(true, chain.axis_distance(points[order]), atol=1e-11)
