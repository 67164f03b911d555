"""A vessel as it is cut: its surface, caps and wall apart, and its centerline."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import NamedFaces, Surface, oriented_triangles
from ..validation import Indices
from .branch_names import branch_names
from .vessel_ends import vessel_ends

MOSTLY = 0.5
"""A face of the model is a cap when more of it than this lies in one flat cap."""


class VesselParts(NamedTuple):
    """A vessel as it is cut."""

    surface: Surface
    """Wound outward."""
    tree: Centerline
    ids: Indices
    """(m,) of the parts of the surface, by triangle."""
    names: Mapping[int, str]
    """Of the parts that have one."""
    caps: frozenset[int]
    """The parts that are flat caps; all others are wall."""
    branch_names: tuple[str, ...]


def vessel_parts(
    surface: Surface, tree: Centerline, faces: NamedFaces | None = None
) -> VesselParts:
    """A vessel with its flat caps known, by the faces of the model where it has any.

    A flat cap that the model does not tell from the wall gets a number of its own.
    """
    ids = np.ones(len(surface.triangles), np.int64) if faces is None else faces.ids.copy()
    caps = set()
    for end in vessel_ends(surface):
        if not len(end.faces):
            continue
        kinds, counts = np.unique(ids[end.faces], return_counts=True)
        number = int(kinds[np.argmax(counts)])
        if counts.max() <= MOSTLY * np.count_nonzero(ids == number):
            number = int(ids.max()) + 1
            ids[end.faces] = number
        caps.add(number)
    outward = oriented_triangles(surface.points, surface.wound_triangles.copy(), tree.points)
    return VesselParts(
        Surface(surface.points, outward),
        tree,
        ids,
        {} if faces is None else dict(faces.names),
        frozenset(caps),
        branch_names(surface, tree, faces),
    )
