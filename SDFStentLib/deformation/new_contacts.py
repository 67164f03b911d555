"""Contacts that are made in the course of one radius step, each at its own time."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry import norm
from ..validation import Floats, Points
from .contact_search import FEW, ContactSearch, squared_distances
from .motion import CELL_SIZE

PHASES = 8
"""Parts of a step in which new contacts are looked at in turn; each counts from its own time.

With half as many the distance to the converged limit grows by a third.
"""

SHARED = 2.0
"""Points per cell from which they share; on coarser meshes neighbors are not near enough."""


class NewContacts:
    """Points touched during a step; places are those in the middle of the step.

    Parameters
    ----------
    points : (k, 3) array
        mm; may be none.
    times : (k,) array
        Growth from the begin of the step until each was touched, mm.
    growth : float
        Growth of the radius in the step, mm.
    """

    def __init__(self, points: Points, times: Floats, growth: float) -> None:
        self._points = points
        self._times = times
        self._growth = growth

    @cached_property
    def search(self) -> ContactSearch | None:
        """Search among all of them; None when there are none."""
        return ContactSearch(self._points) if len(self._points) else None

    def excess(self, points: Points, cell: NDArray[np.int64], before: Floats) -> Floats:
        """Mean distance to the nearest contact over the step less that at its end, (n,), mm.

        A new contact that is nearer than all before it takes effect from its own time.

        Parameters
        ----------
        points : (n, 3) array
            Points that a new contact is nearest to by the end, mm.
        cell : (n,) array
            Numbers, ascending, of the cells that they are in; points of a cell are neighbors.
        before : (n,) array
            Distance to the nearest contact without the new ones, or its bound, mm.
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
        """Of all contacts in one part of the step, only the nearest counts.

        Neighbors on a fine mesh share which one that is: between the exact distances at both ends
        of the step, the second nearest does as well.
        """
        starts = np.flatnonzero(np.concatenate([[True], cell[1:] != cell[:-1]]))
        if len(points) < SHARED * len(starts):
            starts = np.arange(len(points))
        counts = np.diff(np.append(starts, len(cell)))
        centres = np.add.reduceat(points, starts, axis=0) / counts[:, None]
        # No neighbor is farther from the middle of a cell than its whole length.
        bound = float(before.max(initial=0)) + np.sqrt(3) * CELL_SIZE
        total, current = np.zeros(len(points)), before.copy()
        phase = (self._times * (PHASES / self._growth)).astype(np.int64)
        np.minimum(phase, PHASES - 1, out=phase)
        for index in range(PHASES):
            new = np.flatnonzero(phase == index)
            if len(new):
                _, nearest = ContactSearch(self._points[new]).nearest(centres, bound)
                # Beyond the bound no contact is found; any other is as much too far.
                nearest = new[np.repeat(np.minimum(nearest, len(new) - 1), counts)]
                offset = points - self._points[nearest]
                distance = norm(offset)
                drop = np.maximum(current - distance, 0)
                total += drop * self._times[nearest]
                current -= drop
        return total / self._growth
