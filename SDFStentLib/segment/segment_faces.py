"""The faces of a segment: wall, inlet or outlet, and their names."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, face_areas
from ..validation import Floats, Indices, read_only
from ..vessel import VesselParts
from .cut_planes import SAME, CutPlane

Kind = Literal["inlet", "outlet", "wall"]

AT_END = 2.0
"""Largest distance of an end of the centerline from the middle of its cap, in radii."""

LONGEST = 80
"""Largest number of letters of a name, which is that of a file, too."""

_NO_LETTERS = re.compile("[^0-9A-Za-z]+")


class SegmentFace(NamedTuple):
    """A face of a segment, as a solver names its boundaries."""

    number: int
    """Number that its triangles have."""
    name: str
    """Letters, digits and underscores."""
    kind: Kind
    area: float
    """Area, mm^2."""
    center: Floats
    """(3,) center of its area, mm."""
    normal: Floats
    """(3,) mean of its outward unit normals; a unit vector for a flat face."""
    said: str = ""
    """Words that tell it from others of its kind, such as the vessel that ends there."""


HOLE = "hole"
"""Name of a face that closes an opening of the wall where no centerline ends."""


def segment_faces(
    surface: Surface, ids: Indices, vessel: VesselParts, ends: Mapping[int, CutPlane | None]
) -> tuple[SegmentFace, ...]:
    """The named faces of a closed segment, the inlet first and closed openings last.

    Parameters
    ----------
    surface : Surface
    ids : (m,) array of int
        Face number of its triangles.
    vessel : VesselParts
        The vessel from which it was cut. The inlet is the end at the root of its centerline, else
        the end on the root's side.
    ends : mapping of int to CutPlane
        The faces that closed the segment, with their planes. None stands for an opening of before:
        an end of the vessel if its centerline ends there, else a hole, which becomes wall.
    """
    plain = {number: _plain(surface, ids, number) for number in np.unique(ids).tolist()}
    planes = {number: plane for number, plane in ends.items() if plane is not None}
    closed = {number for number, plane in planes.items() if plane.is_closed}
    holes = {n for n in ends if n not in planes and not _is_end(plain[n], vessel.tree)}
    is_cap = vessel.caps.union(ends) - closed - holes
    caps = [number for number in plain if number in is_cap]
    inlet = _inlet({n: plain[n] for n in caps}, planes, vessel.tree)
    found = []
    for number, face in plain.items():
        said = (
            planes[number].name if number in planes else vessel.names.get(number, f"face {number}")
        )
        kind: Kind = "wall" if number not in caps else "inlet" if number == inlet else "outlet"
        label = "closed" if number in closed else HOLE if number in holes else kind
        found.append((label, face._replace(kind=kind, said=said)))
    found.sort(key=lambda one: ("inlet", "outlet", "wall", "closed", HOLE).index(one[0]))
    return _named(found)


def with_inlets(faces: Sequence[SegmentFace], names: Sequence[str]) -> tuple[SegmentFace, ...]:
    """Faces with some ends as inlets, first and by these names; others are outlets.

    The first inlet is called `inlet`, and others after their vessels.
    """
    walls = [face for face in faces if face.kind == "wall"]
    ends = [face for face in faces if face.kind != "wall"]
    ends.sort(key=lambda one: names.index(one.name) if one.name in names else len(names))
    labels = ["inlet", *(len(names) - 1) * ["other inlet"]]
    labels += (len(ends) - len(names)) * ["outlet"]
    told = _named(list(zip(labels, ends, strict=True)))
    kinds: list[Kind] = ["outlet" if label == "outlet" else "inlet" for label in labels]
    return (*(one._replace(kind=kind) for one, kind in zip(told, kinds, strict=True)), *walls)


def _named(faces: Sequence[tuple[str, SegmentFace]]) -> tuple[SegmentFace, ...]:
    """Faces by labels, with names: what only one of them is needs no more words."""
    labels = Counter(label for label, _ in faces)
    taken: Counter[str] = Counter()
    names = []
    for label, face in faces:
        name = label if labels[label] == 1 else f"{label} {face.said}"
        name = _NO_LETTERS.sub("_", name).strip("_")[:LONGEST]
        # Names of files: some systems do not tell large letters from small ones.
        taken[name.casefold()] += 1
        count = taken[name.casefold()]
        names.append(name if count == 1 else f"{name}_{count}")
    return tuple(face._replace(name=name) for name, (_, face) in zip(names, faces, strict=True))


def _inlet(
    caps: Mapping[int, SegmentFace], planes: Mapping[int, CutPlane], tree: Centerline
) -> int:
    """The end at the root of the tree; else the one of the two planes on the root's side."""
    for root in tree.points[tree.roots]:
        for number, cap in caps.items():
            if number not in planes and _is_at(cap, root):
                return number
    start, end = list(planes)[:2]
    places = [tree.project(planes[number].origin) for number in (start, end)]
    fall = places[0].arc_length - places[1].arc_length
    return end if abs(tree.path(*places).length - fall) < SAME else start


def _is_end(cap: SegmentFace, tree: Centerline) -> bool:
    """Whether an end of the tree is near a cap."""
    return any(_is_at(cap, tree.points[tip]) for tip in (*tree.roots, *tree.leaves))


def _is_at(cap: SegmentFace, tip: Floats) -> bool:
    away = float(np.linalg.norm(cap.center - tip))
    return away < AT_END * float(np.sqrt(cap.area / np.pi))


def _plain(surface: Surface, ids: Indices, number: int) -> SegmentFace:
    numbers = np.flatnonzero(ids == number)
    own = surface.triangles[numbers]
    areas = face_areas(surface.points, own)
    total = float(areas.sum())
    center = (areas[:, None] * surface.points[own].mean(axis=1)).sum(axis=0) / total
    normal = (areas[:, None] * surface.face_normals[numbers]).sum(axis=0) / total
    return SegmentFace(number, "", "wall", total, read_only(center), read_only(normal))
