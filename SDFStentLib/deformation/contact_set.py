"""Who is in contact with the stent, and which contact each other point is tied to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import norm
from ..validation import Points
from .contact_search import ContactSearch
from .motion import Motion

SHIFTS = (1, -1, 4, -4)
"""Places in the order, before and after a point, of the neighbors whose contacts it tries."""


class ContactSet:
    """Contacts, the rates of all points, and their nearest contacts; in motion order.

    A point keeps its nearest contact until a new one is nearer, or that of a neighbor: both move
    outward side by side, so that among the old ones the nearest stays so, nearly. `tied_anew`
    looks at all of them.

    Attributes
    ----------
    is_held : (n,) bool array
        In contact.
    rate : (n,) array
        Motion per radius growth at the end of the last step.
    nearest : (n,) int array
        The nearest contact; -1 where none is within reach.
    """

    def __init__(self, motion: Motion) -> None:
        count = len(motion.level)
        self.is_held = np.zeros(count, dtype=bool)
        self.rate = np.zeros(count)
        self.nearest = np.full(count, -1, dtype=np.int64)
        self._motion = motion

    def added(self, numbers: NDArray[np.int64], reach: float) -> None:
        """Points have come into contact; tie to them whatever they are nearest to.

        `reach` is the distance, mm, beyond which a contact does not matter until the end.
        """
        self.is_held[numbers] = True
        self.rate[numbers] = 1
        numbers = numbers[self._motion.drags[numbers]]
        if len(numbers):
            search = ContactSearch(self._motion.positions.take(numbers, axis=0))
            self._motion.resting.wake(search, reach)
            waiting = self.waiting()
            positions = self._motion.positions.take(waiting, axis=0)
            distance, nearest = search.nearest(positions, reach)
            closer = distance < np.minimum(self.distance(waiting, positions, 0), reach)
            self.nearest[waiting[closer]] = numbers[nearest[closer]]

    def tied_anew(self, reach: float) -> None:
        """Look for the nearest contact of every point among all contacts."""
        held = np.flatnonzero(self.is_held & self._motion.drags)
        if len(held):
            waiting = self.waiting()
            search = ContactSearch(self._motion.positions.take(held, axis=0))
            positions = self._motion.positions.take(waiting, axis=0)
            distance, nearest = search.nearest(positions, reach)
            near = distance < reach
            self.nearest[waiting[near]] = held[nearest[near]]

    def waiting(self) -> NDArray[np.int64]:
        """Points that a contact may influence and that are in contact themselves not."""
        return np.flatnonzero(self._motion.resting.awake & ~self.is_held)

    def compared(
        self, where: NDArray[np.int64], positions: Points, growth: float
    ) -> NDArray[np.float64]:
        """`distance`, after every point has tried the contacts of its neighbors in order."""
        nearest = self.nearest[where]
        distance = self._distance(nearest, positions, growth)
        for shift in SHIFTS:
            other = np.roll(nearest, shift)
            there = self._distance(other, positions, growth)
            nearest = np.where(there < distance, other, nearest)
            np.minimum(distance, there, out=distance)
        self.nearest[where] = nearest
        return distance

    def distance(
        self, where: NDArray[np.int64], positions: Points, growth: float
    ) -> NDArray[np.float64]:
        """Distance, mm, from positions of some points to the contacts they are tied to.

        Contacts are taken where they will be after a growth of the radius; infinite where there
        is none.
        """
        return self._distance(self.nearest[where], positions, growth)

    def _distance(
        self, nearest: NDArray[np.int64], positions: Points, growth: float
    ) -> NDArray[np.float64]:
        # `take` copies rows several times quicker than an index in brackets does.
        offset = self._motion.positions.take(nearest, axis=0)
        if growth:
            offset += growth * self._motion.direction.take(nearest, axis=0)
        offset -= positions
        distance = norm(offset)
        distance[nearest < 0] = np.inf
        return distance
