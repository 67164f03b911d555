"""The widest sphere that passes from one place of a lumen to another, whatever way it takes.

At an ostium, or at a throat beside which a branch leaves, a plane across the vessel's line meets
pockets of the lumen side by side, each with a largest sphere of its own. Which of them is on the
way no single plane tells. What passes is the sphere at the narrowest place of the widest way: the
largest least distance to the wall of all ways, first on a grid, then across the way there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...geometry import across, connected, norm
from ...validation import Flags, Floats, Indices, Points
from ..tolerances import CENTERED
from .climb import InscribedSpheres
from .local_surface import LocalSurface
from .own import largest_in_disks

_CELLS = 4
"""Cells of the grid along a radius of the throat."""

_MOST = 24
"""Cells along an edge of the grid at most; wider ones where its ends are farther apart."""

_NEAR = 2.5
"""Cells about the narrowest one of the widest way within which the sphere is looked for,"""

_PLANES = 11
"""in this number of planes across the way."""


def with_passing(
    wall: LocalSurface, stations: Points, found: InscribedSpheres, along: Floats
) -> InscribedSpheres:
    """The spheres of some stations along a line, none smaller than passes where pockets change.

    Parameters
    ----------
    wall : LocalSurface
        Surface that bounds the spheres.
    stations : (n, 3) array
        mm.
    found : InscribedSpheres
        There, as `with_own_spheres` has them.
    along : (n,) array
        Arc lengths of the stations, mm.
    """
    centers, radii = found
    if not np.isfinite(radii).any():
        return found
    narrowest = int(np.nanargmin(radii))
    throat, radius = centers[narrowest], float(radii[narrowest])
    about = np.flatnonzero((np.abs(along - along[narrowest]) <= 2 * radius) & np.isfinite(radii))
    # Of a throat at an end nothing tells how wide the way to it is.
    is_between = about[0] < narrowest < about[-1]
    is_aside = norm(centers[about] - stations[about]) > CENTERED * radii[about]
    if not is_between or not is_aside.any():
        return found
    *center, passes = widest_passing(wall, throat, radius, centers[about[[0, -1]]])
    smaller = about[radii[about] < passes]
    wider = InscribedSpheres(centers.copy(), radii.copy())
    wider.centers[smaller], wider.radii[smaller] = center, passes
    return wider


def widest_passing(wall: LocalSurface, throat: Floats, radius: float, ends: Floats) -> Floats:
    """Center and radius (4,) of the widest sphere that passes between two places of a lumen, mm.

    That of the narrower place where the way between is wider; NaN where the grid has no way.

    Parameters
    ----------
    wall : LocalSurface
    throat : (3,) array
        About where the way is narrowest, mm.
    radius : float
        About as wide, mm.
    ends : (2, 3) array
        Ends of the way, mm.
    """
    corners = np.vstack([throat, ends])
    low, high = corners.min(axis=0) - radius, corners.max(axis=0) + radius
    step = max(radius / _CELLS, float((high - low).max()) / _MOST)
    counts = np.maximum(np.ceil((high - low) / step).astype(int), 1) + 1
    grid = low + step * np.moveaxis(np.indices(counts), 0, -1)
    away = [np.linalg.norm(grid - one, axis=-1) for one in ends]
    # A way as wide as the throat passes through cells that are narrower by less than a cell.
    for least in (radius - step, 0.0):
        room = _rooms(wall, grid, away, least)
        begin, end = (_widest(room, one) for one in away)
        cells = _Cells.of(room, least)
        parts = cells.parts(least)
        if parts[begin] == parts[end] >= 0:
            break
    narrower = min(begin, end, key=room.__getitem__)
    levels = np.sort(cells.rooms[cells.rooms <= room[narrower]])
    first, last = 0, len(levels)
    # Ends: half of the levels are left each time.
    while last - first > 1:
        middle = (first + last) // 2
        parts = cells.parts(levels[middle])
        first, last = (middle, last) if parts[begin] == parts[end] else (first, middle)
    if levels[first] == room[narrower] and np.count_nonzero(room <= room[narrower]) > 1:
        return np.r_[grid[narrower], room[narrower]]
    narrowest = grid[room == levels[first]][0]
    parts = cells.parts(np.nextafter(levels[first], np.inf))
    is_near = np.linalg.norm(grid - narrowest, axis=-1) < _NEAR * step
    sides = [grid[is_near & (parts == parts[one]) & (parts >= 0)] for one in (begin, end)]
    # Cells see each other through a wall that none of them is as near to.
    if levels[first] < step or parts[begin] == parts[end] or not all(map(len, sides)):
        return np.full(4, np.nan)
    way = sides[1].mean(axis=0) - sides[0].mean(axis=0)
    way /= np.linalg.norm(way)
    steps = _NEAR * step * np.linspace(-1.0, 1.0, _PLANES)
    axes = across(np.tile(way, (_PLANES, 1)))
    disks = np.full(_PLANES, _NEAR * step)
    found = largest_in_disks(wall, narrowest + steps[:, None] * way, axes, disks)
    at = int(found.radii.argmin())
    return np.r_[found.centers[at], found.radii[at]]


def _widest(room: Floats, away: Floats) -> tuple[int, ...]:
    """Widest cell with a place in its sphere, and so no wall between."""
    nearest = away.argmin()
    reach = max(room.flat[nearest], away.flat[nearest])
    at = np.where(away <= reach, room, -np.inf).argmax()
    return tuple(int(one) for one in np.unravel_index(at, room.shape))


def _rooms(wall: LocalSurface, grid: Floats, away: Sequence[Floats], least: float) -> Floats:
    """Distances from the cells of a grid to the wall, 0 for most that are nearer than `least`.

    They are known of the cells that are the least `away` from the ends, too.
    """
    is_asked = wall.bounds(grid.reshape(-1, 3)).reshape(grid.shape[:-1]) >= least
    is_asked.flat[[one.argmin() for one in away]] = True
    room = np.zeros(is_asked.shape)
    room[is_asked] = wall.distances(grid[is_asked])
    return room


class _Cells(NamedTuple):
    """Cells of a grid that are far enough from the wall, and pairs of neighbors among them."""

    is_one: Flags
    """Whether a cell of the grid is one of these (n,)."""
    rooms: Floats
    """(n,) distances from the wall, mm."""
    pairs: Indices
    """(2, p) neighbors, also those that share a corner."""
    links: Floats
    """(p,) smaller one of their distances, mm."""

    @classmethod
    def of(cls, room: Floats, least: float) -> _Cells:
        """The cells that are at least so far from the wall."""
        is_one = room >= least
        rooms = room[is_one]
        # With an empty cell all round no step leads to another row.
        number = np.full(np.add(room.shape, 2), -1)
        number[1:-1, 1:-1, 1:-1][is_one] = np.arange(len(rooms))
        strides = np.array(number.strides) // number.itemsize
        steps = (np.indices((3, 3, 3)).reshape(3, -1).T - 1) @ strides
        beside = number.ravel()[np.flatnonzero(number >= 0)[:, None] + steps[steps > 0]]
        one, step = np.nonzero(beside >= 0)
        pairs = np.stack([one, beside[one, step]])
        return cls(is_one, rooms, pairs, rooms[pairs].min(axis=0))

    def parts(self, level: float) -> Indices:
        """Number of the connected part of each cell of the grid; -1 for those below a level."""
        _, parts = connected(len(self.rooms), *self.pairs[:, self.links >= level])
        found = np.full(self.is_one.shape, -1)
        found[self.is_one] = np.where(self.rooms >= level, parts, -1)
        return found
