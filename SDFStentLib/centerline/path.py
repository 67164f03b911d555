"""A place on a centerline, a path along it, and the branches that the path had to choose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from ..geometry import Line
from ..validation import Floats, Points, read_only

Rule = Literal["widest", "straightest", "nearest"]


class JunctionChoice(NamedTuple):
    """A junction where a path downstream chose the widest, the straightest or the nearest branch.

    The nearest branch is chosen for a place that lies within the junction's own sphere.
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
    """A path along a centerline, the inscribed radius (k,) at its points, and the choices made."""

    line: Line
    inscribed_radius: Floats
    choices: tuple[JunctionChoice, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "inscribed_radius", read_only(self.inscribed_radius))

    @property
    def points(self) -> Points:
        """(k, 3) points of the path, mm."""
        return self.line.points

    @property
    def length(self) -> float:
        """Arc length of the path, mm."""
        return float(self.line.arc_lengths[-1])

    def reversed(self) -> CenterlinePath:
        """The same path from its end to its start."""
        return replace(
            self, line=self.line.reversed(), inscribed_radius=self.inscribed_radius[::-1]
        )
