"""The points in contact with the stent, the contact each other point is tied to, and new ones."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry import norm
from ..validation import Floats, Points
from .contact_search import FEW, ContactSearch, squared_distances
from .motion import CELL_SIZE, Motion

SHIFTS = (1, -1, 4, -4)
"""Offsets, in the order of the points, of the neighbors whose contacts a point tries."""


class ContactSet:
    """Contacts, the rates of all points, and their nearest contacts; in motion order.

    A point keeps its nearest contact until a new one, or that of a neighbor, is nearer: point and
    contact move outward side by side, so that the nearest of the old ones nearly stays the nearest.
    `tied_anew` searches all of them.

    Attributes
    ----------
    is_held : (n,) bool array
        Whether the point is in contact.
    rate : (n,) array
        Motion per radius growth at the end of the last step.
    nearest : (n,) int array
        Number of the nearest contact; -1 where none is within reach.
    """

    def __init__(self, motion: Motion) -> None:
        count = len(motion.level)
        self.is_held = np.zeros(count, dtype=bool)
        self.rate = np.zeros(count)
        self.nearest = np.full(count, -1, dtype=np.int64)
        self._motion = motion

    def added(self, numbers: NDArray[np.int64], reach: float) -> None:
        """Add points that have come into contact, and tie to them every point to which they are
        nearest.

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
        """Tie every point to its nearest contact, searched for among all contacts."""
        held = np.flatnonzero(self.is_held & self._motion.drags)
        if len(held):
            waiting = self.waiting()
            search = ContactSearch(self._motion.positions.take(held, axis=0))
            positions = self._motion.positions.take(waiting, axis=0)
            distance, nearest = search.nearest(positions, reach)
            near = distance < reach
            self.nearest[waiting[near]] = held[nearest[near]]

    def waiting(self) -> NDArray[np.int64]:
        """Indices (k,) of points that a contact may influence and that are not in contact
        themselves."""
        return np.flatnonzero(self._motion.resting.awake & ~self.is_held)

    def compared(
        self, where: NDArray[np.int64], positions: Points, growth: float
    ) -> NDArray[np.float64]:
        """`distance` (k,), after every point has tried the contacts of its neighbors in order."""
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
        """Distance (k,), mm, from positions of some points to the contacts they are tied to.

        Contacts are taken where they will be after the radius has grown by `growth`; the distance
        is infinite where there is none.
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


PHASES = 8
"""Parts of a step whose new contacts are considered one after the other.

With half as many the distance to the converged limit grows by a third.
"""

SHARED = 2.0
"""Points per cell from which on they share a guess; on coarser meshes neighbors are
too far apart."""


class NewContacts:
    """Points touched during a step, at their places in the middle of the step.

    Parameters
    ----------
    points : (k, 3) array
        Places, mm; may be none.
    times : (k,) array
        Growth of the radius from the beginning of the step until each was touched, mm.
    growth : float
        Growth of the radius in the step, mm.
    """

    def __init__(self, points: Points, times: Floats, growth: float) -> None:
        self._points = points
        self._times = times
        self._growth = growth

    @cached_property
    def search(self) -> ContactSearch | None:
        """A search among all new contacts; None when there are none."""
        return ContactSearch(self._points) if len(self._points) else None

    def excess(self, points: Points, cell: NDArray[np.int64], before: Floats) -> Floats:
        """Mean distance (n,) to the nearest contact over the step, less that at its end, mm.

        A new contact that is nearer than all before it takes effect from its own time.

        Parameters
        ----------
        points : (n, 3) array
            Points whose nearest contact is a new one at the end of the step, mm.
        cell : (n,) array
            Numbers, ascending, of the cells of the points; points of a cell are neighbors.
        before : (n,) array
            Distance to the nearest contact without the new ones, or a bound of it, mm.
        """
        if len(self._points) <= FEW:
            return self._one_by_one(points, before)
        return self._by_phases(points, cell, before)

    def _one_by_one(self, points: Points, before: Floats) -> Floats:
        order = np.argsort(self._times)
        times = self._times[order]
        lasting = np.diff(times, append=self._growth) / self._growth
        excess = before * (times[0] / self._growth)
        for part, pairs in squared_distances(points, self._points[order]):
            distance = np.sqrt(np.maximum(pairs, 0, out=pairs), out=pairs)
            np.minimum(distance[:, 0], before[part], out=distance[:, 0])
            np.minimum.accumulate(distance, axis=1, out=distance)
            excess[part] += distance @ lasting - distance[:, -1]
        return excess

    def _by_phases(self, points: Points, cell: NDArray[np.int64], before: Floats) -> Floats:
        """The excess when only the nearest contact of each part of the step counts.

        Neighbors on a fine mesh share that contact: both ends of the step are exact, and in between
        the second nearest does as well.
        """
        starts = np.flatnonzero(np.concatenate([[True], cell[1:] != cell[:-1]]))
        if len(points) < SHARED * len(starts):
            starts = np.arange(len(points))
        counts = np.diff(np.append(starts, len(cell)))
        centers = np.add.reduceat(points, starts, axis=0) / counts[:, None]
        # No neighbor is farther from the middle of a cell than its whole length.
        bound = float(before.max(initial=0)) + np.sqrt(3) * CELL_SIZE
        total, current = np.zeros(len(points)), before.copy()
        phase = (self._times * (PHASES / self._growth)).astype(np.int64)
        np.minimum(phase, PHASES - 1, out=phase)
        for index in range(PHASES):
            new = np.flatnonzero(phase == index)
            if len(new):
                _, nearest = ContactSearch(self._points[new]).nearest(centers, bound)
                # Beyond the bound no contact is found; any number will do, as all are too far.
                nearest = new[np.repeat(np.minimum(nearest, len(new) - 1), counts)]
                offset = points - self._points[nearest]
                distance = norm(offset)
                drop = np.maximum(current - distance, 0)
                total += drop * self._times[nearest]
                current -= drop
        return total / self._growth
