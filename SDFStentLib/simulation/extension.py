"""A straight tube at an end of a segment, in the place of vessel that is missing there."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..certificate import check_surface
from ..geometry import Surface, boundary_edges, compacted, face_areas
from ..segment import Segment
from ..validation import Triangles

LAYERS_PER_RADIUS = 2


def extended(segment: Segment, name: str, by: float) -> Segment | None:
    """A segment of which one end is drawn out along its normal.

    Parameters
    ----------
    segment : Segment
    name : str
        Of the inlet or outlet.
    by : float
        mm.

    Returns
    -------
    Segment or None
        None where there is no room: the tube would cross the vessel.
    """
    (face,) = (one for one in segment.faces if one.name == name)
    points, triangles = segment.surface.points, segment.surface.triangles
    is_cap = segment.face_ids == face.number
    radius = float(np.sqrt(face.area / np.pi))
    count = max(1, round(LAYERS_PER_RADIUS * by / radius))
    rim = boundary_edges(triangles[is_cap])
    nodes, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(rim.shape)
    size = len(points)
    layers = [
        nodes,
        *(size + k * len(nodes) + np.arange(len(nodes)) for k in range(count)),
    ]
    rings = [points[nodes] + by * k / count * face.normal for k in range(1, count + 1)]
    tube = [_strip(low[ends], high[ends]) for low, high in pairwise(layers)]
    # The cap goes to the end of the tube, with its inner points.
    inner = np.setdiff1d(triangles[is_cap], nodes)
    number = np.arange(size)
    number[nodes] = layers[-1]
    number[inner] = size + count * len(nodes) + np.arange(len(inner))
    moved = np.vstack([points, *rings, points[inner] + by * face.normal])
    faces = np.vstack([triangles[~is_cap], *tube, number[triangles[is_cap]]])
    strips = sum(len(one) for one in tube)
    ids = np.r_[
        segment.face_ids[~is_cap],
        np.full(strips, _wall_at(segment, nodes)),
        np.full(int(is_cap.sum()), face.number),
    ]
    surface = Surface(*compacted(moved, faces), name="segment")
    if not check_surface(surface).passed:
        return None
    center = face.center + by * face.normal
    told = tuple(one._replace(center=center) if one is face else one for one in segment.faces)
    return replace(segment, surface=surface, face_ids=ids, faces=told)


def _strip(low: Triangles, high: Triangles) -> Triangles:
    """Between the sides (k, 2) of one ring and those of the next."""
    (a, b), (c, d) = low.T, high.T
    return np.vstack([np.column_stack([a, b, d]), np.column_stack([a, d, c])])


def _wall_at(segment: Segment, rim: Triangles) -> int:
    """The face of the wall that has the most area beside a rim."""
    triangles = segment.surface.triangles
    beside = np.isin(triangles, rim).any(axis=1) & np.isin(segment.face_ids, [*segment.walls])
    areas = face_areas(segment.surface.points, triangles[beside])
    return int(np.bincount(segment.face_ids[beside], areas).argmax())
