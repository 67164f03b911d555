"""Who is nearest among the points in contact, as they come, and in the mean of a step."""

from __future__ import annotations

import numpy as np
import pytest

from SDFStentLib.deformation.contact_search import FEW, ContactSearch
from SDFStentLib.deformation.contact_set import ContactSet
from SDFStentLib.deformation.motion import Motion
from SDFStentLib.deformation.new_contacts import PHASES, NewContacts
from SDFStentLib.field.capsule_chain import CapsuleChain


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


def new_contacts(points, times, growth=0.8):
    return NewContacts(points, np.asarray(times, dtype=float), growth)


def nearest_distance(asking, points, bound=6.5):
    return np.minimum(np.linalg.norm(asking[:, None] - points, axis=2).min(axis=1), bound)


def test_a_single_new_contact_counts_from_its_own_time():
    new = new_contacts(np.array([[0.0, 0, 1]]), [0.2])
    excess = new.excess(np.array([[0.0, 0, 0]]), np.arange(1), np.array([4.0]))
    # 4 mm for a quarter of the step, then 1 mm.
    np.testing.assert_allclose(excess, [4 * 0.25 + 1 * 0.75 - 1], atol=1e-12)


def test_without_new_contacts_there_is_nothing_to_search():
    assert new_contacts(np.empty((0, 3)), []).search is None


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


def tube_motion(seed=3):
    """Points round a straight stent, some of which are held by it."""
    rng = np.random.default_rng(seed)
    angle, along, away = rng.uniform([0, 0, 2], [2 * np.pi, 30, 6], (800, 3)).T
    points = np.column_stack([away * np.cos(angle), away * np.sin(angle), along])
    chain = CapsuleChain.along([[0.0, 0, 0], [0, 0, 30]])
    return Motion(chain, points, np.ones(len(points), dtype=bool))


def assert_tied_to_the_nearest(contact, motion, reach):
    held, waiting = np.flatnonzero(contact.is_held), np.flatnonzero(~contact.is_held)
    apart = np.linalg.norm(motion.positions[waiting][:, None] - motion.positions[held], axis=2)
    near = apart.min(axis=1) < reach
    nearest = held[apart.argmin(axis=1)]
    np.testing.assert_array_equal(contact.nearest[waiting[near]], nearest[near])
    assert (contact.nearest[waiting[~near]] == -1).all()
    tied = waiting[near]
    distance = contact.distance(tied, motion.positions[tied], 0)
    np.testing.assert_allclose(distance, apart.min(axis=1)[near], atol=1e-12)


@pytest.mark.parametrize("reach", [3.0, 40.0])
def test_every_point_is_tied_to_the_nearest_contact_as_contacts_come(reach):
    motion = tube_motion()
    contact = ContactSet(motion)
    order = np.argsort(motion.level)
    for part in (order[:1], order[1:30], order[30:200], order[:0]):
        contact.added(part, reach)
        assert_tied_to_the_nearest(contact, motion, reach)


def test_ties_are_found_anew_after_points_have_moved_past_each_other():
    motion = tube_motion()
    contact = ContactSet(motion)
    contact.added(np.argsort(motion.level)[:100], 40.0)
    moving = np.flatnonzero(~contact.is_held)[::7]
    motion.moved_to(moving, motion.positions[moving] + [0, 0, 4.0])
    with pytest.raises(AssertionError):
        assert_tied_to_the_nearest(contact, motion, 40.0)
    contact.tied_anew(40.0)
    assert_tied_to_the_nearest(contact, motion, 40.0)


def test_a_tie_is_measured_to_where_the_contact_will_be():
    motion = tube_motion()
    contact = ContactSet(motion)
    contact.added(np.argsort(motion.level)[:1], 40.0)
    held, free = int(np.argmin(motion.level)), np.flatnonzero(~contact.is_held)[:5]
    later = motion.positions[held] + 0.3 * motion.direction[held]
    expected = np.linalg.norm(motion.positions[free] - later, axis=1)
    np.testing.assert_allclose(
        contact.distance(free, motion.positions[free], 0.3), expected, atol=1e-12
    )


def test_a_tie_of_a_neighbor_is_taken_over_where_it_is_nearer():
    motion = tube_motion()
    contact = ContactSet(motion)
    contact.added(np.argsort(motion.level)[:100], 40.0)
    waiting = contact.waiting()
    positions = motion.positions[waiting]
    right = contact.distance(waiting, positions, 0)
    # One of three points has lost its tie to some contact far away.
    contact.nearest[waiting[::3]] = np.flatnonzero(contact.is_held)[0]
    lost = contact.distance(waiting, positions, 0)
    found = contact.compared(waiting, positions, 0)
    assert (found <= lost).all()
    assert (found >= right - 1e-12).all()
    assert (found - right).mean() < 0.1 * (lost - right).mean()
