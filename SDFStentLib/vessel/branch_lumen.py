"""The inscribed diameter along every branch of a vessel tree, each place measured once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ..cautions import Caution
from ..centerline import BranchLumen, Centerline
from ..geometry import Surface, norm
from ..lumen import (
    END_REACH,
    ROUNDING,
    TOLERANCE,
    InscribedSpheres,
    LocalSurface,
    StationSearch,
    Until,
)
from ..validation import Flags, Floats, Indices, InputError
from .runs import VesselRun


def branch_lumens(surface: Surface, centerline: Centerline) -> tuple[BranchLumen, ...]:
    """The lumen along all branches; branches without length are left out, their ends are one.

    Measured once for a surface and its centerline, neither of which can change.

    Diameters are NaN where the centerline is outside of the lumen or on its way out of it, and
    where the sphere may touch the cap of an in- or outlet.

    Raises
    ------
    InputError
        The whole centerline is outside of the surface.
    """
    return tree_lumen(surface, centerline).exact


class TreeLumen:
    """The lumen along all branches of a tree, as `branch_lumens` has it, roughly or exactly."""

    def __init__(self, surface: Surface, centerline: Centerline) -> None:
        self.centerline, self._lumens = centerline, centerline.lumens
        self._ends = np.cumsum([len(lumen.points) for lumen in self._lumens])
        firsts = [0, *self._ends.tolist()]
        self._of_branch = {
            one.branch: (one, n) for one, n in zip(self._lumens, firsts, strict=False)
        }
        stations = np.concatenate([lumen.points for lumen in self._lumens])
        directions = np.concatenate([lumen.line.directions for lumen in self._lumens])
        self._to_end = np.concatenate(_distances_to_ends(self._lumens))
        # What is wider than this so near to an end is not used, however wide it is.
        until = Until(TOLERANCE, (1 + ROUNDING) / END_REACH * self._to_end)
        wall = LocalSurface.of(surface, stations)
        self.spheres = StationSearch(wall, stations, directions, until)
        self._is_in = surface.contains(stations)
        if not (self._is_in & np.isfinite(self.spheres.rough.radii)).any():
            raise InputError(
                "lesions: expected a centerline inside of the surface, got one that is outside "
                "everywhere; check that both are of one patient and in one unit."
            )

    @property
    def inside(self) -> list[Flags]:
        """Masks (n,) of each branch's stations that are in the lumen."""
        return np.split(self._is_in, self._ends[:-1])

    @cached_property
    def rough(self) -> tuple[BranchLumen, ...]:
        """The lumen with `StationSearch.rough` spheres."""
        return self._told(self.spheres.rough)

    @cached_property
    def exact(self) -> tuple[BranchLumen, ...]:
        """The lumen with the largest spheres."""
        return self._told(self.spheres.exact())

    def stations_of(self, run: VesselRun) -> Indices:
        """Indices (n,) of the spheres at the stations of a vessel."""
        found = np.empty(len(run.along), dtype=np.int64)
        for branch in np.unique(run.branch).tolist():
            own, (lumen, first) = run.branch == branch, self._of_branch[branch]
            found[own] = first + np.abs(lumen.along - run.branch_along[own, None]).argmin(axis=1)
        return found

    def _told(self, spheres: InscribedSpheres) -> tuple[BranchLumen, ...]:
        diameter = 2 * spheres.radii
        is_near_end = END_REACH * spheres.radii > self._to_end
        diameter[~self._is_in | ~(diameter > 0) | is_near_end] = np.nan
        for lumen, own, is_in in zip(
            self._lumens, np.split(diameter, self._ends[:-1]), self.inside, strict=True
        ):
            for run in outside_runs(self.centerline, lumen, is_in):
                own[_on_the_way(lumen.along, own, run)] = np.nan  # a view
        columns = (np.split(column, self._ends[:-1]) for column in (diameter, spheres.centers))
        return tuple(
            lumen._replace(diameter=d, centers=c)
            for lumen, d, c in zip(self._lumens, *columns, strict=True)
        )


def lumen_left(surface: Surface, centerline: Centerline) -> list[Caution]:
    """Cautions where lines leave the lumen and return; at the ends of a vessel they may stick
    out."""
    tree, found = tree_lumen(surface, centerline), []
    for lumen, is_in in zip(centerline.lumens, tree.inside, strict=True):
        for first, last in outside_runs(centerline, lumen, is_in):
            before, back = max(first - 1, 0), min(last + 1, len(is_in) - 1)
            length = float(lumen.along[back] - lumen.along[before])
            numbers = dict(zip("xyz", lumen.points[first].tolist(), strict=True))
            found.append(Caution("line-leaves-lumen", numbers | {"length_mm": length}))
    return found


def outside_runs(centerline: Centerline, lumen: BranchLumen, is_in: Flags) -> list[tuple[int, int]]:
    """The first and last of stations (n,) in a row that are outside of the lumen.

    But not at the root and at leaves, where a line may stick out of the vessel.
    """
    sides = np.flatnonzero(np.diff(np.r_[True, is_in, True]))
    free = {*centerline.roots.tolist(), *centerline.leaves.tolist()}
    return [
        (first, last)
        for first, last in (sides.reshape(-1, 2) - (0, 1)).tolist()
        if not (first == 0 and lumen.nodes[0] in free)
        and not (last == len(is_in) - 1 and lumen.nodes[1] in free)
    ]


def _on_the_way(along: Floats, diameter: Floats, run: tuple[int, int]) -> list[int]:
    """Stations on the way to where a line is outside, or back: not in the middle yet.

    Up to one, on both sides, that is as wide as all within its own width farther on.
    """
    found: list[int] = []
    for side in (range(run[0] - 1, -1, -1), range(run[1] + 1, len(along))):
        for place, station in enumerate(side):
            onward = np.array(side[place:])
            near = onward[np.abs(along[onward] - along[station]) <= diameter[station]]
            if len(near) and np.nanmax(diameter[near]) <= END_REACH * diameter[station]:
                break
            found.append(station)
    return found


_known: WeakKeyDictionary[Surface, TreeLumen] = WeakKeyDictionary()
"""The lumen of the last centerline: lesions and flow ask for the same."""


def tree_lumen(surface: Surface, centerline: Centerline) -> TreeLumen:
    """Measured once for a surface and its centerline; errors as of `branch_lumens`."""
    known = _known.get(surface)
    if known is None or known.centerline is not centerline:
        known = _known[surface] = TreeLumen(surface, centerline)
    return known


def _distances_to_ends(lumens: Sequence[BranchLumen]) -> list[Floats]:
    """Distances (n,) of every branch's stations from the ends of the vessel, mm.

    The root is an end for all that comes from it, also where lines part right behind it.
    """
    meeting = Counter(node for lumen in lumens for node in lumen.nodes)
    ending = {lumen.nodes[1] for lumen in lumens}
    roots = [lumen.points[0] for lumen in lumens if lumen.nodes[0] not in ending]
    found = []
    for lumen in lumens:
        ends = [*roots, *([lumen.points[-1]] if meeting[lumen.nodes[1]] == 1 else [])]
        # In a straight line: where a line wanders, the way along it is longer.
        found.append(np.min([norm(lumen.points - end) for end in ends], axis=0))
    return found
