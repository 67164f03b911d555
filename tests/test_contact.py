"""Who is nearest among the points in contact, as they come, and in the mean of a step."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.deformation.contact_search import FEW
from SDFStentLib.deformation.contact_set import PHASES, NewContacts


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


def test_neighbors_share_which_new_contact_is_near_but_not_how_far_it_is():
    rng = np.random.default_rng(5)
    hits, centres = cloud(120, 2), cloud(300, 3)
    times = rng.uniform(0, 0.8, len(hits))
    asking = np.repeat(centres, 4, axis=0) + rng.uniform(-0.2, 0.2, (1200, 3))
    cells = np.repeat(np.arange(300), 4)
    near = nearest_distance(asking, hits) < 6.5
    asking, cells = asking[near], cells[near]
    before = np.full(len(asking), 6.5)
    new = new_contacts(hits, times)
    own = new.excess(asking, np.arange(len(asking)), before)
    shared = new.excess(asking, cells, before)
    assert (own != shared).any()
    # What a neighbor is nearest to is mostly the nearest; where two are as near as each other, it
    # may have come at another time of the same part of the step.
    assert np.abs(shared - own).mean() < 0.02
    assert np.mean(np.abs(shared - own) > 0.1) < 0.02
