"""The published radius step: Euler, with an exact last partial step.

Source: SDFStent, arXiv 2605.22009, algorithms 1 and 2. Equal to the plain form in the tests; what
is left out (steps without contact, points that rest, points that did not move) changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .contact_search import ContactSearch
from .motion import Motion
from .step_rule import StepRule


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
