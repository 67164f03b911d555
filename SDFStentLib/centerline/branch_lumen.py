"""Stations along every branch of a tree, with the lumen that its file gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import Line
from ..validation import Floats, Indices, Points
from .point_tree import PointTree

SAME_PLACE = 1e-9
"""Length, mm, up to which a branch counts as having none."""

COARSEST, FINEST = 2.0, 0.5
"""Largest and smallest spacing of the stations, mm; in between it is half of the branch's median
radius. A lesion is measured anew round its narrowest station."""

UNKNOWN_RADIUS = 2.0
"""Radius, mm, that sets the spacing of stations where a centerline gives none."""


class BranchLumen(NamedTuple):
    """Stations along one branch, beginning on the root's side."""

    branch: int
    """Index into `Centerline.branches`."""
    nodes: tuple[int, int]
    """The centerline points at which it starts and ends."""
    start: float
    """Arc length from the root to the start of the branch, mm."""
    line: Line
    """Line through the n stations, mm."""
    along: Floats
    """(n,) arc length along the branch, mm."""
    diameter: Floats
    """(n,) inscribed diameter, mm; NaN where it is not known."""
    centers: Points
    """(n, 3) centers of the spheres, mm; NaN where there is none."""

    @property
    def points(self) -> Points:
        """(n, 3) stations on the centerline, mm."""
        return self.line.points


def lumens_of(
    tree: PointTree, branches: Sequence[Indices], arc_length: Floats
) -> tuple[BranchLumen, ...]:
    """Stations along all branches that have a length, with the widths of the tree's own points."""
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
    """Index (n,) into the branches for a tree's points; the next branch where one has no length."""
    found = np.full(len(arc_length), -1)
    for lumen in lumens:
        found[branches[lumen.branch][1:]] = lumen.branch
    for branch in sorted(branches, key=lambda one: arc_length[one[0]]):
        found[branch] = np.where(found[branch] < 0, found[branch].max(), found[branch])
    return found


def _joined_nodes(branches: Sequence[Indices], arc_length: Floats) -> Indices:
    """Representative of each point: both ends of a branch without length are one."""
    joined = np.arange(len(arc_length))
    for branch in sorted(branches, key=lambda b: arc_length[b[0]]):
        if np.ptp(arc_length[branch]) <= SAME_PLACE:
            joined[branch] = joined[branch[0]]
    return joined


def station_spacing(radius: Floats) -> float:
    """Spacing, mm, of stations along a lumen of these radii (n,), NaN where unknown."""
    known = radius[np.isfinite(radius)]
    spacing = (float(np.median(known)) if len(known) else UNKNOWN_RADIUS) / 2
    return min(max(spacing, FINEST), COARSEST)
