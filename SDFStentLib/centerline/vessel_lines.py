"""The line of a tree that a stent follows from a place: that of the vessel in which it lies.

Lines of a file may part long before their vessels do. Which of several lines in one lumen is the
nearest to a place says nothing: what counts is the lumen, and in which one it goes on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..validation import read_only
from .branch_lumen import BranchLumen
from .lumen_tree import LumenTree
from .path import JunctionChoice, Rule
from .stretches import joined_lumens

AS_WIDE = 1 + 1e-6
"""Ratio of two widths from which on one lumen counts as wider."""


class LumenPlace(NamedTuple):
    """Position of a place of a tree on its stretches of lumen."""

    stretch: int
    arc_length: float
    """Arc length from the root, mm."""


class VesselLines:
    """The lines of a tree that stents follow.

    Parameters
    ----------
    lumens : sequence of BranchLumen
        Lumens of the tree's branches, in their order; at least one.
    """

    def __init__(self, lumens: Sequence[BranchLumen]) -> None:
        joined = joined_lumens(lumens)
        self._lumens = {lumen.branch: lumen for lumen in lumens}
        self._of_station = {
            lumen.branch: of_station
            for lumen, of_station in zip(lumens, joined.of_station, strict=True)
        }
        self._tree = LumenTree(joined.stretches)
        self._onward = [
            self._chosen(number) if children else None
            for number, children in enumerate(self._tree.children)
        ]

    def stretch_at(self, branch: int, along: float) -> int:
        """The stretch of lumen at a place, given by a branch and a distance along it, mm."""
        stations = self._lumens[branch].along
        at = round(along / stations[1])
        return int(self._of_station[branch][min(at, len(stations) - 1)])

    def end_of(self, stretch: int) -> int:
        """The point of the tree to which the vessel of a stretch leads."""
        *_, last = self._from(stretch)
        return self._lumens[int(self._tree.lumens[last].branch[-1])].nodes[1]

    def is_above(self, one: int, other: int) -> bool:
        """Whether a stretch leads to another one, or is the same."""
        # Ends: at a root at the latest, whose number is the lowest on the way.
        while other > one:
            other = self._tree.lumens[other].above
        return other == one

    def choices(self, place: LumenPlace, last: float) -> Iterator[JunctionChoice]:
        """The choices made on the way from a place down to an arc length, mm."""
        first = self._tree.lumens[place.stretch]
        if first.above >= 0:
            above = self._tree.lumens[first.above]
            if place.arc_length - above.along[-1] < above.diameter[-1] / 2:
                yield JunctionChoice(read_only(above.points[-1]), "nearest")
        for number in self._from(place.stretch):
            lumen, onward = self._tree.lumens[number], self._onward[number]
            if onward is not None and lumen.along[-1] < last:
                yield JunctionChoice(read_only(lumen.points[-1]), onward[1])

    def _chosen(self, number: int) -> tuple[int, Rule]:
        """Child in which a stretch goes on, and the rule that chose it.

        It is the widest, counting all that it leads to; of several alike the one that begins
        widest; and the straightest where nothing distinguishes them, as without known radii.
        """
        alike = self._tree.alike(number)
        begins = [self._width_beyond(number, child) for child in alike]
        if len(alike) > 1 and max(begins) <= AS_WIDE * min(begins):
            return self._tree.straightest(number, alike), "straightest"
        return alike[int(np.argmax(begins))], "widest"

    def _width_beyond(self, above: int, child: int) -> float:
        """Mean diameter of a child from one to three radii beyond a division, mm; 0 where unknown.

        Nearer to it, branches still share one sphere. A shorter child counts by its last station.
        """
        lumen = self._tree.lumens[child]
        if np.isnan(lumen.diameter).all():
            return 0.0
        away = (lumen.along - lumen.along[0]) / (self._tree.lumens[above].diameter[-1] / 2)
        beyond = (away >= 1.0) & (away <= 3.0)
        return float(lumen.diameter[beyond].mean() if beyond.any() else lumen.diameter[-1])

    def _from(self, stretch: int) -> Iterator[int]:
        """A stretch and those in which its vessel goes on."""
        yield stretch
        # Ends: a child comes after the one above it.
        while (onward := self._onward[stretch]) is not None:
            stretch = onward[0]
            yield stretch
