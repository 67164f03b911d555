"""A segment of a vessel, cut off by planes and closed by flat caps, with its faces named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry import (
    NamedFaces,
    Surface,
    across,
    boundary_edges,
    compacted,
    flat_fill,
    signed_volume,
)
from ..validation import Floats, Indices, InputError, Points, Triangles, read_only
from ..vessel import VesselParts
from .open_segment import OpenSegment
from .segment_faces import SegmentFace, segment_faces

UNEVEN = 0.2
"""Distance, in radii, up to which the rim of an open end may leave its plane and be closed flat."""


@dataclass(frozen=True, eq=False)
class Segment:
    """A part of a vessel between planes, closed.

    Attributes
    ----------
    surface : Surface
        Surface of the segment, wound outward, mm.
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
        """Volume of the lumen, mm^3."""
        return signed_volume(self.surface.points, self.surface.triangles)

    @property
    def walls(self) -> frozenset[int]:
        """Numbers of the faces that are wall, those of closed branches included."""
        return frozenset(face.number for face in self.faces if face.kind == "wall")

    @property
    def named_faces(self) -> NamedFaces:
        """The face of every triangle and its name."""
        return NamedFaces(self.face_ids, {face.number: face.name for face in self.faces})


def closed_segment(opened: OpenSegment) -> Segment:
    """The segment, closed by flat caps in each of its planes and where the vessel was open.

    Raises
    ------
    InputError
        An open end that no flat cap closes.
    """
    vessel, mesh = opened.vessel, opened.mesh
    points, triangles, ids = mesh.points, mesh.triangles, vessel.ids[mesh.sources]
    new = int(vessel.ids.max()) + 1
    ends = [
        *zip(opened.rims, opened.planes, strict=True),
        *_open_rims(triangles, opened.rims),
    ]
    inners, caps, count = [points], [triangles], len(points)
    for rim, plane in ends:
        inner, cap = _cap(points, rim, count, vessel, None if plane is None else -plane.normal)
        inners.append(inner)
        caps.append(cap)
        count += len(inner)
    ids = np.r_[ids, np.repeat(new + np.arange(len(ends)), [len(cap) for cap in caps[1:]])]
    closed = Surface(*compacted(np.vstack(inners), np.vstack(caps)), name="segment")
    numbered = {number: plane for number, (_, plane) in enumerate(ends, start=new)}
    return Segment(closed, ids, segment_faces(closed, ids, vessel, numbered))


def _open_rims(triangles: Triangles, rims: Sequence[Indices]) -> Iterator[tuple[Indices, None]]:
    """Rims of open ends that the vessel had before, in the direction of the faces."""
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
    points: Points, rim: Indices, count: int, vessel: VesselParts, normal: Floats | None
) -> tuple[Points, Triangles]:
    """Points within a flat cap, and its triangles; these points are numbered behind `count`
    others."""
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
    number = np.r_[loop, count + np.arange(len(fill.inner))]
    return origin + fill.inner @ plane, number[fill.triangles]
