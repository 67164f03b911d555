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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .front import SUBSTEPS, Front
from .motion import Motion, contact_tree, influence_rates, nearest_contact
from .step_rule import StepRule
from .validation import Points

FRONT_MARGIN = 0.1
"""How far beyond the predicted reach a point still belongs to the front, mm."""

FIELD_INTERVAL = 2.0
"""Growth, mm, after which the field is evaluated anew.

In between it is extrapolated along the direction of motion: the motion follows the gradient, along
which the distance is linear but for the smooth minimum's ripple. Where that is not so, inside a
bend or between two legs of a hairpin, `Motion.is_curved` is set and the field is followed instead.
"""

FOLLOWING_PART = 0.2
"""Length of the parts, mm, in which a curved field is followed."""

ERROR_SHARE = 0.25
"""Stated error over the difference of two second-order values of one step.

The mean rate over contact times against the trapezoid of both ends. An estimate, no bound: a
quarter of the largest difference of all steps was above the measured distance to the converged
limit with steps up to 0.8 mm, and below it by 0.002 mm once in eight with 1.6 mm
(`benchmarks/step_rules.py`).
"""

FIRST_SHARE = 0.125
"""First step after contact over the longest: before contact no rate is known to predict with."""

SHORTEST_STEP = 0.1
"""Adapted steps are not shorter than this, mm."""


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
    growth = FIRST_SHARE * rule.step
    evaluated = radius
    has_looked_ahead = False
    while target - radius > 1e-9:
        growth = min(growth, target - radius)
        if target - radius - growth < 0.25 * growth:
            growth = target - radius
        error = _event_step(motion, rule, radius, growth, contact, rate)
        motion.estimated_error = max(motion.estimated_error, error)
        radius += growth
        if radius - evaluated > FIELD_INTERVAL:
            motion.refreshed()
            evaluated = radius
        yield radius
        if not has_looked_ahead:
            # Not before the first step: that one is short, and a preview wants to show it.
            motion.look_ahead(target - radius)
            has_looked_ahead = True
        factor = np.sqrt(rule.tolerance / max(error, 1e-12))
        growth = float(
            np.clip(growth * np.clip(factor, 0.5, 2), min(SHORTEST_STEP, rule.step), rule.step)
        )


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
    front = Front(motion, rule, members, rate[members])
    if tree is not None:
        front.anchored(tree, held, motion, rule.influence_distance + 2 * growth)
    front.run(radius, growth)
    hits = front.has_touched
    if hits.any():
        motion.resting.wake(contact_tree(front.positions[hits]), rule.influence_distance + growth)

    passive = motion.resting.awake & ~contact & (above - growth < rule.influence_distance)
    passive[members] = False
    others = np.flatnonzero(passive)
    mean_rate, end_rate = _passive_rates(
        motion, rule, middle, growth, others, rate[others], tree, front
    )
    trapezoid = (rate[others] + end_rate) / 2
    error = ERROR_SHARE * growth * np.abs(mean_rate - trapezoid).max(initial=0)

    moved = np.concatenate([held, members, others])
    amount = np.concatenate([np.full(len(held), growth), front.amount, growth * mean_rate])
    curved = motion.is_curved[moved] & (amount > 0)
    straight = moved[~curved]
    motion.advanced(straight, amount[~curved])
    rate[members] = front.rate
    rate[others] = end_rate
    reached = radius + growth
    contact[members[hits]] = True
    _follow(motion, moved[curved], amount[curved], contact[moved[curved]], radius, growth)

    settled = straight[contact[straight]]
    motion.level[settled] = reached + rule.contact_tolerance
    is_inside = motion.level - reached < rule.contact_tolerance
    overtaken = np.flatnonzero(is_inside & ~contact & motion.touchable)
    motion.advanced(overtaken, reached + rule.contact_tolerance - motion.level[overtaken])
    contact[overtaken] = True
    rate[contact] = 1
    return float(error)


def _follow(
    motion: Motion,
    where: NDArray[np.int64],
    amount: NDArray[np.float64],
    contact: NDArray[np.bool_],
    radius: float,
    growth: float,
) -> None:
    """Move points along a curved field in short parts, pushing out those that fall inside."""
    parts = int(np.ceil(growth / FOLLOWING_PART - 1e-9)) if len(where) else 0
    for part in range(parts):
        inside = radius + growth * part / parts - motion.level[where]
        push = amount / parts + np.where(contact, np.maximum(inside, 0), 0)
        motion.moved_to(where, motion.positions[where] + push[:, None] * motion.direction[where])


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
        distance, _ = nearest_contact(tree, position, rule.influence_distance)
        np.minimum(apart, distance, out=apart)

    ahead_of_middle = growth / 2 * motion.direction[front.members]
    mean = _mean_distance(
        position, apart, front.positions - ahead_of_middle, front.contact_radius - middle, growth
    )
    profiles = rule.influence_distance, rule.falloff, rule.blend
    return influence_rates(above, mean, *profiles), influence_rates(above, apart, *profiles)


def _mean_distance(
    position: Points,
    apart: NDArray[np.float64],
    hits: Points,
    times: NDArray[np.float64],
    growth: float,
) -> NDArray[np.float64]:
    """Distance to the nearest contact point, averaged over a step in which contacts are added.

    Parameters
    ----------
    position : (n, 3) array
        Points asking.
    apart : (n,) array
        Distance to the contact points held from before; in place, the distance at the end.
    hits, times : (k, 3) and (k,) arrays
        Points that may come into contact, and when: from minus to plus half the growth; infinite
        for those that do not.
    """
    mean = apart.copy()
    touched = np.flatnonzero(np.isfinite(times))
    if not len(touched):
        return mean
    hits, times = hits[touched], times[touched]
    bound = float(apart.max(initial=0))
    distance, _ = nearest_contact(contact_tree(hits), position, bound)
    asking = np.flatnonzero(distance < apart)
    position, current = position[asking], apart[asking]
    total = np.zeros(len(asking))
    ends = np.linspace(-growth / 2, growth / 2, SUBSTEPS + 1)[1:-1]
    phase = np.searchsorted(ends, times)
    for index in range(SUBSTEPS):
        new = np.flatnonzero(phase == index)
        if len(new):
            distance, nearest = nearest_contact(contact_tree(hits[new]), position, bound)
            closer = np.flatnonzero(distance < current)
            # From its contact to the end of the step the new point is the nearest, for now.
            remaining = growth / 2 - times[new][nearest[closer]]
            total[closer] += (distance[closer] - current[closer]) * remaining
            current[closer] = distance[closer]
    mean[asking] += total / growth
    apart[asking] = current
    return mean
