"""Parts of the motion: patch, contacts, smooth minimum and profiles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import PlainField, smin

from SDFStentLib.deformation import BLENDS, FALLOFFS
from SDFStentLib.deformation.contact_search import FEW
from SDFStentLib.deformation.contact_set import PHASES, NewContacts
from SDFStentLib.deformation.wall_around import FOREIGN, own_share
from SDFStentLib.geometry import smooth_minimum

# Who is nearest among the points in contact, as they come, and in the mean of a step.


def cloud(count, seed=0, spread=5.0):
    return np.random.default_rng(seed).normal(size=(count, 3)) * spread + [300, -200, 100]


def new_contacts(points, times, growth=0.8):
    return NewContacts(points, np.asarray(times, dtype=float), growth)


def nearest_distance(asking, points, bound=6.5):
    return np.minimum(np.linalg.norm(asking[:, None] - points, axis=2).min(axis=1), bound)


@pytest.mark.parametrize(("count", "parts"), [(1, np.inf), (FEW, np.inf), (120, PHASES)])
def test_the_mean_is_that_of_the_contacts_one_by_one(count, parts):
    """Against the plain sum over all contact times, one contact after the other."""
    rng = np.random.default_rng(4)
    held, hits, asking = cloud(150), cloud(count, 2), cloud(400, 3)
    times = rng.uniform(0, 0.8, len(hits))
    before = nearest_distance(asking, held)
    near = nearest_distance(asking, hits) < before
    asking, before = asking[near], before[near]
    excess = new_contacts(hits, times).excess(asking, np.arange(len(asking)), before)

    current, total, last = before, np.zeros(len(asking)), 0.0
    for number in np.argsort(times):
        total += current * (times[number] - last)
        last = times[number]
        current = np.minimum(current, np.linalg.norm(asking - hits[number], axis=1))
    total += current * (0.8 - last)
    # Of many contacts only the nearest in each part of the step counts: the others' drop comes at
    # most one part late. Few are exact.
    late = excess - (total / 0.8 - current)
    assert late.min() > -1e-9
    assert (late <= (before - current) / parts + 1e-9).all()


# The smooth minimum and the profiles, against their closed forms.


DISTANCE = st.floats(-20, 20, allow_nan=False)
WIDTH = st.floats(0.01, 3)
ROUNDING = 1e-12  # mm: a few operations on numbers below 20


def pair(first, second):
    return np.array([first], dtype=float), np.array([second], dtype=float)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(DISTANCE, DISTANCE, st.one_of(st.just(0.0), WIDTH))
def test_the_smooth_minimum_is_the_papers_kernel_form_with_its_chain_rule(first, second, k):
    a, b = pair(first, second)
    along_first, along_second = np.array([[1.0, 0, 0]]), np.array([[0.0, 1, 0]])
    plain = smin(PlainField(a, along_first), PlainField(b, along_second), k)
    value, share = smooth_minimum(a, b, k)
    assert value[0] == pytest.approx(plain.distance[0], abs=ROUNDING)
    gradient = share[0] * along_first[0] + (1 - share[0]) * along_second[0]
    np.testing.assert_allclose(gradient, plain.gradient[0], atol=1e-10)


@pytest.mark.parametrize("name", [*FALLOFFS, *BLENDS])
def test_every_profile_falls_monotonically_from_one_to_zero(name):
    profile = {**FALLOFFS, **BLENDS}[name]
    values = profile(np.linspace(0, 1, 1001))
    # One rounding of a sum of terms near 1.
    assert values[0] == pytest.approx(1, abs=1e-15)
    assert values[-1] == pytest.approx(0, abs=1e-15)
    assert (np.diff(values) < 1e-15).all()


# Which wall is that of the stented lumen: by degrees, so that no hair's breadth decides.


def best_of_all_ways(count, sides, tissue, nearest):
    """By trying: the least tissue up to which vertices hang together with the nearest."""
    worst = np.full(count, np.inf)
    for limit in sorted(set(tissue[tissue < FOREIGN]), reverse=True):
        reached = {nearest}
        for _ in range(count):
            for a, b in sides:
                if tissue[a] <= limit and tissue[b] <= limit and {a, b} & reached:
                    reached |= {a, b}
        worst[list(reached)] = limit
    return 1 - np.minimum(worst / FOREIGN, 1)


@given(st.integers(0, 2**32 - 1))
def test_the_share_is_that_of_the_best_of_all_ways(seed):
    rng = np.random.default_rng(seed)
    count = 12
    sides = rng.integers(0, count, (16, 2))
    tissue = rng.choice([0, 0, 0.2 * FOREIGN, 0.7 * FOREIGN, 3 * FOREIGN], count)
    tissue[3] = 0
    expected = best_of_all_ways(count, sides, tissue, 3)
    np.testing.assert_allclose(own_share(sides, tissue, 3), expected)
