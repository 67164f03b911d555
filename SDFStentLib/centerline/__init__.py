"""One tree of a vessel from any lines that a file may hold."""

from __future__ import annotations

from .centerline import Centerline
from .junctions import JunctionChoice
from .path import CenterlinePath, Location
from .point_tree import points_between

__all__ = [
    "Centerline",
    "CenterlinePath",
    "JunctionChoice",
    "Location",
    "points_between",
]


def __dir__() -> list[str]:
    return __all__
