"""How wide the vessel beyond a stent and its branches are, before and after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..geometry import (
    Surface,
    arc_lengths,
    closest_points,
    cut,
    frames,
    length,
    resampled,
    tangents,
    without_repeats,
)
from ..validation import Floats, Points, read_only
from .cross_section import equivalent_diameters
from .cut_sections import SUSPECT
from .expected_wall import across_alone, far_reach
from .extended_axis import ExtendedAxis
from .inscribed import inscribed_spheres
from .metrics import DiameterProfile, diameter_profile
from .ostia import Ostium
from .wall_map import RAYS, near_wall, rays_from

NOTICEABLE = 0.05
"""Share of a diameter that is lost and worth a word."""

MEASURED = 20.0
"""Length of a neighbor that is looked at, mm."""

_SPACING = 1.0

_MEASURED_AT = 3
"""Stations of a neighbor at which it is measured."""

_MOTION = 0.01
"""Motion of the wall that no diameter tells, in distances from the way to the wall."""

_BESIDE = 1.5
"""Wall that matters to a station is nearer than so many times the nearest."""


@dataclass(frozen=True)
class NeighborLumen:
    """A branch, or the vessel beyond an end of the stent, before and after treatment. All mm."""

    name: str
    path: Points
    """(n, 3) from the stent on."""
    distance: float
    """Along the path to where it lost most,"""
    before: float
    """its diameter there before"""
    after: float
    """and after treatment; NaN where it could not be measured."""
    by_area: bool
    """Whether these are equivalent diameters (of the circle of the same area), else inscribed."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", read_only(self.path))

    @property
    def loss(self) -> float:
        """Share of the diameter that is lost; negative where it is wider everywhere."""
        return 1 - self.after / self.before

    @property
    def is_narrowed(self) -> bool:
        """Whether it lost more than can be passed over."""
        return self.loss > NOTICEABLE

    def caution(self) -> Caution:
        """What to know of a lumen that is narrowed."""
        return Caution(
            "neighbor-narrowed",
            {
                "name": self.name,
                "before_mm": self.before,
                "after_mm": self.after,
                "diameter": "equivalent" if self.by_area else "inscribed",
                "percent": 100 * self.loss,
                "distance_mm": self.distance,
            },
        )


def profile_around(
    surface: Surface, axis: ExtendedAxis, spacing: float = _SPACING
) -> DiameterProfile:
    """Diameters along a stent and beyond both of its ends.

    Arc lengths count from the proximal end of the stent: negative proximal of it. See
    `diameter_profile` for the parameters.
    """
    profile = diameter_profile(surface, axis.points, spacing)
    return replace(profile, arc_length=profile.arc_length - axis.before)


def neighbor_lumens(
    before: Surface,
    after: Surface,
    axis: ExtendedAxis,
    ostia: Sequence[Ostium],
    centerline: Centerline | None = None,
) -> tuple[NeighborLumen, ...]:
    """The vessel beyond both ends of a stent, then its branches, where their wall has moved.

    Parameters
    ----------
    before, after : Surface
        mm; the same triangles.
    axis : ExtendedAxis
        Of the stent.
    ostia : sequence of Ostium
        `find_ostia` of the surface before.
    centerline : Centerline, optional
        Before treatment. Without it branches are not measured: the way into them is unknown.
    """
    ways, first = [], axis.before + axis.stent_length
    if axis.before > _SPACING:
        start = cut(axis.points, 0.0, axis.before)[::-1]
        ways.append(("the vessel proximal of the stent", start))
    if axis.after > _SPACING:
        ways.append(("the vessel distal of the stent", cut(axis.points, first, np.inf)))
    for ostium in ostia:
        own = None if centerline is None else branch_way(centerline, axis, ostium)
        if own is not None:
            ways.append((ostium.name, own))
    parts = ((name, _disturbed(before, after, way)) for name, way in ways)
    return tuple(
        _compared(name, way, start, before, after)
        for name, (start, way) in parts
        if length(way) > _SPACING
    )


def _disturbed(before: Surface, after: Surface, way: Points) -> tuple[float, Points]:
    """The part of a way (n, 3) whose wall has moved, and where on the way it begins, mm."""
    from scipy.spatial import KDTree

    motion = np.linalg.norm(after.points - before.points, axis=1)
    moved = np.flatnonzero(motion > 0)
    if len(way) < 2 or length(way) <= _SPACING or not len(moved):
        return 0.0, way[:0]
    stations = resampled(way, _SPACING)
    wall = KDTree(before.points).query(stations)[0]
    beside = KDTree(before.points[moved]).query_ball_point(stations, _BESIDE * wall + _SPACING)
    largest = np.array([motion[moved[own]].max(initial=0.0) for own in beside])
    near = largest > _MOTION * wall
    rows = np.flatnonzero(near)
    if not len(rows):
        return 0.0, way[:0]
    step = length(way) / (len(stations) - 1)
    start = max(rows[0] - 1, 0) * step
    return start, cut(way, start, (rows[-1] + 1) * step)


def branch_way(tree: Centerline, axis: ExtendedAxis, ostium: Ostium) -> Points | None:
    """The centerline of the branch behind an ostium, from there on; None when there is none.

    Of the ways from the axis to the ends of the tree it is the one that passes the opening
    nearest to its middle, from its nearest point on.
    """
    best: tuple[float, Points] | None = None
    ends = np.r_[tree.leaves, tree.roots]
    for end in ends:
        for stop in (axis.points[0], axis.points[-1]):
            line = tree.path(tree.project(stop), tree.project(tree.points[end])).points
            apart = closest_points(axis.points, line).distances
            # Only the part that leaves the axis for good is a branch.
            on_axis = np.flatnonzero(apart < 0.5 * _size(ostium))
            if len(on_axis) and on_axis[-1] == len(line) - 1:
                continue
            own = line[on_axis[-1] if len(on_axis) else 0 :]
            if len(without_repeats(own)) < 2:
                continue
            found = closest_points(own, ostium.center[None])
            if best is None or found.distances[0] < best[0] - 1e-6:
                first = float(found.arc_lengths[0])
                if length(own) - first > _SPACING:
                    best = float(found.distances[0]), cut(own, first, first + MEASURED)
    return None if best is None or best[0] > _size(ostium) else best[1]


def _size(ostium: Ostium) -> float:
    """Radius of the circle with the area of the opening, mm."""
    return float(np.sqrt(ostium.area / np.pi))


def _compared(
    name: str, way: Points, start: float, before: Surface, after: Surface
) -> NeighborLumen:
    stations = resampled(way, _SPACING)
    # Rays tell quickly where it lost most; there it is measured.
    first, second = (_seen(surface, stations) for surface in (before, after))
    with np.errstate(invalid="ignore", divide="ignore"):
        losses = np.nan_to_num((1 - second / first).max(axis=0), nan=-np.inf, neginf=-np.inf)
    worst = np.sort(np.argsort(losses)[-_MEASURED_AT:])
    at, across = stations[worst], tangents(stations)[worst]
    pairs = np.array([_diameters(surface, at, across) for surface in (before, after)])
    # A sphere at a station on the surface, as at the end of a way, tells nothing.
    pairs[~(pairs > 0)] = np.nan
    lost = np.nan_to_num(1 - pairs[1] / pairs[0], nan=-np.inf)
    # A section that opens into another lumen says little about this one.
    lost[1, ~(pairs[:, 1] < SUSPECT * pairs[:, 0]).all(axis=0)] = -np.inf
    kind, place = np.unravel_index(np.argmax(lost), lost.shape)
    return NeighborLumen(
        name,
        way,
        start + float(arc_lengths(stations)[worst[place]]),
        float(pairs[0, kind, place]),
        float(pairs[1, kind, place]),
        bool(kind == 1),
    )


def _seen(surface: Surface, stations: Points) -> Floats:
    """Narrowest width and mean width (2, n) of the sections, by rays from the way."""
    near = near_wall(surface, stations, far_reach(surface, stations))
    rays = rays_from(near, arc_lengths(stations), stations, frames(stations)).distance
    wall = across_alone(np.where(np.isfinite(rays), rays, np.nan))
    width = wall + np.roll(wall, RAYS // 2, axis=1)
    return np.stack([width.min(axis=1), width.mean(axis=1)])


def _diameters(surface: Surface, stations: Points, directions: Points) -> Floats:
    """Inscribed and equivalent diameters (2, n), mm."""
    spheres = inscribed_spheres(surface.points, surface.triangles, stations, directions)
    areas = equivalent_diameters(surface.points, surface.triangles, stations, directions)
    return np.stack([2 * spheres.radii, areas])
