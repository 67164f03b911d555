"""The inscribed diameter along every branch of a vessel tree, each place measured once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, is_inside, resampled, tangents
from ..lumen import InscribedSpheres, Until, closed_surface, holes_of, inscribed_spheres
from ..validation import Flags, Floats, Indices, InputError, Points

SAME_PLACE = 1e-9
"""Length up to which a branch has none, mm."""

_SAFELY = 1 + 1e-9
"""Factor on a radius that is enough, against rounding."""

COARSEST, FINEST = 2.0, 0.5
"""Distance of the stations, mm; between the two it is half of the branch's median radius. A lesion
is measured anew round its narrowest station."""

UNKNOWN_RADIUS = 2.0
"""Where a centerline tells no radius, stations are as far apart as in such a branch, mm."""

END_REACH = 1.1
"""Radii from the end of a vessel within which the sphere may touch its cap; a tenth for a cap that
leans or is round."""

TOLERANCE = 1e-4
"""Of the search for the spheres, mm; far below what a tenth of a diameter needs."""


class BranchLumen(NamedTuple):
    """Stations along one branch, from the root's side on."""

    branch: int
    """Index into `Centerline.branches`."""
    nodes: tuple[int, int]
    """The centerline points at which it starts and ends."""
    start: float
    """Arc length from the root to its start, mm."""
    points: Points
    """(n, 3) on the centerline, mm."""
    along: Floats
    """(n,) arc length along the branch, mm."""
    diameter: Floats
    """(n,) inscribed diameter, mm; NaN where the centerline is outside of the lumen, and where the
    sphere may touch the cap of an in- or outlet."""
    centers: Points
    """(n, 3) of the spheres, mm; NaN where there is none."""


def branch_lumens(surface: Surface, centerline: Centerline) -> tuple[BranchLumen, ...]:
    """The lumen along all branches; branches without length are left out, their ends are one.

    Raises
    ------
    InputError
        The whole centerline is outside of the surface.
    """
    lumens = _unmeasured(centerline)
    stations = np.concatenate([lumen.points for lumen in lumens])
    directions = np.concatenate([tangents(lumen.points) for lumen in lumens])
    to_end = np.concatenate(_distances_to_ends(lumens))
    # What is wider than this so near to an end is not used, however wide it is.
    until = Until(TOLERANCE, _SAFELY / END_REACH * to_end)
    spheres = inscribed_spheres(surface.points, surface.triangles, stations, directions, until)
    diameter = 2 * spheres.radii
    is_in = _is_in_lumen(stations, spheres, surface)
    if not (is_in & np.isfinite(diameter)).any():
        raise InputError(
            "lesions: expected a centerline inside of the surface, got one that is outside "
            "everywhere; check that both are of one patient and in one unit."
        )
    diameter[~is_in | ~(diameter > 0) | (END_REACH * spheres.radii > to_end)] = np.nan
    ends = np.cumsum([len(lumen.points) for lumen in lumens])[:-1]
    columns = zip(lumens, np.split(diameter, ends), np.split(spheres.centers, ends), strict=True)
    return tuple(lumen._replace(diameter=d, centers=c) for lumen, d, c in columns)


def _unmeasured(centerline: Centerline) -> list[BranchLumen]:
    """The stations along all branches that have a length."""
    joined, found = _joined_nodes(centerline), []
    for number, branch in enumerate(centerline.branches):
        nodes = int(joined[branch[0]]), int(joined[branch[-1]])
        if nodes[0] == nodes[1]:
            continue
        line = _stations(centerline, branch)
        start, end = centerline.arc_length[branch[[0, -1]]]
        along = np.linspace(0.0, end - start, len(line))
        unknown = np.full(len(line), np.nan)
        found.append(BranchLumen(number, nodes, float(start), line, along, unknown, line))
    return found


def _distances_to_ends(lumens: Sequence[BranchLumen]) -> list[Floats]:
    """How far (n,) the stations of every branch are from where the vessel ends, mm."""
    meeting = Counter(node for lumen in lumens for node in lumen.nodes)
    found = []
    for lumen in lumens:
        distance = np.full(len(lumen.along), np.inf)
        for node, away in zip(
            lumen.nodes, (lumen.along, lumen.along[-1] - lumen.along), strict=True
        ):
            if meeting[node] == 1:
                distance = np.minimum(distance, away)
        found.append(distance)
    return found


def _is_in_lumen(stations: Points, spheres: InscribedSpheres, surface: Surface) -> Flags:
    """Which stations (n,) are inside; those that one sphere without any wall holds are on one side.

    A sphere at an open end looks out of it: what is so near to a hole is asked for by itself.
    """
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


def _joined_nodes(centerline: Centerline) -> Indices:
    """For every point the one that stands for it: both ends of a branch without length are one."""
    joined = np.arange(len(centerline.points))
    for branch in sorted(centerline.branches, key=lambda b: centerline.arc_length[b[0]]):
        if np.ptp(centerline.arc_length[branch]) <= SAME_PLACE:
            joined[branch] = joined[branch[0]]
    return joined


def _stations(centerline: Centerline, branch: Indices) -> Points:
    radius = centerline.inscribed_radius[branch]
    known = radius[np.isfinite(radius)]
    spacing = (float(np.median(known)) if len(known) else UNKNOWN_RADIUS) / 2
    return resampled(centerline.points[branch], min(max(spacing, FINEST), COARSEST))
