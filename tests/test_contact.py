"""Who is nearest among the points in contact, and how far they are in the mean of a step."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.contact_history import PHASES, ContactHistory
from SDFStentLib.contact_search import FEW, ContactSearch


def cloud(count, seed=0, spread=5.0):
    return np.random.default_rng(seed).normal(size=(count, 3)) * spread + [300, -200, 100]


@pytest.mark.parametrize("count", [1, 2, FEW, FEW + 1, 500])
@pytest.mark.parametrize("is_exact", [False, True])
def test_the_nearest_point_is_found_by_comparison_and_by_tree(count, is_exact):
    contact, asking = cloud(count), cloud(3000, 1)
    apart = np.linalg.norm(asking[:, None] - contact, axis=2)
    distance, number = ContactSearch(contact, is_exact=is_exact).nearest(asking, np.inf)
    np.testing.assert_allclose(distance, apart.min(axis=1), atol=1e-9)
    np.testing.assert_array_equal(number, apart.argmin(axis=1))


@pytest.mark.parametrize("count", [FEW, 500])
def test_what_lies_beyond_the_bound_is_said_to_be_far(count):
    contact, asking = cloud(count), cloud(2000, 1, spread=20)
    apart = np.linalg.norm(asking[:, None] - contact, axis=2).min(axis=1)
    distance, _ = ContactSearch(contact).nearest(asking, 4.0)
    near = apart < 4
    np.testing.assert_allclose(distance[near], apart[near], atol=1e-9)
    assert (distance[~near] >= 4).all()


def history(held, hits, times, growth=0.8):
    search = ContactSearch(held) if len(held) else None
    return ContactHistory(held, search, hits, np.asarray(times, dtype=float), growth)


def test_a_single_new_contact_counts_from_its_own_time():
    places = np.array([[0.0, 0, 0], [0, 0, 9]])
    found = history(np.array([[4.0, 0, 0]]), np.array([[0.0, 0, 1]]), [0.2])
    mean, end = found.distances(places, np.arange(2), 6.5)
    # The first place: 4 mm for a quarter of the step, then 1 mm. The second: out of reach of both.
    np.testing.assert_allclose(end, [1, 6.5], atol=1e-12)
    np.testing.assert_allclose(mean, [4 * 0.25 + 1 * 0.75, 6.5], atol=1e-12)


def test_without_new_contacts_the_mean_is_the_distance():
    held = cloud(200)
    mean, end = history(held, np.empty((0, 3)), []).distances(cloud(100, 1), np.arange(100), 6.5)
    np.testing.assert_array_equal(mean, end)


def test_without_any_contact_everything_is_at_the_bound():
    found = history(np.empty((0, 3)), np.empty((0, 3)), [])
    assert found.by_the_end is None
    mean, end = found.distances(cloud(10), np.arange(10), 6.5)
    assert (mean == 6.5).all()
    assert (end == 6.5).all()


@pytest.mark.parametrize(("count", "parts"), [(1, np.inf), (FEW, np.inf), (120, PHASES)])
def test_the_mean_is_that_of_the_contacts_one_by_one(count, parts):
    """Against the plain sum over all contact times, one contact after the other."""
    rng = np.random.default_rng(4)
    held, hits, asking = cloud(150), cloud(count, 2), cloud(400, 3)
    times = rng.uniform(0, 0.8, len(hits))
    mean, end = history(held, hits, times).distances(asking, np.arange(400), 6.5)

    current = np.minimum(np.linalg.norm(asking[:, None] - held, axis=2).min(axis=1), 6.5)
    total, last = np.zeros(len(asking)), 0.0
    for number in np.argsort(times):
        total += current * (times[number] - last)
        last = times[number]
        current = np.minimum(current, np.linalg.norm(asking - hits[number], axis=1))
    total += current * (0.8 - last)
    np.testing.assert_allclose(end, current, atol=1e-9)
    # Of many contacts only the nearest in each part of the step counts: the others' drop comes at
    # most one part late. Few are exact.
    late = mean - total / 0.8
    assert late.min() > -1e-9
    assert (late <= (6.5 - end) / parts + 1e-9).all()


def test_neighbors_share_which_new_contact_is_near_but_not_how_far_it_is():
    rng = np.random.default_rng(5)
    held, hits = cloud(150), cloud(120, 2)
    times = rng.uniform(0, 0.8, len(hits))
    centres = cloud(300, 3)
    asking = np.repeat(centres, 4, axis=0) + rng.uniform(-0.2, 0.2, (1200, 3))
    found = history(held, hits, times)
    own, own_end = found.distances(asking, np.arange(1200), 6.5)
    shared, shared_end = found.distances(asking, np.repeat(np.arange(300), 4), 6.5)
    np.testing.assert_array_equal(own_end, shared_end)
    # A neighbor's nearest contact is farther by less than twice the way to the neighbor.
    assert np.abs(shared - own).max() < 2 * 0.4
    assert np.abs(shared - own).mean() < 0.02
