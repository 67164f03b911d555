"""The ends of a vessel between which flow is solved, and tube where vessel is missing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..certificate import check_surface
from ..geometry import (
    Line,
    Surface,
    boundary_edges,
    compacted,
    face_areas,
    nearest_distances,
    norm,
    state_of,
)
from ..segment import PlaneFinder, Segment
from ..treatment import Vessel
from ..validation import InputError, Points, Triangles, as_place, place_words
from ..vessel import vessel_parts
from .remesh import Axis

MOVED = 1e-3
"""The distance from which on the wall has moved, mm."""

ABOVE, BELOW = 2.0, 4.0
"""Diameters of vessel between the wall that moved and the planes: what a plane needs to be met by
the same flow in both states, and a jet to lose a good part of itself."""

SPACING = 0.5
"""The distance of places on the centerline, mm."""


class FlowEnds(NamedTuple):
    """The two ends of a segment, and what vessel is missing there."""

    start: Points
    """(3,) mm."""
    end: Points
    missing: tuple[float, float]
    """Length of tube that would have to come to it at each, mm."""


def ends_beyond(before: Vessel, after: Vessel, axis: Axis, units: str = "mm") -> FlowEnds:
    """Places up- and downstream of the wall that moved, at which planes meet only this vessel.

    Each is the first one beyond `ABOVE` and `BELOW` diameters where a plane meets the vessel alone
    in both states; where the vessel ends earlier, the last one before its end.

    Raises
    ------
    InputError
        Other triangles after than before, no wall that moved, or no place for a plane.
    """
    tree = before.centerline
    assert tree is not None
    way, first, last = _changed(before, after, tree, axis)
    finders = [
        PlaneFinder(vessel_parts(one.surface, tree, one.faces, units)) for one in (before, after)
    ]
    ends, missing = [], []
    for word, line, at, needed in (
        ("start", way[::-1], Line(way).arc_lengths[-1] - first, ABOVE),
        ("end", way, last, BELOW),
    ):
        needed *= 2 * float(axis.radius_at(Line(line).at([at]))[0])
        found = next(_places(finders, line, at, needed), None)
        if found is None:
            begin = Line(line).at([at])[0]
            raise InputError(
                f"segment {word}: expected a place beyond the stent where a plane meets only this "
                f"vessel, found none from {place_words(begin)}",
                place=as_place(begin),
                end=" on; name both ends.",
            )
        ends.append(Line(line).at([found])[0])
        missing.append(max(0.0, at + needed - found))
    return FlowEnds(ends[0], ends[1], (missing[0], missing[1]))


def _changed(
    before: Vessel, after: Vessel, tree: Centerline, axis: Axis
) -> tuple[Points, float, float]:
    """A line (k, 3) through the vessel that was widened, and from where to where on it, mm.

    Side branches only move: the line is that along which radii grow the most in all, and then the
    longest.
    """
    treated = state_of(before.surface, after.surface, "treated vessel").points
    moved = norm(treated - before.surface.points) > MOVED
    if not moved.any():
        raise InputError(
            "treated vessel: expected a wall that moved, got the same one; give the surface that "
            "was deployed, or name both ends of the segment."
        )
    numbers = np.unique(axis.nearest(before.surface.points[moved]))
    spots = axis.points[numbers]
    grown = nearest_distances(spots, treated) - nearest_distances(spots, before.surface.points)
    places = [tree.project(spot) for spot in spots]

    def gain(leaf: int) -> tuple[float, float]:
        own = np.isin([place.index for place in places], tree.ancestry(leaf))
        return float(grown[own].sum().round(3)), float(tree.arc_length[leaf])

    leaf = max(tree.leaves.tolist(), key=gain)
    line = tree.ancestry(leaf)
    along = [place.arc_length for place in places if place.index in line]
    return tree.points[line], min(along), max(along)


def _places(
    finders: list[PlaneFinder], line: Points, start: float, needed: float
) -> Iterator[float]:
    """Arc lengths of a line at which planes are free: from the needed one on, else before it."""
    end = float(Line(line).arc_lengths[-1])
    beyond = np.arange(start + needed, end, SPACING)
    before = np.arange(min(start + needed, end) - SPACING, start, -SPACING)
    for at in np.r_[beyond, before].tolist():
        rest = line[Line(line).arc_lengths < at - SPACING / 10]
        back = np.vstack([Line(line).at([at]), rest[::-1]])
        normal = finders[0].direction(Line(back))
        if not any(finder.fault(back[0], normal) for finder in finders):
            yield at


LAYERS_PER_RADIUS = 2


def extended(segment: Segment, name: str, by: float) -> Segment | None:
    """Segment with one end drawn out along its normal.

    Parameters
    ----------
    segment : Segment
    name : str
        Name of the inlet or outlet.
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
    """Triangles between the sides (k, 2) of one ring and those of the next."""
    (a, b), (c, d) = low.T, high.T
    return np.vstack([np.column_stack([a, b, d]), np.column_stack([a, d, c])])


def _wall_at(segment: Segment, rim: Triangles) -> int:
    """The face of the wall that has the most area beside a rim."""
    triangles = segment.surface.triangles
    beside = np.isin(triangles, rim).any(axis=1) & np.isin(segment.face_ids, [*segment.walls])
    areas = face_areas(segment.surface.points, triangles[beside])
    return int(np.bincount(segment.face_ids[beside], areas).argmax())
