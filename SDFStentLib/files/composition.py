"""What a file has that is no wall of its own: points of seams, ghosts, triangles a second time."""

from __future__ import annotations

from ..cautions import Caution
from ..geometry import Surface


def composition_warnings(surface: Surface, name: str) -> tuple[Caution, ...]:
    """What was taken as one or left out of a surface as it was read."""
    whole = len(surface.whole.triangles)
    counts = {
        "points-joined": ("points", surface.unshared_points),
        "ghost-cells": ("cells", surface.made_of - whole),
        "triangles-again": ("triangles", whole - len(surface.triangles)),
    }
    return tuple(
        Caution(kind, {what: count}, label=f"{name}: ")
        for kind, (what, count) in counts.items()
        if count
    )
