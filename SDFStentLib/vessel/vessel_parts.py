"""A vessel as it is cut: its surface, caps and wall apart, and its centerline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, Location
from ..geometry import NamedFaces, Surface, oriented_triangles
from ..units import in_file
from ..validation import Indices, Points, as_place, place_words
from .branch_names import branch_names, faces_at_ends
from .tree_around import branch_of
from .vessel_ends import vessel_ends


class VesselParts(NamedTuple):
    """A vessel as it is cut."""

    surface: Surface
    """Wound outward."""
    tree: Centerline
    ids: Indices
    """(m,) of the parts of the surface, by triangle."""
    names: Mapping[int, str]
    """The names of the parts that have one."""
    caps: frozenset[int]
    """The parts that are flat caps; all others are wall."""
    openings: Points
    """(k, 3) middles of flat caps and open ends, mm."""
    branch_names: tuple[str, ...]
    units: str = "mm"
    """Unit of the surface's file, in which places are given, too."""

    def branch_name(self, place: Location) -> str:
        """The name of the branch of the centerline at a place."""
        return self.branch_names[branch_of(self.tree, place)]

    def said(self, point: Points) -> str:
        """A point (3,) in words: where it is, and how far along which branch."""
        place = self.tree.project(point)
        branch = branch_of(self.tree, place)
        place_mm = as_place(point)
        along = place.arc_length - self.tree.arc_length[self.tree.branches[branch][0]]
        return (
            f"{place_words(point)}{in_file(place_mm, self.units)}, {along:.1f} mm along "
            f"{self.branch_names[branch]}"
        )


def vessel_parts(
    surface: Surface,
    tree: Centerline,
    faces: NamedFaces | None = None,
    units: str = "mm",
    given: Sequence[str | None] = (),
) -> VesselParts:
    """A vessel with its flat caps known, by the faces of the model where it has any.

    `units` are those of its file, `given` the names of branches as `branch_names` takes them. A
    flat cap that the model does not tell from the wall gets a number of its own.
    """
    ids = np.ones(len(surface.triangles), np.int64) if faces is None else faces.ids.copy()
    caps = set()
    ends = vessel_ends(surface)
    for end in ends:
        if not len(end.faces):
            continue
        kinds, counts = np.unique(ids[end.faces], return_counts=True)
        number = int(kinds[np.argmax(counts)])
        # Of a face of the model that is a cap most lies in that.
        if counts.max() <= np.count_nonzero(ids == number) - counts.max():
            number = int(ids.max()) + 1
            ids[end.faces] = number
        caps.add(number)
    names = {} if faces is None else dict(faces.names)
    if given:
        at_end = faces_at_ends(surface, tree, NamedFaces(ids))
        called = {at_end.get(int(branch[-1])): given[n] for n, branch in enumerate(tree.branches)}
        names |= {face: name for face, name in called.items() if face is not None and name}
    outward = oriented_triangles(surface.points, surface.wound_triangles.copy(), tree.points)
    return VesselParts(
        Surface(surface.points, outward),
        tree,
        ids,
        names,
        frozenset(caps),
        np.array([end.center for end in ends]).reshape(-1, 3),
        branch_names(surface, tree, faces, given),
        units,
    )
