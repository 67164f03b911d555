"""One tree of a vessel from any lines that a file may hold."""

from __future__ import annotations

from .centerline import Centerline, CenterlinePath, Location
from .junctions import JunctionChoice
from .point_tree import as_parents

__all__ = [
    "Centerline",
    "CenterlinePath",
    "JunctionChoice",
    "Location",
    "as_parents",
]


def __dir__() -> list[str]:
    return __all__
