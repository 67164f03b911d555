"""A segment of a vessel, cut off by planes and closed by flat caps, with its faces named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry import (
    CutSurface,
    NamedFaces,
    Surface,
    across,
    boundary_edges,
    compacted,
    component_labels,
    cut_along,
    flat_fill,
    paired_sides,
    section_around,
    signed_volume,
)
from ..validation import Floats, Indices, InputError, Points, Triangles, read_only
from .cut_planes import CutPlane
from .segment_faces import SegmentFace, segment_faces
from .vessel_parts import VesselParts

UNEVEN = 0.2
"""An open end is closed flat when its rim leaves its plane by less than so many radii."""


@dataclass(frozen=True, eq=False)
class Segment:
    """A part of a vessel between planes, closed.

    Attributes
    ----------
    surface : Surface
        Outward, mm.
    face_ids : (m,) array of int
        `SegmentFace.number` of every triangle.
    faces : tuple of SegmentFace
        The inlet, the outlets, and the parts of the wall.
    """

    surface: Surface
    face_ids: Indices
    faces: tuple[SegmentFace, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "face_ids", read_only(self.face_ids))

    @property
    def volume(self) -> float:
        """Of the lumen, mm^3."""
        return signed_volume(self.surface.points, self.surface.triangles)

    @property
    def walls(self) -> frozenset[int]:
        """Numbers of the faces that are wall, closed branches too."""
        return frozenset(face.number for face in self.faces if face.kind == "wall")

    @property
    def named_faces(self) -> NamedFaces:
        """The face of every triangle and its name."""
        return NamedFaces(self.face_ids, {face.number: face.name for face in self.faces})


def cut_segment(vessel: VesselParts, planes: Sequence[CutPlane]) -> Segment:
    """The part of a vessel that planes bound, closed by a flat cap in each.

    Parameters
    ----------
    vessel : VesselParts
        Open ends within the segment are closed, too.
    planes : sequence of CutPlane
        At its start, at its end, and before branches that are closed. They may be those of another
        state of the vessel, which is then cut at the same places.

    Raises
    ------
    InputError
        A plane that meets the vessel in no closed curve, or planes that do not bound one segment.
    """
    mesh, rims = _cut(vessel, planes)
    kept = _between(mesh, rims, vessel, planes)
    triangles, ids = mesh.triangles[kept], vessel.ids[mesh.sources[kept]]
    points, new = mesh.points, int(vessel.ids.max()) + 1
    ends = [*zip(rims, planes, strict=True), *_open_rims(triangles, rims)]
    for number, (rim, plane) in enumerate(ends, start=new):
        inner, cap = _cap(points, rim, vessel, None if plane is None else -plane.normal)
        points, triangles = np.vstack([points, inner]), np.vstack([triangles, cap])
        ids = np.r_[ids, np.full(len(cap), number)]
    closed = Surface(*compacted(points, triangles), name="segment")
    numbered = {number: plane for number, (_, plane) in enumerate(ends, start=new)}
    return Segment(closed, ids, segment_faces(closed, ids, vessel, numbered))


def _cut(vessel: VesselParts, planes: Sequence[CutPlane]) -> tuple[CutSurface, list[Indices]]:
    """The surface cut along every plane, and the curves of the cuts."""
    surface = vessel.surface
    none = np.zeros(0, np.int64)
    all_triangles = np.arange(len(surface.triangles))
    mesh = CutSurface(surface.points, surface.triangles, all_triangles, none)
    rims: list[Indices] = []
    for plane in planes:
        section = section_around(mesh.points, mesh.triangles, plane.origin, plane.normal)
        if section is None or not section.is_closed:
            raise _refused(vessel, plane, "meets the vessel in no closed curve")
        if np.isin(mesh.triangles[section.triangles], np.concatenate([none, *rims])).any():
            raise _refused(vessel, plane, "meets another one within the vessel")
        cut = cut_along(mesh.points, mesh.triangles, section, plane.origin, plane.normal)
        if not len(cut.rim):
            raise _refused(vessel, plane, "meets the vessel in a curve that touches itself")
        rims.append(cut.rim)
        mesh = cut._replace(sources=mesh.sources[cut.sources])
    return mesh, rims


def _between(
    mesh: CutSurface, rims: list[Indices], vessel: VesselParts, planes: Sequence[CutPlane]
) -> Indices:
    """The triangles that hang together above every plane."""
    start, end = (np.concatenate(one) for one in (rims, [np.roll(rim, -1) for rim in rims]))
    sides = np.stack([mesh.triangles.ravel(), mesh.triangles[:, [1, 2, 0]].ravel()], axis=1)
    count = len(mesh.points)
    keys, rim_keys = sides[:, 0] * count + sides[:, 1], start * count + end
    is_cut = np.isin(keys, rim_keys) | np.isin(sides[:, 1] * count + sides[:, 0], rim_keys)
    pairs = paired_sides(mesh.triangles)
    pairs = pairs[~is_cut[pairs[:, 0]]] // 3
    label = component_labels(len(mesh.triangles), pairs[:, 0], pairs[:, 1])
    order = np.argsort(keys)
    above = label[order[np.searchsorted(keys, rim_keys, sorter=order)] // 3]
    below = label[order[np.searchsorted(keys, end * count + start, sorter=order)] // 3]
    if (above != above[0]).any() or (below == above[0]).any():
        raise _refused(vessel, planes[0], "and the other ones do not bound one segment")
    return np.flatnonzero(label == above[0])


def _open_rims(triangles: Triangles, rims: list[Indices]) -> Iterator[tuple[Indices, None]]:
    """Open ends that were there before, in the direction of the faces."""
    following = dict(boundary_edges(triangles).tolist())
    for rim in rims:
        for point in rim.tolist():
            following.pop(point, None)
    # Ends: each round takes points out.
    while following:
        first = next(iter(following))
        loop: list[int] = [first]
        # Ends: each step takes a point out.
        while (point := following.pop(loop[-1], first)) != first:
            loop.append(point)
        yield np.array(loop), None


def _cap(
    points: Points, rim: Indices, vessel: VesselParts, normal: Floats | None
) -> tuple[Points, Triangles]:
    """Points within a flat cap, and its triangles in the numbers of all points and then these."""
    loop = rim[::-1]
    corners = points[loop]
    origin = corners.mean(axis=0)
    if normal is None:
        normal = np.cross(corners - origin, np.roll(corners, -1, axis=0) - origin).sum(axis=0)
        normal /= np.linalg.norm(normal)
    plane = across(normal[None])[0]
    polygon = (corners - origin) @ plane.T
    heights = np.abs((corners - origin) @ normal)
    fill = flat_fill(polygon)
    if fill is None or heights.max() > UNEVEN * np.linalg.norm(polygon, axis=1).max():
        raise InputError(
            f"segment: expected an end near {vessel.said(origin)}, that a flat cap closes, its rim "
            "is not flat or crosses itself; close it before, or choose other places."
        )
    number = np.r_[loop, len(points) + np.arange(len(fill.inner))]
    return origin + fill.inner @ plane, number[fill.triangles]


def _refused(vessel: VesselParts, plane: CutPlane, what: str) -> InputError:
    return InputError(
        f"segment: expected planes that cut the vessel in one closed curve each, the one at "
        f"{vessel.said(plane.origin)}, {what}; choose other places."
    )
