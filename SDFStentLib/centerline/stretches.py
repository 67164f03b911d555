"""Stretches of lumen between the places where lumens part, whichever lines run through them.

Lines of a file may part long before their vessels do: then several run through one lumen. So the
longest line from a root comes first, and every further line counts only from where its spheres
leave those of the lines before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..geometry import dot
from ..validation import Flags, Floats, Indices, Points
from .branch_lumen import BranchLumen

SAME_LUMEN = 0.5
"""Distance between the centers of two spheres, across the vessel and in radii, up to which they are
of the same lumen: centers in two vessels draw apart where one lumen becomes two."""

UNKNOWN_EXTENT = 1e-2
"""Radius of a lumen of unknown width, over the bounding box's diagonal."""

_BESIDE = 0.6
"""Distance along a lumen, in spacings of its stations, within which a station of another line lies
beside one of its own."""

_DRIFT = 0.15
"""Share of the way since two lines parted by which one may be longer than the other: in bends, and
where it wanders from side to side."""

_AT_ONCE = 16
"""Number of stations of a line that are looked at together: most lines part within a few."""


class LumenStretch(NamedTuple):
    """Stations along a lumen from a root, or from where it parts from another, to where it divides.

    The first one lies in the lumen above, where there is one.
    """

    points: Points
    """(n, 3) stations on the centerline, mm."""
    along: Floats
    """(n,) arc length from the root, mm; that along the first of the lines in one lumen."""
    diameter: Floats
    """(n,) inscribed diameter, mm; NaN where it is not known."""
    branch: Indices
    """(n,) index into `Centerline.branches`."""
    branch_along: Floats
    """(n,) arc length from the start of that branch, mm."""
    above: int
    """Number of the stretch at whose end it begins; -1 at a root."""


class JoinedLumens(NamedTuple):
    """The stretches of a tree, and the stretch in which every station of its branches lies."""

    stretches: list[LumenStretch]
    """The stretches, each after the one above it."""
    of_station: list[Indices]
    """Indices (n,) into the stretches for every branch."""


def joined_lumens(lumens: Sequence[BranchLumen]) -> JoinedLumens:
    """The stretches of lumen of some branches; each lumen counts once."""
    firsts = np.cumsum([0, *(len(lumen.along) for lumen in lumens)]).tolist()
    joined = _Joined(lumens)
    # The station, at every node of the centerline, of a line that has been added.
    at_node: dict[int, int] = {}
    for chain in _chains(lumens):
        start = at_node.setdefault(lumens[chain[0]].nodes[0], firsts[chain[0]])
        line = [start]
        for number in chain:
            # The station at a junction is there once for every branch.
            line += range(firsts[number] + 1, firsts[number + 1])
            at_node[lumens[number].nodes[1]] = line[-1]
        joined.add(line)
    found, of_station = joined.stretches()
    for lumen, first in zip(lumens, firsts, strict=False):
        of_station[first] = of_station[at_node[lumen.nodes[0]]]
    return JoinedLumens(found, np.split(of_station, firsts[1:-1]))


def _chains(lumens: Sequence[BranchLumen]) -> Iterator[list[int]]:
    """Branches from a root or a fork to an end, the longest way first; each branch once."""
    ending = {lumen.nodes[1]: number for number, lumen in enumerate(lumens)}
    starting = {lumen.nodes[0] for lumen in lumens}
    leaves = [number for number, lumen in enumerate(lumens) if lumen.nodes[1] not in starting]
    taken: set[int] = set()
    for leaf in sorted(leaves, key=lambda n: -(lumens[n].start + lumens[n].along[-1])):
        chain = [leaf]
        taken.add(leaf)
        # Ends: at a root, or at a branch of a chain before.
        while (above := ending.get(lumens[chain[-1]].nodes[0])) is not None and above not in taken:
            chain.append(above)
            taken.add(above)
        yield chain[::-1]


class _Joined:
    """Stations of the lines added so far; stations in the lumen of earlier lines map to theirs."""

    def __init__(self, lumens: Sequence[BranchLumen]) -> None:
        self._columns = (
            np.concatenate([lumen.points for lumen in lumens]),
            np.concatenate([lumen.start + lumen.along for lumen in lumens]),
            np.concatenate([lumen.diameter for lumen in lumens]),
            np.concatenate([np.full(len(lumen.along), lumen.branch) for lumen in lumens]),
            np.concatenate([lumen.along for lumen in lumens]),
        )
        # Arc length along the first of the lines in one lumen.
        self._along = self._columns[1].copy()
        self._centers = np.concatenate([lumen.centers for lumen in lumens])
        self._ways = np.concatenate([lumen.line.directions for lumen in lumens])
        self._radii = self._columns[2] / 2
        if not np.isfinite(self._radii).any():
            self._radii[:] = UNKNOWN_EXTENT * np.linalg.norm(np.ptp(self._columns[0], axis=0))
        self._spacings = np.concatenate(
            [np.full(len(lumen.along), lumen.along[1] - lumen.along[0]) for lumen in lumens]
        )
        self._is_known = np.isfinite(self._radii) & np.isfinite(self._centers).all(axis=1)
        self._centers[~self._is_known] = self._columns[0][~self._is_known]
        count = len(self._radii)
        self._is_kept = np.zeros(count, dtype=bool)
        self._stands = np.arange(count)
        self._above = np.full(count, -1)
        # For the first station that a line has for itself: the one before it on that line.
        self._before = np.full(count, -1)

    def add(self, line: Sequence[int]) -> None:
        """Add a line from a root, or from a station of an earlier line, to an end."""
        first = 0
        if self._is_kept[self._stands[line[0]]]:
            first = self._leave(line)
        own = line[first:]
        self._is_kept[own] = True
        self._above[own[1:]] = own[:-1]
        if first and own:
            before = line[first - 1]
            self._above[own[0]], self._before[own[0]] = self._stands[before], before
            self._along[own] += self._along[self._stands[before]] - self._along[before]

    def _leave(self, line: Sequence[int]) -> int:
        """Number of stations for which a line runs in the lumen of earlier lines."""
        kept = np.flatnonzero(self._is_kept)
        if not self._is_known[kept].any():
            return 1
        along = self._columns[1]
        last = 0
        for begin in range(1, len(line), _AT_ONCE):
            some = np.array(line[begin : begin + _AT_ONCE])
            same, is_told = self._in_lumens(some, kept)
            begun = self._along[self._stands[line[0]]]
            both = along[some] - along[line[0]], self._along[same] - begun
            drift = np.maximum(self._spacings[same], self._spacings[some]) + _DRIFT * both[0]
            same = np.where(np.abs(both[0] - both[1]) <= drift, same, -1)
            for number, one in enumerate(some.tolist(), start=begin):
                if same[number - begin] >= 0:
                    self._stands[line[last + 1 : number + 1]] = same[number - begin]
                    last = number
                elif is_told[number - begin] and along[one] - along[line[last]] > self._radii[one]:
                    # Where a width is not known, as at an inlet, it may still be in that lumen.
                    return last + 1
        return last + 1

    def _in_lumens(self, some: Indices, kept: Indices) -> tuple[Indices, Flags]:
        """The kept station in whose lumen each (k,) of some stations lies, -1 for none, and whether
        both widths are known."""
        # Column by column: NumPy takes several times longer over rows of three.
        x, y, z = (column[some][:, None] - column[kept] for column in self._centers.T)
        found = kept[(x * x + y * y + z * z).argmin(axis=1)]
        offset, ways = self._centers[some] - self._centers[found], self._ways[found]
        ahead = dot(offset, ways)
        across = np.linalg.norm(offset - ahead[:, None] * ways, axis=1)
        is_same = np.abs(ahead) <= _BESIDE * self._spacings[found]
        is_same &= across <= SAME_LUMEN * self._radii[found]
        is_told = self._is_known[some] & self._is_known[found]
        return np.where(is_same & is_told, found, -1), is_told

    def stretches(self) -> tuple[list[LumenStretch], Indices]:
        """The stretches between stations at which several lines go on, and that of every station
        (n,)."""
        below: dict[int, list[int]] = {}
        for station in np.flatnonzero(self._is_kept).tolist():
            below.setdefault(int(self._above[station]), []).append(station)
        found: list[LumenStretch] = []
        of_station = np.full(len(self._stands), -1)
        waiting = [([station], -1) for station in below.get(-1, [])]
        # Ends: every station is in one stretch, but for the first of those that go on.
        while waiting:
            which, above = waiting.pop(0)
            # Ends: at the end of a line at the latest.
            while len(onward := below.get(which[-1], [])) == 1:
                which += onward
            waiting += [([self._first_of(one), one], len(found)) for one in onward]
            of_station[which if above < 0 else which[1:]] = len(found)
            found.append(self._stretch(which, found, above))
        return found, of_station[self._stands]

    def _stretch(
        self, which: Sequence[int], found: Sequence[LumenStretch], above: int
    ) -> LumenStretch:
        points, along, diameter, branch, branch_along = (c[which] for c in self._columns)
        if above >= 0:
            along = along + (found[above].along[-1] - along[0])
        return LumenStretch(points, along, diameter, branch, branch_along, above)

    def _first_of(self, station: int) -> int:
        """The station before the first one of a stretch, on its own line."""
        before = int(self._before[station])
        return before if before >= 0 else int(self._above[station])
