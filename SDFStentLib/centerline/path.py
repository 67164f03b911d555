"""A place on a centerline, a way along it, and where that had to choose a branch."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from ..geometry import Line
from ..validation import Floats, Points, read_only

Rule = Literal["widest", "straightest", "nearest"]


class JunctionChoice(NamedTuple):
    """A junction where a path downstream chose the widest, the straightest or the nearest branch.

    The nearest is that of a place that lies within the junction's own sphere.
    """

    point: Floats
    rule: Rule


@dataclass(frozen=True, eq=False)
class Location:
    """A place on a centerline: on the segment that leads to point `index` from its parent.

    `fraction` runs from 0 at the parent to 1 at the point; `distance` (mm) is that of the point
    which was projected; `arc_length` (mm) counts from the root; `inscribed_radius` (mm) may be NaN.
    """

    point: Floats
    distance: float
    index: int
    fraction: float
    arc_length: float
    inscribed_radius: float


@dataclass(frozen=True)
class CenterlinePath:
    """A way along a centerline, the inscribed radius (k,) at its points, and how it was chosen."""

    line: Line
    inscribed_radius: Floats
    choices: tuple[JunctionChoice, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "inscribed_radius", read_only(self.inscribed_radius))

    @property
    def points(self) -> Points:
        """(k, 3) mm."""
        return self.line.points

    @property
    def length(self) -> float:
        """Arc length, mm."""
        return float(self.line.arc_lengths[-1])

    def reversed(self) -> CenterlinePath:
        """The same way from its end to its start."""
        return replace(
            self, line=self.line.reversed(), inscribed_radius=self.inscribed_radius[::-1]
        )
