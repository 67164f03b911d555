"""Contact in the course of one radius step: who was touched, and when."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .contact_search import FEW, ContactSearch, squared_distances
from .validation import Points

PHASES = 8
"""Parts of a step in which new contacts are looked at in turn; each counts from its own time.

With half as many the distance to the converged limit grows by a third (`benchmarks/step_rules.py`).
"""

SHARED = 2.0
"""Points per cell from which they share; on coarser meshes neighbors are not near enough."""


class ContactHistory:
    """Points in contact during a step; places are those in the middle of the step.

    Parameters
    ----------
    held : (h, 3) array
        In contact since before the step, mm.
    search : ContactSearch or None
        Of these, where there are some.
    hits : (k, 3) array
        Touched during the step, mm.
    times : (k,) array
        Growth from the begin of the step until each was touched, mm.
    growth : float
        Growth of the radius in the step, mm.
    """

    def __init__(
        self,
        held: Points,
        search: ContactSearch | None,
        hits: Points,
        times: NDArray[np.float64],
        growth: float,
    ) -> None:
        self._held = held
        self._search = search
        self._hits = hits
        self._times = times
        self._growth = growth

    @cached_property
    def by_the_end(self) -> ContactSearch | None:
        """Search among all of them; None when there are none."""
        if not len(self._hits):
            return self._search
        return ContactSearch(np.concatenate([self._held, self._hits]))

    def distances(
        self, points: Points, cell: NDArray[np.int64], bound: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distance to the nearest contact: mean over the step, and at its end.

        Parameters
        ----------
        points : (n, 3) array
            Places in the middle of the step, mm.
        cell : (n,) array
            Numbers, ascending, of the cells that they are in; points of a cell are neighbors.
        bound : float
            Larger distances count as this, mm.
        """
        end = np.full(len(points), bound)
        if self.by_the_end is None:
            return end, end
        distance, nearest = self.by_the_end.nearest(points, bound)
        np.minimum(end, distance, out=end)
        mean = end.copy()
        nearer = np.flatnonzero((nearest >= len(self._held)) & (end < bound))
        if len(nearer):
            mean[nearer] += self._excess(points[nearer], cell[nearer], bound)
        return mean, end

    def _excess(self, points: Points, cell: NDArray[np.int64], bound: float) -> NDArray[np.float64]:
        """Mean over the step less the distance at its end, of points that a new contact is near.

        A new contact that is nearer than all before it takes effect from its own time.
        """
        before = np.full(len(points), bound)
        if self._search is not None:
            np.minimum(before, self._search.nearest(points, bound)[0], out=before)
        if len(self._hits) <= FEW:
            return self._excess_one_by_one(points, before)
        return self._excess_by_phases(points, cell, before)

    def _excess_one_by_one(
        self, points: Points, before: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        order = np.argsort(self._times)
        times = self._times[order]
        lasting = np.diff(times, append=self._growth) / self._growth
        excess = before * (times[0] / self._growth)
        for part, pairs in squared_distances(points, self._hits[order]):
            distance = np.sqrt(np.maximum(pairs, 0, out=pairs), out=pairs)
            np.minimum(distance[:, 0], before[part], out=distance[:, 0])
            np.minimum.accumulate(distance, axis=1, out=distance)
            excess[part] += distance @ lasting - distance[:, -1]
        return excess

    def _excess_by_phases(
        self, points: Points, cell: NDArray[np.int64], before: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Of all contacts in one part of the step, only the nearest counts.

        Neighbors on a fine mesh share which one that is: between the exact distances at both ends
        of the step, the second nearest does as well.
        """
        starts = np.flatnonzero(np.concatenate([[True], cell[1:] != cell[:-1]]))
        if len(points) < SHARED * len(starts):
            starts = np.arange(len(points))
        counts = np.diff(np.append(starts, len(cell)))
        centres = np.add.reduceat(points, starts, axis=0) / counts[:, None]
        total, current = np.zeros(len(points)), before.copy()
        phase = (self._times * (PHASES / self._growth)).astype(np.int64)
        np.minimum(phase, PHASES - 1, out=phase)
        for index in range(PHASES):
            new = np.flatnonzero(phase == index)
            if len(new):
                _, nearest = ContactSearch(self._hits[new]).nearest(centres, np.inf)
                nearest = new[np.repeat(nearest, counts)]
                offset = points - self._hits[nearest]
                distance = np.sqrt(np.einsum("ij,ij->i", offset, offset))
                drop = np.maximum(current - distance, 0)
                total += drop * self._times[nearest]
                current -= drop
        return total / self._growth
