"""Expected wall of a vessel, as if no branch left it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry import Line, Surface
from ..validation import Floats, Points, read_only
from .stations import SPACING
from .tolerances import FARTHEST, FINEST
from .wall_map import (
    RAYS,
    RAYS_APART,
    NearWall,
    WallMap,
    corner_tree,
    cuts_across,
    frames_along,
    near_wall,
    ray_angles,
    rays_from,
    wall_map,
)

LEAVES = 1.15
"""Distance of the wall, in expected radii, above which it leaves the vessel."""

LONGEST = 6.0
"""Length along the vessel, in its radii, that an opening does not reach,"""

WIDEST = 240.0
"""or part of its circumference that it does not reach, degrees."""

_FINE = 0.125
"""Largest spacing of the stations, in radii; the middle is looked for at every other one."""

_CENTERINGS = 3
"""Number of steps to the middle; each leaves about a tenth of the way."""

_SIDE = 30.0
"""Percentile of a section's rays that stands for its radius where an opening is on one side."""


@dataclass(frozen=True)
class Tube:
    """A vessel without its branches, and the wall as it is."""

    wall: WallMap
    """The wall as seen from the middle of the vessel, in planes across the axis."""
    expected: Floats
    """(n, RAYS) distance of the expected wall from there, mm."""
    radius: float
    """Radius of the vessel as a whole, mm."""
    near: NearWall
    """The part of the surface that was looked at."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "expected", read_only(self.expected))

    @property
    def is_open(self) -> NDArray[np.bool_]:
        """(n, RAYS) whether the wall leaves the vessel there."""
        return np.asarray(self.wall.distance > LEAVES * self.expected)

    @property
    def places(self) -> Floats:
        """(n, RAYS, 3) points of the expected wall; where it is infinite, of the axis."""
        angles = ray_angles()
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        rays = np.einsum("rk,nkj->nrj", directions, self.wall.frames[:, 1:])
        expected = np.where(np.isfinite(self.expected), self.expected, 0.0)
        return np.asarray(self.wall.centers[:, None] + expected[..., None] * rays)


def expected_tube(surface: Surface, axis: Line) -> Tube:
    """The vessel round an axis.

    The expected wall is the highest one, below the rays that were met, that runs on for `LONGEST`
    radii along the vessel or for `WIDEST` degrees round it: a morphological opening of the
    map of the wall. Steps and tapers stay, what is both short and on one side goes.

    Parameters
    ----------
    surface : Surface
        mm.
    axis : Line
        Axis in the lumen; it need not be in the middle.
    """
    near = near_wall(surface, axis.resampled(SPACING).points, far_reach(surface, axis.points))
    radius = section_radius(wall_map(near, axis, spacing=2.0, window=2.0).distance)
    few = cuts_across(near, axis, spacing=2 * _FINE * radius, window=radius)
    shift = np.zeros((len(few.centers), 2))
    for _ in range(_CENTERINGS):
        wall = few.seen(shift)
        shift = shift + _to_middle(wall, expected_wall(wall, radius), radius)
    stations = axis.resampled(float(np.clip(_FINE * radius, FINEST, RAYS_APART))).points
    at = np.linspace(0.0, float(few.arc_length[-1]), len(stations))
    moved = np.einsum("ij,ijk->ik", shift, few.along[:, 1:])
    middle = stations + _interpolated(at, few.arc_length, moved)
    wall = rays_from(near, at, middle, frames_along(axis, len(at), radius))
    return Tube(wall, expected_wall(wall, radius), radius, near)


def far_reach(surface: Surface, stations: Points) -> float:
    """The distance from some points (n, 3) within which the wall of their vessel is
    looked for, mm."""
    return FARTHEST * float(corner_tree(surface).query(stations)[0].max())


def _interpolated(at: Floats, known: Floats, values: Points) -> Points:
    return np.stack([np.interp(at, known, column) for column in values.T], axis=1)


def expected_wall(wall: WallMap, radius: float, beyond: Floats | None = None) -> Floats:
    """Distance of the expected wall (n, RAYS) for a vessel of about that radius, mm.

    Beyond its ends the vessel is taken to go on with the last section, or with the rays `beyond`
    (2, RAYS).
    """
    along = int(LONGEST * radius / wall.spacing) | 1
    ends = wall.distance[[0, -1]] if beyond is None else beyond
    first, last = (np.repeat(end[None], along, axis=0) for end in ends)
    padded = np.concatenate([first, wall.distance, last])
    by_length = _opened(padded, along, axis=0)[along:-along]
    return np.asarray(np.maximum(by_length, across_alone(wall.distance)))


def across_alone(distance: Floats) -> Floats:
    """The expected wall (n, RAYS) by each section alone, without narrow openings."""
    return _opened(distance, int(WIDEST / 360 * RAYS) | 1, axis=1)


def _opened(values: Floats, size: int, axis: int) -> Floats:
    """The morphological opening of a periodic map by an odd number of cells."""
    across = values if axis == 0 else values.T
    opened = -_lowest(-_lowest(across, size), size)
    return opened if axis == 0 else opened.T


def _lowest(values: Floats, size: int) -> Floats:
    """The smallest values (n, k) of an odd number of rows round each row; the first row follows the
    last."""
    count, half = len(values), size // 2
    lowest, reach = values[np.arange(-half, count + half) % count], 1
    # Ends, since the reach doubles.
    while 2 * reach <= size:
        lowest = np.minimum(lowest[:-reach], lowest[reach:])
        reach *= 2
    return np.minimum(lowest[:count], lowest[size - reach :])


def section_radius(distance: Floats) -> float:
    """Radius (scalar) of the vessel whose sections have these rays (n, RAYS), mm."""
    # No value between two: one of them may be infinite.
    sides = np.percentile(distance, _SIDE, axis=1, method="lower")
    known = sides[np.isfinite(sides)]
    return float(np.median(known)) if len(known) else 1.0


def _to_middle(wall: WallMap, expected: Floats, radius: float) -> Floats:
    """Steps (n, 2) in their planes to the middle of expected sections, smooth along the axis."""
    return _smoothed(middles(expected), radius / 2 / wall.spacing)


def _smoothed(values: Floats, sd: float) -> Floats:
    """Columns (n, k) smoothed by a normal distribution of so many rows; the ends go on."""
    reach = len(values)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sd) ** 2)
    weights /= weights.sum()
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights, "valid") for column in padded.T], axis=1)


def middles(expected: Floats) -> Floats:
    """Centroids (n, 2) of sections in the directions of their planes; 0 where one is open."""
    rays = np.where(np.isfinite(expected), expected, 0.0)
    angles = ray_angles()
    directions = np.stack([np.cos(angles), np.sin(angles)])
    area = (rays**2).sum(axis=1) / 2
    found = (rays**3) @ directions.T / 3 / np.where(area > 0, area, 1.0)[:, None]
    found[~np.isfinite(expected).all(axis=1)] = 0.0
    return np.asarray(found)
