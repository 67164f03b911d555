"""The inscribed diameter along every branch of a vessel tree, each place measured once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..centerline import Centerline
from ..geometry import Surface, boundary_edges, component_labels, is_inside, resampled, tangents
from ..validation import Flags, InputError, Points, Triangles
from .inscribed import InscribedSpheres, Until, inscribed_spheres

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SAME_PLACE = 1e-9
"""Length up to which a branch has none, mm."""

_SAFELY = 1 + 1e-9
"""Factor on a radius that is enough, against rounding."""

COARSEST, FINEST = 1.0, 0.25
"""Distance of the stations, mm; between the two it is a quarter of the branch's median radius."""


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
    """(n,) inscribed diameter, mm; NaN where the centerline is outside of the lumen."""


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
    # What is wider than this so near to an end is not used, however wide it is.
    enough = _SAFELY / END_REACH * np.concatenate(_distances_to_ends(lumens))
    points, triangles = surface.points, surface.triangles
    until = Until(TOLERANCE, enough)
    spheres = inscribed_spheres(points, triangles, stations, directions, until)
    diameter = 2 * spheres.radii
    diameter[~_is_in_lumen(stations, spheres, surface)] = np.nan
    if not np.isfinite(diameter).any():
        raise InputError(
            "lesions: expected a centerline inside of the surface, got one that is outside "
            "everywhere; check that both are of one patient and in one unit."
        )
    ends = np.cumsum([len(lumen.points) for lumen in lumens])[:-1]
    pairs = zip(lumens, np.split(diameter, ends), strict=True)
    return tuple(lumen._replace(diameter=values) for lumen, values in pairs)


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
        found.append(BranchLumen(number, nodes, float(start), line, along, unknown))
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


def closed_surface(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    """The surface with a fan of triangles over every hole, which tells inside from outside."""
    holes = _holes(points, triangles)
    if not len(holes.rim):
        return points, triangles
    fans = np.column_stack([holes.rim[:, ::-1], len(points) + holes.number])
    return np.vstack([points, holes.middles]), np.vstack([triangles, fans])


class _Holes(NamedTuple):
    rim: Indices
    """(m, 2) all edges with a triangle on one side only."""
    number: Indices
    """(m,) of the hole round which each goes."""
    middles: Points
    """(h, 3) mean of the points round each hole, mm."""
    radii: Floats
    """(h,) how far they are from it, at most, mm."""


def _holes(points: Points, triangles: Triangles) -> _Holes:
    rim = boundary_edges(triangles)
    used, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    label = component_labels(len(used), ends[:, 0], ends[:, 1])
    sums = np.stack([np.bincount(label, part) for part in points[used].T], axis=1)
    middles = sums / np.bincount(label)[:, None]
    radii = np.zeros(len(middles))
    np.maximum.at(radii, label, np.linalg.norm(points[used] - middles[label], axis=1))
    return _Holes(rim, label[ends[:, 0]], middles, radii)


def _is_in_lumen(stations: Points, spheres: InscribedSpheres, surface: Surface) -> Flags:
    """Which stations (n,) are inside; those that one sphere without any wall holds are on one side.

    A sphere at an open end looks out of it: what is so near to a hole is asked for by itself.
    """
    centers, radii = spheres
    holes = _holes(surface.points, surface.triangles)
    for middle, reach in zip(holes.middles, holes.radii, strict=True):
        radii = np.minimum(radii, np.linalg.norm(centers - middle, axis=1) - reach)
    holds = np.linalg.norm(stations - centers, axis=1) < radii
    holds_next = np.linalg.norm(stations[1:] - centers[:-1], axis=1) < radii[:-1]
    group = np.cumsum(np.r_[True, ~(holds[:-1] & holds_next)]) - 1
    first = np.searchsorted(group, np.arange(group[-1] + 1))
    closed = closed_surface(surface.points, surface.triangles)
    return np.asarray(is_inside(stations[first], *closed)[group])


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
    spacing = float(np.median(known)) / 4 if len(known) else COARSEST
    return resampled(centerline.points[branch], min(max(spacing, FINEST), COARSEST))
