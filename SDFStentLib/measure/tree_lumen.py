"""The inscribed diameter along every branch of a vessel tree, each place measured once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..centerline import Centerline
from ..geometry import Surface, boundary_edges, component_labels, is_inside, resampled, tangents
from ..validation import Flags, InputError, Points, Triangles
from .inscribed import InscribedSpheres, inscribed_spheres

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SAME_PLACE = 1e-9
"""Length up to which a branch has none, mm."""

COARSEST, FINEST = 1.0, 0.25
"""Distance of the stations, mm; between the two it is a quarter of the branch's median radius."""


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
    joined = _joined_nodes(centerline)
    lines = [
        (number, _stations(centerline, branch))
        for number, branch in enumerate(centerline.branches)
        if joined[branch[0]] != joined[branch[-1]]
    ]
    stations = np.concatenate([line for _, line in lines])
    directions = np.concatenate([tangents(line) for _, line in lines])
    points, triangles = surface.points, surface.triangles
    spheres = inscribed_spheres(points, triangles, stations, directions, tolerance=TOLERANCE)
    diameter = 2 * spheres.radii
    diameter[~_is_in_lumen(stations, spheres, surface)] = np.nan
    if not np.isfinite(diameter).any():
        raise InputError(
            "lesions: expected a centerline inside of the surface, got one that is outside "
            "everywhere; check that both are of one patient and in one unit."
        )
    ends = np.cumsum([len(line) for _, line in lines])[:-1]
    found = []
    for (number, line), values in zip(lines, np.split(diameter, ends), strict=True):
        branch = centerline.branches[number]
        nodes = int(joined[branch[0]]), int(joined[branch[-1]])
        start, end = centerline.arc_length[branch[[0, -1]]]
        along = np.linspace(0.0, end - start, len(line))
        found.append(BranchLumen(number, nodes, float(start), line, along, values))
    return tuple(found)


def closed_surface(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    """The surface with a fan of triangles over every hole, which tells inside from outside."""
    rim = boundary_edges(triangles)
    if not len(rim):
        return points, triangles
    used, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    label = component_labels(len(used), ends[:, 0], ends[:, 1])
    weight = np.bincount(label)
    middles = np.stack([np.bincount(label, part) for part in points[used].T], axis=1)
    fans = np.column_stack([rim[:, ::-1], len(points) + label[ends[:, 0]]])
    return np.vstack([points, middles / weight[:, None]]), np.vstack([triangles, fans])


def _is_in_lumen(stations: Points, spheres: InscribedSpheres, surface: Surface) -> Flags:
    """Which stations (n,) are inside; those that one empty sphere holds are on one side."""
    centers, radii = spheres
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
