"""Radius steps: long ones that resolve contact events, close to the limit, and published ones.

Shrinking the published Euler step to nothing leaves a set of one-dimensional motions along the
field, coupled only through the contact set: a point that is not in contact influences nobody.
The error of a long step is therefore the error of *when* each point comes into contact. So a step
1. lets the few points that may come into contact run ahead in short substeps (the front),
2. then moves all others once, with the contact distance averaged over the contact times.
Second order for the others (values at the middle of the step); see docs/method.md for the measured
error against the converged limit.

The published step, SDFStent, arXiv 2605.22009, algorithms 1 and 2, is Euler with an exact last
partial step. It equals the plain form in the tests: skipping steps without contact, points that
rest and points that did not move changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .contact_search import ContactSearch
from .contact_set import ContactSet, NewContacts
from .front import Front, Step
from .motion import Motion
from .profiles import StepRule

FRONT_MARGIN = 0.1
"""Distance beyond the predicted reach up to which a point still belongs to the front, mm."""

FIELD_INTERVAL = 2.0
"""Growth, mm, after which the field is evaluated anew.

In between it is extrapolated along the direction of motion: the motion follows the gradient, along
which the distance is linear but for the smooth minimum's ripple. Where that is not so, inside a
bend or between two legs of a hairpin, `Motion.is_curved` is set and the field is followed instead.
"""

FOLLOWING_PART = 0.4
"""Longest part, mm, in which a curved field is followed."""

ERROR_SHARE = 0.25
"""Stated error over the difference between two second-order values of one step.

These are the mean rate over the contact times and the trapezoid of both ends. An estimate, no
bound: a quarter of the largest difference of all steps was above the measured distance to the
converged limit in all cases behind the figures of `docs/method.md` but for one point of a preview.
"""

SHORTEST_STEP = 0.1
"""Shortest adapted step, mm."""


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
    contact = ContactSet(motion)
    touching = (motion.level - radius <= rule.contact_tolerance) & motion.touchable
    contact.added(np.flatnonzero(touching), rule.influence_distance + target - radius)
    growth = rule.first_share * rule.step
    evaluated = radius
    has_looked_ahead = False
    # Ends: no step but the last is shorter than 0.1 mm, or the rule's own longest, and settings
    # allow none that is too short to count.
    while target - radius > 1e-9:
        growth = min(growth, target - radius)
        if target - radius - growth < 0.25 * growth:
            growth = target - radius
        step = Step(radius, growth, reach=rule.influence_distance + target - radius)
        error = _event_step(motion, rule, contact, step)
        motion.estimated(error)
        radius += growth
        if radius - evaluated > FIELD_INTERVAL:
            motion.refreshed()
            contact.tied_anew(step.reach)
            evaluated = radius
        yield radius
        if not has_looked_ahead:
            # Only after the first step: that one is short, and a preview wants to show it.
            motion.look_ahead(target - radius)
            has_looked_ahead = True
        factor = np.sqrt(rule.tolerance / max(error, 1e-12))
        growth = float(
            np.clip(growth * np.clip(factor, 0.5, 2), min(SHORTEST_STEP, rule.step), rule.step)
        )


def _event_step(motion: Motion, rule: StepRule, contact: ContactSet, step: Step) -> float:
    """Make one step; return its estimated error, mm."""
    radius, growth, reach = step
    held = np.flatnonzero(contact.is_held)
    above = motion.level - radius
    ahead = rule.contact_tolerance + FRONT_MARGIN + growth * (1 - contact.rate)
    members = np.flatnonzero(~contact.is_held & (above < ahead) & motion.touchable)
    front = Front(motion, rule, contact, members, step)
    front.run()
    hits = members[front.has_touched]

    dragged = _dragged(motion, rule, contact, front, step)
    trapezoid = (contact.rate[dragged.numbers] + dragged.end_rate) / 2
    error = ERROR_SHARE * growth * np.abs(dragged.mean_rate - trapezoid).max(initial=0)

    moved = np.concatenate([held, members, dragged.numbers])
    amount = np.concatenate([np.full(len(held), growth), front.amount, growth * dragged.mean_rate])
    curved = motion.is_curved[moved] & (amount > 0)
    straight = moved[~curved]
    motion.advanced(straight, amount[~curved])
    contact.rate[members] = front.rate
    contact.rate[dragged.numbers] = dragged.end_rate
    contact.nearest[members] = front.nearest
    contact.is_held[hits] = True
    _follow(motion, contact, moved[curved], amount[curved], step)

    reached = radius + growth
    settled = straight[contact.is_held[straight]]
    motion.held_on(settled, reached + rule.contact_tolerance)
    is_inside = motion.level - reached < rule.contact_tolerance
    overtaken = np.flatnonzero(is_inside & ~contact.is_held & motion.touchable)
    motion.advanced(overtaken, reached + rule.contact_tolerance - motion.level[overtaken])
    contact.added(overtaken, reach)
    contact.rate[contact.is_held] = 1
    return float(error)


class _Dragged(NamedTuple):
    """Points that are dragged through a step, and their motion per radius growth."""

    numbers: NDArray[np.int64]
    mean_rate: NDArray[np.float64]
    end_rate: NDArray[np.float64]


def _dragged(
    motion: Motion, rule: StepRule, contact: ContactSet, front: Front, step: Step
) -> _Dragged:
    """Points out of contact and outside of the front that have a contact near enough."""
    radius, growth, reach = step
    drags = front.has_touched & motion.drags[front.members]
    hits = front.members[drags]
    hits_middle = front.positions[drags] - growth / 2 * motion.direction[hits]
    new = NewContacts(hits_middle, front.contact_radius[drags] - radius, growth)
    if new.search is not None:
        motion.resting.wake(new.search, reach)
    asking = motion.resting.awake & ~contact.is_held
    asking[front.members] = False
    others = np.flatnonzero(asking)

    ahead = growth / 2 * contact.rate[others]
    position = ahead[:, None] * motion.direction.take(others, axis=0)
    position += motion.positions.take(others, axis=0)
    before = np.minimum(contact.compared(others, position, growth / 2), reach)
    end = before
    if new.search is not None:
        distance, nearest = new.search.nearest(position, reach)
        closer = np.flatnonzero(distance < before)
        contact.nearest[others[closer]] = hits[nearest[closer]]
        end = np.minimum(before, distance)

    above = motion.level[others] + ahead * motion.slope[others] - (radius + growth / 2)
    near = (end < rule.influence_distance) & (above - growth < rule.influence_distance)
    mean = np.minimum(end, rule.influence_distance)
    if new.search is not None:
        nearer = np.flatnonzero(near & (end < before))
        mean[nearer] += new.excess(
            position[nearer],
            motion.cell[others[nearer]],
            np.minimum(before[nearer], rule.influence_distance),
        )
    return _Dragged(
        others[near], rule.rates(above[near], mean[near]), rule.rates(above[near], end[near])
    )


def _follow(
    motion: Motion,
    contact: ContactSet,
    where: NDArray[np.int64],
    amount: NDArray[np.float64],
    step: Step,
) -> None:
    """Move points along a curved field in short parts, pushing out those that fall inside."""
    parts = int(np.ceil(step.growth / FOLLOWING_PART - 1e-9)) if len(where) else 0
    is_held = contact.is_held[where]
    for part in range(parts):
        inside = step.radius + step.growth * part / parts - motion.level[where]
        push = amount / parts + np.where(is_held, np.maximum(inside, 0), 0)
        ahead = push[:, None] * motion.direction.take(where, axis=0)
        motion.moved_to(where, motion.positions.take(where, axis=0) + ahead)


def published_steps(motion: Motion, rule: StepRule, start: float, target: float) -> Iterator[float]:
    """Grow the stent from one radius to another; yields the radius after every step with motion.

    Parameters
    ----------
    motion : Motion
        Changed in place.
    rule : StepRule
        Distances and profiles.
    start, target : float
        Radii, mm. Steps end at `start + i * step`, the last one at the target.
    """
    count = int(np.ceil(round((target - start) / rule.step, 9)))
    touchable_level = np.where(motion.touchable, motion.level, np.inf)
    nearest = touchable_level.min(initial=np.inf)
    first = max(0, int(np.floor((nearest - rule.contact_tolerance - start) / rule.step)))
    for index in range(first, count):
        radius = start + index * rule.step
        reached = min(start + (index + 1) * rule.step, target)
        if _euler_step(motion, rule, radius, reached - radius):
            yield reached


def _euler_step(motion: Motion, rule: StepRule, radius: float, growth: float) -> bool:
    """Move every influenced point once; False when the stent touches nothing."""
    above = motion.level - radius
    contact = (above < rule.contact_tolerance) & motion.touchable
    if not contact.any():
        return False
    search = ContactSearch(motion.positions[contact], is_exact=True)
    motion.resting.wake(search, rule.influence_distance)
    near = motion.resting.awake & (above < rule.influence_distance)

    amount = np.zeros(len(above))
    near_contact = np.zeros(len(above))
    free = np.flatnonzero(near & ~contact)
    near_contact[free], _ = search.nearest(motion.positions[free], rule.influence_distance)
    active = np.flatnonzero(near | contact)
    amount[active] = growth * rule.rates(above[active], near_contact[active])
    inside = active[above[active] < 0]
    inside = inside[np.isfinite(near_contact[inside])]
    amount[inside] -= above[inside]

    moving = np.flatnonzero(amount > 0)
    displacement = amount[moving, None] * motion.direction[moving]
    motion.moved_to(moving, motion.positions[moving] + displacement)
    return True
