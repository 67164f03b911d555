"""The inscribed diameter along every branch of a vessel tree, each place measured once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np

from ..centerline import BranchLumen, Centerline
from ..geometry import Surface, is_inside, tangents
from ..lumen import InscribedSpheres, Until, closed_surface, holes_of, inscribed_spheres
from ..validation import Flags, Floats, InputError, Points

_SAFELY = 1 + 1e-9
"""Factor on a radius that is enough, against rounding."""

END_REACH = 1.1
"""Radii from the end of a vessel within which the sphere may touch its cap; a tenth for a cap that
leans or is round."""

TOLERANCE = 1e-4
"""Of the search for the spheres, mm; far below what a tenth of a diameter needs."""


_known: WeakKeyDictionary[Surface, tuple[Centerline, tuple[BranchLumen, ...]]] = WeakKeyDictionary()
"""Of the last centerline: lesions and flow ask for the same."""


def branch_lumens(surface: Surface, centerline: Centerline) -> tuple[BranchLumen, ...]:
    """The lumen along all branches; branches without length are left out, their ends are one.

    Measured once for a surface and its centerline, neither of which can change.

    Diameters are NaN where the centerline is outside of the lumen, and where the sphere may touch
    the cap of an in- or outlet.

    Raises
    ------
    InputError
        The whole centerline is outside of the surface.
    """
    known = _known.get(surface)
    if known is None or known[0] is not centerline:
        known = _known[surface] = centerline, _measured(surface, centerline)
    return known[1]


def _measured(surface: Surface, centerline: Centerline) -> tuple[BranchLumen, ...]:
    lumens = centerline.lumens
    stations = np.concatenate([lumen.points for lumen in lumens])
    directions = np.concatenate([tangents(lumen.points) for lumen in lumens])
    to_end = np.concatenate(_distances_to_ends(lumens))
    # What is wider than this so near to an end is not used, however wide it is.
    until = Until(TOLERANCE, _SAFELY / END_REACH * to_end)
    spheres = inscribed_spheres(surface.points, surface.triangles, stations, directions, until)
    diameter = 2 * spheres.radii
    is_in = are_in_lumen(stations, spheres, surface)
    if not (is_in & np.isfinite(diameter)).any():
        raise InputError(
            "lesions: expected a centerline inside of the surface, got one that is outside "
            "everywhere; check that both are of one patient and in one unit."
        )
    diameter[~is_in | ~(diameter > 0) | (END_REACH * spheres.radii > to_end)] = np.nan
    ends = np.cumsum([len(lumen.points) for lumen in lumens])[:-1]
    columns = zip(lumens, np.split(diameter, ends), np.split(spheres.centers, ends), strict=True)
    return tuple(lumen._replace(diameter=d, centers=c) for lumen, d, c in columns)


def _distances_to_ends(lumens: Sequence[BranchLumen]) -> list[Floats]:
    """How far (n,) the stations of every branch are from where the vessel ends, mm.

    The root is an end for all that comes from it, also where lines part right behind it.
    """
    meeting = Counter(node for lumen in lumens for node in lumen.nodes)
    found = []
    for lumen in lumens:
        distance = lumen.start + lumen.along
        if meeting[lumen.nodes[1]] == 1:
            distance = np.minimum(distance, lumen.along[-1] - lumen.along)
        found.append(distance)
    return found


def are_in_lumen(stations: Points, spheres: InscribedSpheres, surface: Surface) -> Flags:
    """Which stations (n,) are inside; those that one sphere without any wall holds are on one side.

    A sphere at an open end looks out of it: what is so near to a hole is asked for by itself.
    """
    if not len(stations):
        return np.zeros(0, dtype=bool)
    centers, radii = spheres
    holes = holes_of(surface)
    for middle, reach in zip(holes.middles, holes.radii, strict=True):
        radii = np.minimum(radii, np.linalg.norm(centers - middle, axis=1) - reach)
    holds = np.linalg.norm(stations - centers, axis=1) < radii
    holds_next = np.linalg.norm(stations[1:] - centers[:-1], axis=1) < radii[:-1]
    group = np.cumsum(np.r_[True, ~(holds[:-1] & holds_next)]) - 1
    first = np.searchsorted(group, np.arange(group[-1] + 1))
    closed = closed_surface(surface)
    return np.asarray(is_inside(stations[first], closed.points, closed.triangles)[group])
