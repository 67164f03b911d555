"""One tree of a vessel from any lines that a file may hold."""

from __future__ import annotations

from .centerline import Centerline, CenterlinePath, Location
from .junctions import JunctionChoice

__all__ = [
    "Centerline",
    "CenterlinePath",
    "JunctionChoice",
    "Location",
]


def __dir__() -> list[str]:
    return __all__
