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

import numpy as np
from numpy.typing import NDArray

from .contact_history import ContactHistory
from .contact_search import ContactSearch
from .front import Front
from .motion import Motion, influence_rates
from .step_rule import StepRule

FRONT_MARGIN = 0.1
"""How far beyond the predicted reach a point still belongs to the front, mm."""

FIELD_INTERVAL = 2.0
"""Growth, mm, after which the field is evaluated anew.

In between it is extrapolated along the direction of motion: the motion follows the gradient, along
which the distance is linear but for the smooth minimum's ripple. Where that is not so, inside a
bend or between two legs of a hairpin, `Motion.is_curved` is set and the field is followed instead.
"""

FOLLOWING_PART = 0.4
"""Longest parts, mm, in which a curved field is followed."""

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
    held = np.flatnonzero(contact)
    held_middle = motion.positions[held] + growth / 2 * motion.direction[held]
    search = ContactSearch(held_middle) if len(held) else None

    above = motion.level - radius
    reach = rule.contact_tolerance + FRONT_MARGIN + growth * (1 - rate)
    members = np.flatnonzero(~contact & (above < reach) & motion.touchable)
    front = Front(motion, rule, members, rate[members])
    if search is not None:
        front.anchored(search, held, motion, rule.influence_distance + 2 * growth)
    front.run(radius, growth)
    hits = front.has_touched

    hits_middle = front.positions[hits] - growth / 2 * motion.direction[members[hits]]
    times = front.contact_radius[hits] - radius
    history = ContactHistory(held_middle, search, hits_middle, times, growth)
    if history.by_the_end is not None:
        motion.resting.wake(history.by_the_end, rule.influence_distance + growth)
    passive = motion.resting.awake & ~contact & (above - growth < rule.influence_distance)
    passive[members] = False
    others = np.flatnonzero(passive)
    mean_rate, end_rate = _passive_rates(
        motion, rule, radius + growth / 2, growth, others, rate[others], history
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
    history: ContactHistory,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean motion per radius over the step, and at its end, of points away from the front."""
    ahead = growth / 2 * rate
    position = motion.positions[others] + ahead[:, None] * motion.direction[others]
    above = motion.level[others] + ahead * motion.slope[others] - middle
    mean, end = history.distances(position, motion.cell[others], rule.influence_distance)
    profiles = rule.influence_distance, rule.falloff, rule.blend
    return influence_rates(above, mean, *profiles), influence_rates(above, end, *profiles)
