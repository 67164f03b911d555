"""The wall round an axis as seen from the axis: the length of every ray across it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..geometry import (
    Line,
    Surface,
    faces_at,
    frames,
    in_box,
    may_meet_box,
    nearest_distances,
    product,
    ranges,
    search_tree,
)
from ..validation import Flags, Floats, Indices, Points, Triangles, read_only
from .tolerances import PAIRS, ROUNDING

RAYS = 144
"""Number of rays at each station, 2.5 degrees apart."""

RAYS_APART = 0.5
"""Distance of the stations of rays along a vessel, mm; less in a narrow one."""

_DECIDE = 6
"""Places of an axis that are looked at first."""

_FEW = 2000
"""Number of triangles below which a surface is coarse, and they are selected by their boxes."""


@dataclass(frozen=True)
class WallMap:
    """Length of the rays from `centers` to the surface, by station and angle.

    A ray lies in the plane of its station, across the axis. Its length is infinite if it meets
    nothing.
    """

    arc_length: Floats
    """(n,) positions of the stations on the axis, equally spaced, mm."""
    centers: Points
    """(n, 3) origins of the rays, mm."""
    frames: Floats
    """(n, 3, 3) direction of the axis, then the two directions of the plane."""
    distance: Floats
    """(n, RAYS) lengths of the rays, mm."""
    triangle: Indices
    """(n, RAYS) triangle that the ray meets; -1 if it meets none."""

    def __post_init__(self) -> None:
        for name in ("arc_length", "centers", "frames", "distance", "triangle"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def spacing(self) -> float:
        """Distance of the stations, mm."""
        return float(self.arc_length[1] - self.arc_length[0])


class NearWall(NamedTuple):
    """The part of a surface near an axis: rays that leave it are as good as infinite."""

    points: Points
    """(k, 3) points, mm."""
    triangles: Triangles
    """(m, 3) indices of these points."""
    point_ids: Indices
    """(k,) indices of the points in the surface."""
    triangle_ids: Indices
    """(m,) indices of the triangles in the surface."""


_trees: WeakKeyDictionary[Surface, Any] = WeakKeyDictionary()


def corner_tree(surface: Surface) -> Any:
    """Search tree of a surface's points, kept as long as that is in use: every stent asks for it,
    before and after."""
    if (tree := _trees.get(surface)) is None:
        tree = _trees[surface] = search_tree(surface.points)
    return tree


def near_wall(surface: Surface, axis: Points, reach: float) -> NearWall:
    """The triangles with a corner within `reach` mm of some points (n, 3)."""
    low, high = axis.min(axis=0) - reach, axis.max(axis=0) + reach
    inner = np.flatnonzero(in_box(surface.points, low, high))
    is_near = np.zeros(len(surface.points), dtype=bool)
    is_near[inner[_within(surface.points.take(inner, axis=0), axis, reach)]] = True
    # A long triangle may have all corners far.
    kept = faces_at(is_near, surface.corners.T)
    if len(surface.triangles) < _FEW:
        kept |= may_meet_box(surface.points, surface.triangles, low, high)
    ids = np.flatnonzero(kept)
    used = np.zeros(len(surface.points), dtype=bool)
    corners = surface.triangles.take(ids, axis=0)
    used[corners] = True
    number = np.cumsum(used) - 1
    point_ids = np.flatnonzero(used)
    points = surface.points.take(point_ids, axis=0)
    return NearWall(points, number.take(corners), point_ids, ids)


def _within(points: Points, axis: Points, reach: float) -> Flags:
    """Whether each point (k,) is nearer than `reach` mm to one of an axis (n, 3)."""
    # Imported late: a first frame should not pay for scipy.
    from scipy.spatial import cKDTree

    # A few places of the axis decide on most points.
    few = axis[np.linspace(0, len(axis) - 1, min(len(axis), _DECIDE)).astype(np.int64)]
    gap = float(nearest_distances(axis, few).max())
    columns = np.ascontiguousarray(points.T)
    squared = np.full(len(points), np.inf)
    for place in few:
        x, y, z = columns - place[:, None]
        squared = np.minimum(squared, x * x + y * y + z * z)
    is_near = squared < (reach * (1 - ROUNDING)) ** 2
    doubtful = np.flatnonzero(~is_near & (squared < ((reach + gap) * (1 + ROUNDING)) ** 2))
    distance, _ = cKDTree(axis).query(points[doubtful], distance_upper_bound=reach)
    is_near[doubtful] = np.isfinite(distance)
    return is_near


def wall_map(wall: NearWall, axis: Line, *, spacing: float, window: float) -> WallMap:
    """Rays from an axis to the wall near it.

    Parameters
    ----------
    wall : NearWall
    axis : Line
        Axis in the lumen.
    spacing : float
        Spacing of the stations, mm.
    window : float
        Length of axis over which its direction is taken, mm; smaller wiggles do not turn a plane.
    """
    return cuts_across(wall, axis, spacing=spacing, window=window).seen()


def cuts_across(wall: NearWall, axis: Line, *, spacing: float, window: float) -> WallCuts:
    """The cuts for `wall_map`."""
    centers = axis.resampled(spacing).points
    at = np.linspace(0.0, axis.arc_lengths[-1], len(centers))
    return WallCuts(wall, at, centers, frames_along(axis, len(centers), window))


def rays_from(wall: NearWall, arc_length: Floats, centers: Points, along: Floats) -> WallMap:
    """The map from given centers (n, 3), in the planes of given frames (n, 3, 3)."""
    return WallCuts(wall, arc_length, centers, along).seen()


class WallCuts:
    """The cuts of the wall near an axis with planes across it, which can be seen from any place in
    these planes."""

    def __init__(self, wall: NearWall, arc_length: Floats, centers: Points, along: Floats) -> None:
        self.wall, self.arc_length, self.centers, self.along = wall, arc_length, centers, along
        block = max(1, PAIRS // max(1, len(wall.triangles)))
        self._blocks = [slice(first, first + block) for first in range(0, len(centers), block)]
        self._cuts = [_cut_segments(wall, centers[rows], along[rows]) for rows in self._blocks]

    def seen(self, shift: Floats | None = None) -> WallMap:
        """The map from the centers, or from places (n, 2) in their planes, mm."""
        if shift is None:
            shift = np.zeros((len(self.centers), 2))
        distance = np.full((len(self.centers), RAYS), np.inf)
        triangle = np.full((len(self.centers), RAYS), -1)
        for rows, cuts in zip(self._blocks, self._cuts, strict=True):
            found = _first_hits(cuts, shift[rows])
            distance[rows] = found[0]
            is_met = np.isfinite(found[0])
            triangle[rows][is_met] = self.wall.triangle_ids[found[1][is_met]]
        centers = self.centers + np.einsum("ij,ijk->ik", shift, self.along[:, 1:])
        return WallMap(self.arc_length, centers, self.along, distance, triangle)


def frames_along(axis: Line, count: int, window: float) -> Floats:
    """Frames (count, 3, 3) of little twist at equal arc lengths, directions over a window."""
    at = np.linspace(0.0, float(axis.arc_lengths[-1]), count)
    directions = axis.at(at + window / 2) - axis.at(at - window / 2)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # The polyline whose segments have these directions gives frames along them.
    return frames(Line(np.cumsum(np.concatenate([np.zeros((1, 3)), directions]), axis=0)))[:-1]


def ray_angles() -> Floats:
    """Angles (RAYS,) of the rays about the axis, from a plane's first direction to its second."""
    return np.arange(RAYS, dtype=np.float64) * (2 * np.pi / RAYS)


class _Segments(NamedTuple):
    """The segments in which some planes cut a wall."""

    station: Indices
    """(k,) the plane of each segment."""
    start: Floats
    end: Floats
    """(2, k) ends in the plane's own directions, from its center."""
    owner: Indices
    """(k,) the triangle, by its index in the wall."""


def _first_hits(cuts: _Segments, shift: Floats) -> tuple[Floats, Indices]:
    """The lengths (n, RAYS) of the rays from places (n, 2) in some planes, and the triangles that
    they meet first.

    Triangles are given by their index in the wall; it means nothing if a ray meets none.
    """
    station, start, end, owner = cuts
    here = shift.take(station, axis=0).T
    start, end = start - here, end - here
    first = np.arctan2(start[1], start[0])
    turn = np.arctan2(end[1], end[0]) - first
    turn = (turn + np.pi) % (2 * np.pi) - np.pi
    step = 2 * np.pi / RAYS
    low = np.ceil(np.minimum(first, first + turn) / step).astype(np.int64)
    counts = np.ceil(np.maximum(first, first + turn) / step).astype(np.int64) - low
    segment = np.repeat(np.arange(len(station)), counts)
    ray = ranges(low, counts) % RAYS
    cosine, sine = np.cos(ray_angles())[ray], np.sin(ray_angles())[ray]
    side = end - start
    across = (start[0] * side[1] - start[1] * side[0])[segment]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = across / (cosine * side[1][segment] - sine * side[0][segment])
    reach = np.where(reach > 0, reach, np.inf)
    cell = station[segment] * RAYS + ray
    distance = np.full(len(shift) * RAYS, np.inf)
    np.minimum.at(distance, cell, reach)
    triangle = np.zeros(len(distance), dtype=np.int64)
    is_first = np.isfinite(reach) & (reach == distance[cell])
    triangle[cell[is_first]] = owner[segment[is_first]]
    return distance.reshape(-1, RAYS), triangle.reshape(-1, RAYS)


def _cut_segments(wall: NearWall, centers: Points, along: Floats) -> _Segments:
    """The segments that planes across the first directions of some frames (n, 3, 3) cut out of a
    wall."""
    normals = along[:, 0]
    heights = product(wall.points, normals.T) - np.einsum("ij,ij->i", normals, centers)
    # A bit for each station: eight are compared at once. Rows of whole bytes are packed as one.
    is_above = np.zeros((len(heights), -(-len(centers) // 8) * 8), dtype=bool)
    np.greater_equal(heights, 0, out=is_above[:, : len(centers)])
    above = np.packbits(is_above).reshape(len(heights), -1)
    sides = [above.take(wall.triangles[:, k], axis=0) for k in range(3)]
    is_cut = (sides[0] ^ sides[1]) | (sides[1] ^ sides[2])
    # Over rows of a few bytes NumPy takes several times longer.
    cut = np.flatnonzero(np.ascontiguousarray(is_cut.T).any(axis=0))
    each = np.unpackbits(is_cut.take(cut, axis=0), axis=1, count=len(centers)).view(bool)
    station, row = np.divmod(np.flatnonzero(np.ascontiguousarray(each.T)), len(cut))
    owner = cut.take(row)
    rows = wall.triangles.take(owner, axis=0)
    # What is at a corner's height over a plane, by one number for both.
    columns, flat = len(centers), heights.ravel()
    first, second, third = (flat.take(rows[:, k] * columns + station) >= 0 for k in range(3))
    # The corner that is alone on its side, then the two others.
    alone = np.where(second == third, 0, np.where(first == third, 1, 2))
    each = np.arange(len(rows))
    apex = rows[each, alone]
    plane, origin = along[:, 1:].take(station, axis=0), centers.take(station, axis=0)
    ends = []
    for shift in (1, 2):
        other = rows[each, (alone + shift) % 3]
        # In the order of their numbers, so that both triangles of an edge find the same point.
        low, high = np.minimum(apex, other), np.maximum(apex, other)
        below = flat.take(low * columns + station)
        over = flat.take(high * columns + station)
        share = below / (below - over)
        from_low = wall.points.take(low, axis=0)
        place = from_low + share[:, None] * (wall.points.take(high, axis=0) - from_low)
        ends.append(np.einsum("nkj,nj->kn", plane, place - origin))
    return _Segments(station, ends[0], ends[1], owner)
