"""The widest sphere that passes from one place of a lumen to another, whatever way it takes.

At an ostium, or at a throat beside which a branch leaves, a plane across the vessel's line meets
pockets of the lumen side by side, each with a largest sphere of its own. Which of them is on the
way no single plane tells. What passes is the sphere at the narrowest place of the widest way: the
largest least distance to the wall of all ways, first on a grid, then across the way there.
"""

from __future__ import annotations

import numpy as np

from ...geometry import across, norm
from ...validation import Floats, Indices, Points
from .climb import InscribedSpheres
from .local_surface import LocalSurface
from .own import CENTERED, largest_in_disks

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
    room = wall.distances(grid.reshape(-1, 3)).reshape(counts)
    begin, end = (_widest(room, np.linalg.norm(grid - one, axis=-1)) for one in ends)
    levels = np.sort(room[room <= min(room[begin], room[end])])
    first, last = 0, len(levels)
    # Ends: half of the levels are left each time.
    while last - first > 1:
        middle = (first + last) // 2
        parts = _connected(room >= levels[middle])
        first, last = (middle, last) if parts[begin] == parts[end] else (first, middle)
    if first and first == len(levels) - 1:
        narrower = min(begin, end, key=room.__getitem__)
        return np.r_[grid[narrower], room[narrower]]
    narrowest = grid[room == levels[first]][0]
    parts = _connected(room > levels[first])
    is_near = np.linalg.norm(grid - narrowest, axis=-1) < _NEAR * step
    sides = [grid[is_near & (parts == parts[one]) & (parts > 0)] for one in (begin, end)]
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


def _connected(inside: np.ndarray) -> Indices:
    """Numbers of the connected parts of a grid's cells, 0 outside of them."""
    # Imported here: few vessels have such a throat, and every start would wait for it.
    from scipy import ndimage

    parts: Indices = ndimage.label(inside, np.ones((3, 3, 3)))[0]
    return parts
