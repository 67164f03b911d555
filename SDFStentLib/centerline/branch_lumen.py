"""Stations along every branch of a tree, with the lumen that its file tells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import Line
from ..validation import Floats, Indices, Points
from .point_tree import PointTree

SAME_PLACE = 1e-9
"""Length up to which a branch has none, mm."""

COARSEST, FINEST = 2.0, 0.5
"""Distance of the stations, mm; between the two it is half of the branch's median radius. A lesion
is measured anew round its narrowest station."""

UNKNOWN_RADIUS = 2.0
"""Where a centerline tells no radius, stations are as far apart as in such a branch, mm."""


class BranchLumen(NamedTuple):
    """Stations along one branch, from the root's side on."""

    branch: int
    """Index into `Centerline.branches`."""
    nodes: tuple[int, int]
    """The centerline points at which it starts and ends."""
    start: float
    """Arc length from the root to its start, mm."""
    line: Line
    """Through the n stations, mm."""
    along: Floats
    """(n,) arc length along the branch, mm."""
    diameter: Floats
    """(n,) inscribed diameter, mm; NaN where it is not known."""
    centers: Points
    """(n, 3) of the spheres, mm; NaN where there is none."""

    @property
    def points(self) -> Points:
        """(n, 3) on the centerline, mm."""
        return self.line.points


def told_lumens(
    tree: PointTree, branches: Sequence[Indices], arc_length: Floats
) -> tuple[BranchLumen, ...]:
    """The stations along all branches that have a length, as wide as the tree's points tell."""
    joined, found = _joined_nodes(branches, arc_length), []
    for number, branch in enumerate(branches):
        nodes = int(joined[branch[0]]), int(joined[branch[-1]])
        if nodes[0] == nodes[1]:
            continue
        radius, at = tree.inscribed_radius[branch], arc_length[branch]
        line = Line(tree.points[branch]).resampled(station_spacing(radius))
        along = np.linspace(0.0, at[-1] - at[0], len(line))
        diameter = 2 * np.interp(along, at - at[0], radius)
        found.append(BranchLumen(number, nodes, float(at[0]), line, along, diameter, line.points))
    return tuple(found)


def branch_of_points(
    lumens: Sequence[BranchLumen], branches: Sequence[Indices], arc_length: Floats
) -> Indices:
    """Index into the branches of every point of a tree; where one has no length, of the next."""
    found = np.full(len(arc_length), -1)
    for lumen in lumens:
        found[branches[lumen.branch][1:]] = lumen.branch
    for branch in sorted(branches, key=lambda one: arc_length[one[0]]):
        found[branch] = np.where(found[branch] < 0, found[branch].max(), found[branch])
    return found


def _joined_nodes(branches: Sequence[Indices], arc_length: Floats) -> Indices:
    """For every point the one that stands for it: both ends of a branch without length are one."""
    joined = np.arange(len(arc_length))
    for branch in sorted(branches, key=lambda b: arc_length[b[0]]):
        if np.ptp(arc_length[branch]) <= SAME_PLACE:
            joined[branch] = joined[branch[0]]
    return joined


def station_spacing(radius: Floats) -> float:
    """Distance of stations along a lumen of these radii (n,), NaN: unknown, mm."""
    known = radius[np.isfinite(radius)]
    spacing = (float(np.median(known)) if len(known) else UNKNOWN_RADIUS) / 2
    return min(max(spacing, FINEST), COARSEST)
