"""Spheres that have left their vessel: at a throat beside which a branch leaves, the plane across
the vessel meets both, and the climb to the largest sphere ends in the branch.

Such a sphere does not hold its station, though the stations beside it lie in the middle of theirs.
It is searched anew round where those tell that the middle is, over a disk that the wall bounds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...geometry import Line, across, norm
from ...validation import Floats, Indices, Points
from ..tolerances import CENTERED, WITHIN
from .climb import InscribedSpheres
from .local_surface import LocalSurface

_TRIED = 5
"""Places across a disk, tried together; then the disk is half as wide, about the best one,"""

_FINEST = 0.005
"""until it is so narrow, mm."""


def with_own_spheres(
    wall: LocalSurface,
    stations: Points,
    directions: Points,
    found: InscribedSpheres,
    lines: Sequence[Indices],
) -> InscribedSpheres:
    """Spheres of some stations; those that have left their vessel are searched anew.

    Parameters
    ----------
    wall : LocalSurface
        Surface that bounds the spheres.
    stations, directions : (n, 3) arrays
        mm.
    found : InscribedSpheres
        There.
    lines : sequence of (k,) arrays of int
        The stations that go along one line, in order.
    """
    centers, radii = found.centers.copy(), found.radii.copy()
    offset = centers - stations
    with np.errstate(invalid="ignore"):
        astray, centered = norm(offset) >= radii, norm(offset) < CENTERED * radii
    middles, which = [], []
    for line in lines:
        left, known = line[astray[line]], centered[line]
        if len(left) and known.any():
            along = Line(stations[line]).arc_lengths
            middles.append(
                stations[left]
                + np.column_stack(
                    [np.interp(along[astray[line]], along[known], x[line][known]) for x in offset.T]
                )
            )
            which.append(left)
    if which:
        again, places = np.concatenate(which), np.concatenate(middles)
        ways = directions[again] / norm(directions[again])[:, None]
        disks = WITHIN * np.maximum(wall.distances(places), 1e-12)
        own = largest_in_disks(wall, places, across(ways), disks)
        smaller = own.radii < radii[again]
        centers[again[smaller]], radii[again[smaller]] = own.at(np.flatnonzero(smaller))
    return InscribedSpheres(centers, radii)


def largest_in_disks(
    wall: LocalSurface, middles: Points, axes: Floats, disks: Floats
) -> InscribedSpheres:
    """The largest spheres with centers in disks (n,) round some middles (n, 3), axes (n, 2, 3)."""
    steps = np.linspace(-1.0, 1.0, _TRIED)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    grid = grid[norm(grid) <= 1.0]
    radii = wall.distances(middles)
    best, size, rows = np.zeros((len(middles), 2)), disks, np.arange(len(middles))
    # Ends: disks become half as wide.
    while (size > _FINEST).any():
        tried = best[:, None] + size[:, None, None] * grid
        tried /= np.maximum(np.linalg.norm(tried, axis=2) / disks[:, None], 1.0)[..., None]
        places = middles[:, None] + np.einsum("nki,nij->nkj", tried, axes)
        # Only what may be wider than the best so far is measured.
        is_asked = wall.bounds(places.reshape(-1, 3)).reshape(len(middles), -1) > radii[:, None]
        room = np.zeros(is_asked.shape)
        room[is_asked] = wall.distances(places[is_asked])
        at = room.argmax(axis=1)
        is_more = room[rows, at] > radii
        best = np.where(is_more[:, None], tried[rows, at], best)
        radii = np.where(is_more, room[rows, at], radii)
        size = size / 2
    return InscribedSpheres(middles + np.einsum("ni,nij->nj", best, axes), radii)
