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
