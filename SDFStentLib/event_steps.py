"""Radius steps that resolve contact events: long steps, close to the converged limit.

Shrinking the published Euler step to nothing leaves a set of one-dimensional motions along the
field, coupled only through the contact set: a point that is not in contact influences nobody.
The error of a long step is therefore the error of *when* each point comes into contact. So a step
1. lets the few points that may come into contact run ahead in short substeps (the front),
2. then moves all others once, with the contact distance averaged over the contact times.
Second order for the others (values at the middle of the step); see docs/method.md for the measured
error against the converged limit.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .motion import Motion, contact_tree, influence_rates
from .step_rule import StepRule
from .validation import Points

SUBSTEP = 0.05
"""Substep of the front, mm."""

FRONT_MARGIN = 0.1
"""How far beyond the predicted reach a point still belongs to the front, mm."""

PHASES = 4
"""Parts of a step whose contact sets are told apart when the contact distance is averaged."""

FIRST_STEP = 0.25
"""Step after first contact, mm: before it no rate is known to predict with."""

SHORTEST_STEP = 0.1


class Front(NamedTuple):
    """Points that may come into contact during a step, as they are at its end."""

    members: NDArray[np.int64]
    positions: Points
    level: NDArray[np.float64]
    rate: NDArray[np.float64]
    contact_radius: NDArray[np.float64]
    """Stent radius at which each came into contact, mm; infinite for those that did not."""


def event_steps(motion: Motion, rule: StepRule, start: float, target: float) -> Iterator[float]:
    """Grow the stent from one radius to another; yields the radius after every step.

    Parameters
    ----------
    motion : Motion
        Changed in place.
    rule : StepRule
        `step` is the longest step, `tolerance` the largest estimated error of one.
    start, target : float
        Radii, mm; the last step ends at the target.
    """
    nearest = np.where(motion.touchable, motion.level, np.inf).min(initial=np.inf)
    radius = max(start, nearest - rule.contact_tolerance)
    contact = (motion.level - radius <= rule.contact_tolerance) & motion.touchable
    rate = contact.astype(np.float64)
    growth = min(FIRST_STEP, rule.step)
    while target - radius > 1e-9:
        growth = min(growth, target - radius)
        if target - radius - growth < 0.25 * growth:
            growth = target - radius
        error = _event_step(motion, rule, radius, growth, contact, rate)
        radius += growth
        yield radius
        factor = np.sqrt(rule.tolerance / max(error, 1e-12))
        growth = float(np.clip(growth * min(max(factor, 0.5), 2), SHORTEST_STEP, rule.step))


def _event_step(
    motion: Motion,
    rule: StepRule,
    radius: float,
    growth: float,
    contact: NDArray[np.bool_],
    rate: NDArray[np.float64],
) -> float:
    """One step; `contact` and `rate` are updated in place. Returns the estimated error, mm."""
    middle = radius + growth / 2
    held = np.flatnonzero(contact)
    held_middle = motion.positions[held] + growth / 2 * motion.direction[held]
    tree = contact_tree(held_middle) if len(held) else None
    if tree is not None:
        motion.resting.wake(tree, rule.influence_distance + growth)

    above = motion.level - radius
    reach = rule.contact_tolerance + FRONT_MARGIN + growth * (1 - rate)
    members = np.flatnonzero(~contact & (above < reach) & motion.touchable)
    front = _run_ahead(motion, rule, radius, growth, members, tree, held)
    hits = np.isfinite(front.contact_radius)
    if hits.any():
        motion.resting.wake(contact_tree(front.positions[hits]), rule.influence_distance + growth)

    passive = motion.resting.awake & ~contact & (above - growth < rule.influence_distance)
    passive[members] = False
    others = np.flatnonzero(passive)
    mean_rate, end_rate = _passive_rates(
        motion, rule, middle, growth, others, rate[others], tree, front
    )
    error = growth / 2 * np.abs(end_rate - rate[others]).max(initial=0) * 0.1

    moved = np.concatenate([held, members, others[mean_rate > 0]])
    positions = np.concatenate(
        [
            held_middle + growth / 2 * motion.direction[held],
            front.positions,
            (motion.positions[others] + (growth * mean_rate)[:, None] * motion.direction[others])[
                mean_rate > 0
            ],
        ]
    )
    rate[members] = front.rate
    rate[others] = end_rate
    motion.moved_to(moved, positions)
    reached = radius + growth
    contact[members[hits]] = True
    contact |= (motion.level - reached < rule.contact_tolerance) & motion.touchable
    rate[contact] = 1
    motion.snapped(np.flatnonzero(contact), reached + rule.contact_tolerance)
    return float(error)


def _run_ahead(
    motion: Motion,
    rule: StepRule,
    radius: float,
    growth: float,
    members: NDArray[np.int64],
    tree: Any,
    held: NDArray[np.int64],
) -> Front:
    """Move the front through the step in substeps, with every contact at its own radius."""
    position = motion.positions[members].copy()
    level = motion.level[members].copy()
    direction, slope = motion.direction[members], motion.slope[members]
    contact_radius = np.full(len(members), np.inf)
    rate = np.zeros(len(members))
    if not len(members):
        return Front(members, position, level, rate, contact_radius)

    # The nearest contact point of every member: a place at the start radius and its velocity.
    anchor = np.full((len(members), 3), np.inf)
    velocity = np.zeros((len(members), 3))
    if tree is not None:
        bound = rule.influence_distance + 2 * growth
        distance, nearest = tree.query(position, distance_upper_bound=bound)
        found = np.flatnonzero(np.isfinite(distance))
        nearest = held[nearest[found]]
        anchor[found] = motion.positions[nearest]
        velocity[found] = motion.direction[nearest]

    count = max(1, int(np.ceil(growth / SUBSTEP - 1e-9)))
    substep = growth / count
    touching = np.zeros(len(members), dtype=bool)
    for index in range(count):
        elapsed = index * substep
        above = level - (radius + elapsed)
        apart = np.linalg.norm(position - anchor - elapsed * velocity, axis=1)
        rate = influence_rates(above, apart, rule.influence_distance, rule.falloff, rule.blend)
        rate[touching] = 1
        short = above + (rate * slope - 1) * substep - rule.contact_tolerance
        hits = (short < 0) & ~touching
        amount = rate * substep
        # A point that is overtaken ends the substep on the stent.
        onto_stent = substep + rule.contact_tolerance - above
        amount[hits] = np.maximum(onto_stent, amount)[hits]
        position += amount[:, None] * direction
        level += amount * slope
        closing = np.maximum(substep * (1 - rate[hits] * slope[hits]), 1e-12)
        used = np.clip(1 + short[hits] / closing, 0, 1)
        contact_radius[hits] = radius + elapsed + used * substep
        touching |= hits
        level[touching] = radius + elapsed + substep + rule.contact_tolerance
        _hand_over(position, direction, hits, ~touching, elapsed + substep, anchor, velocity)
    return Front(members, position, level, rate, contact_radius)


def _hand_over(
    position: Points,
    direction: Points,
    hits: NDArray[np.bool_],
    waiting: NDArray[np.bool_],
    elapsed: float,
    anchor: Points,
    velocity: Points,
) -> None:
    """Let waiting points that are now nearer to a new contact point follow that one."""
    if not hits.any() or not waiting.any():
        return
    sources = np.flatnonzero(hits)
    receivers = np.flatnonzero(waiting)
    old = np.linalg.norm(position[receivers] - anchor[receivers] - elapsed * velocity[receivers],
                         axis=1)  # fmt: skip
    new, nearest = contact_tree(position[sources]).query(position[receivers])
    closer = new < old
    receivers, nearest = receivers[closer], sources[nearest[closer]]
    velocity[receivers] = direction[nearest]
    anchor[receivers] = position[nearest] - elapsed * direction[nearest]


def _passive_rates(
    motion: Motion,
    rule: StepRule,
    middle: float,
    growth: float,
    others: NDArray[np.int64],
    rate: NDArray[np.float64],
    tree: Any,
    front: Front,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean motion per radius over the step, and at its end, of points away from the front."""
    ahead = growth / 2 * rate
    position = motion.positions[others] + ahead[:, None] * motion.direction[others]
    above = motion.level[others] + ahead * motion.slope[others] - middle
    apart = np.full(len(others), rule.influence_distance)
    if tree is not None:
        distance, _ = tree.query(position, distance_upper_bound=rule.influence_distance)
        np.minimum(apart, distance, out=apart)

    mean = np.zeros(len(others))
    previous = -np.inf
    half = growth / 2
    for phase in range(PHASES):
        until = middle + growth * ((phase + 0.5) / PHASES - 0.5)
        new = (front.contact_radius > previous) & (front.contact_radius <= until)
        if new.any():
            hits = front.positions[new] - half * motion.direction[front.members[new]]
            distance, _ = contact_tree(hits).query(
                position, distance_upper_bound=rule.influence_distance
            )
            np.minimum(apart, distance, out=apart)
        mean += apart / PHASES
        previous = until
    profiles = rule.influence_distance, rule.falloff, rule.blend
    return influence_rates(above, mean, *profiles), influence_rates(above, apart, *profiles)
