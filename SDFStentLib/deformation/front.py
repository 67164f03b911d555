"""The front of a deployment: points that may come into contact within one radius step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import norm
from .contact_search import ContactSearch
from .contact_set import ContactSet
from .motion import Motion
from .profiles import StepRule

SUBSTEPS = 8
"""Substeps of the front in every step: 0.1 mm each in the longest step by default."""


class Step(NamedTuple):
    """A growth step of the stent."""

    radius: float
    """Radius of the stent at the beginning of the step, mm."""
    growth: float
    """The length by which the radius grows, mm."""
    reach: float
    """Distance beyond which a contact does not matter until the end of all steps, mm."""


class Front:
    """Points that run ahead through a step in substeps, each contact at its own radius.

    Attributes
    ----------
    members : (n,) array
        Numbers of the points in the motion.
    positions : (n, 3) array
        Current places of the points, mm.
    amount, rate : (n,) arrays
        Distance each has moved along its direction, mm, and its rate now.
    contact_radius : (n,) array
        Stent radius at which each came into contact, mm; infinite for those that did not.
    nearest : (n,) array
        Number in the motion of the contact point nearest to each, -1 for none within reach.
    """

    def __init__(
        self,
        motion: Motion,
        rule: StepRule,
        contact: ContactSet,
        members: NDArray[np.int64],
        step: Step,
    ) -> None:
        self.members = members
        self.positions = motion.positions.take(members, axis=0)
        self.amount = np.zeros(len(members))
        self.rate = contact.rate[members]
        self.contact_radius = np.full(len(members), np.inf)
        self.nearest = contact.nearest[members]
        self._drags = motion.drags[members]
        self._rule = rule
        self._step = step
        self._level = motion.level[members]
        self._direction = motion.direction.take(members, axis=0)
        self._slope = motion.slope[members]
        # The nearest contact point of each: its place at the start of the step and its velocity.
        self._anchor = motion.positions.take(self.nearest, axis=0)
        self._anchor[self.nearest < 0] = np.inf
        self._velocity = motion.direction.take(self.nearest, axis=0)
        self._touching = np.zeros(len(members), dtype=bool)
        self._late = np.zeros(len(members))

    @property
    def has_touched(self) -> NDArray[np.bool_]:
        """(n,) whether each point has come into contact."""
        return self._touching

    def run(self) -> None:
        """Move the points through the step."""
        radius, growth, _ = self._step
        substep = growth / SUBSTEPS
        for index in range(SUBSTEPS):
            elapsed = index * substep
            dragged = self._updated_rates(radius, elapsed)
            hits, since = self._moved(radius + elapsed, substep, dragged)
            drags = self._drags[hits]
            if drags.any() and not self._touching.all():
                sources = np.flatnonzero(hits)[drags]
                self._hand_over(sources, since[drags], elapsed + substep)
        self._advance(self._updated_rates(radius, growth))

    def _updated_rates(self, radius: float, elapsed: float) -> NDArray[np.float64]:
        """Bring the rates up to date; return the motion missed since the last contacts.

        A new contact point drags its neighbors from the moment of contact, not from the end of
        the substep in which it is noticed.
        """
        rule = self._rule
        above = self._level - (radius + elapsed)
        apart = norm(self.positions - self._anchor - elapsed * self._velocity)
        previous = self.rate
        self.rate = rule.rates(above, apart)
        self.rate[self._touching] = 1
        missed = self._late * (self.rate - previous)
        self._late[:] = 0
        return missed

    def _moved(
        self, radius: float, substep: float, missed: NDArray[np.float64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Move by a substep; return which points came into contact and how long
        before its end, mm."""
        tolerance = self._rule.contact_tolerance
        above = self._level - radius
        amount = missed + self.rate * substep
        short = above + amount * self._slope - substep - tolerance
        hits = (short < 0) & ~self._touching
        # A point that is overtaken ends the substep on the stent.
        amount[hits] = np.maximum(substep + tolerance - above, amount)[hits]
        self._advance(amount)
        closing = np.maximum(substep * (1 - self.rate[hits] * self._slope[hits]), 1e-12)
        since = np.clip(-short[hits] / closing, 0, 1) * substep
        self.contact_radius[hits] = radius + substep - since
        self._touching |= hits
        self._level[self._touching] = radius + substep + tolerance
        return hits, since

    def _hand_over(
        self, sources: NDArray[np.int64], since: NDArray[np.float64], elapsed: float
    ) -> None:
        """Tie waiting points to new contacts that are nearer than their old ones."""
        waiting = np.flatnonzero(~self._touching)
        search = ContactSearch(self.positions.take(sources, axis=0))
        positions = self.positions.take(waiting, axis=0)
        old = positions - self._anchor.take(waiting, axis=0)
        old -= elapsed * self._velocity.take(waiting, axis=0)
        old = np.minimum(norm(old), self._step.reach)
        gap, nearest = search.nearest(positions, old.max(initial=0))
        closer = gap < old
        waiting, nearest = waiting[closer], nearest[closer]
        self._late[waiting] = since[nearest]
        nearest = sources[nearest]
        self.nearest[waiting] = self.members[nearest]
        self._velocity[waiting] = self._direction[nearest]
        self._anchor[waiting] = self.positions[nearest] - elapsed * self._direction[nearest]

    def _advance(self, amount: NDArray[np.float64]) -> None:
        self.positions += amount[:, None] * self._direction
        self._level += amount * self._slope
        self.amount += amount
