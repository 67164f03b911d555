"""Diameters of the vessel beyond a stent and of its branches, before and after it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..geometry import Line, Surface, frames, search_tree
from ..lumen import (
    ALIKE,
    CLOSELY,
    FARTHEST,
    NEARLY,
    OWN_WIDTH,
    RAYS,
    SPACING,
    SUSPECT,
    Stations,
    across_alone,
    corner_tree,
    near_wall,
    rays_from,
)
from ..validation import Flags, Floats, Indices, Points
from .neighbor_ways import DISTAL, PROXIMAL, NeighborWay


@dataclass(frozen=True)
class NeighborLumen:
    """A branch, or the vessel beyond an end of the stent, before and after treatment. All mm."""

    name: str
    path: Line
    """The path from the stent on."""
    distance: float
    """Distance along the path to where it lost most,"""
    before: float
    """its diameter there before"""
    after: float
    """and after treatment; NaN where it could not be measured."""
    by_area: bool
    """Whether these are equivalent diameters (of the circle of the same area), else inscribed."""

    @property
    def loss(self) -> float:
        """Loss as a share of the diameter; negative where it is wider everywhere."""
        return 1 - self.after / self.before

    @property
    def is_narrowed(self) -> bool:
        """Whether it lost more than can be passed over."""
        return self.loss > NEARLY - 1

    @property
    def is_branch(self) -> bool:
        """Whether it is no vessel beyond an end of the stent."""
        return self.name not in (PROXIMAL, DISTAL)

    def caution(self) -> Caution:
        """Caution for a narrowed lumen."""
        return Caution(
            "neighbor-narrowed",
            {
                "name": self.name,
                "before_mm": self.before,
                "after_mm": self.after,
                "diameter": "equivalent" if self.by_area else "inscribed",
                "percent": 100 * self.loss,
                "distance_mm": self.distance,
                "start": "its origin" if self.is_branch else "the end of the stent",
            },
        )


class VesselStates(NamedTuple):
    """A vessel at four times; the same triangles throughout."""

    native: Surface
    """Surface before any stent,"""
    found: Surface
    """as a stent found it,"""
    left: Surface
    """as that left it,"""
    final: Surface
    """and after all stents."""


class NeighborStations:
    """Places to measure the neighbors of a stent: where they lost most, as rays see it.

    Parameters
    ----------
    states : VesselStates
    ways : iterable of NeighborWay
        Ways in the vessel as the stent found it.

    Attributes
    ----------
    points, directions : (n, 3) arrays
        mm, and unit directions of the ways.
    outside : (2, n) bool array
        Whether they lie out of the vessel before any stent and after all, such as on a cap at the
        end of a way, or where a wall was moved past them: no sphere there measures this lumen.
    """

    points: Points
    directions: Points
    outside: Flags

    def __init__(self, states: VesselStates, ways: Iterable[NeighborWay]) -> None:
        moved = _Moved(states.found, states.left)
        self._parts = [part for way in ways if (part := moved.part_of(way)) is not None]
        surfaces = states.native, states.final
        self._worst = [_worst(part, surfaces) for part in self._parts]
        own = list(zip(self._parts, self._worst, strict=True))
        nothing = np.empty((0, 3))
        self.points = np.concatenate([nothing, *(part.stations.points[at] for part, at in own)])
        along = (part.stations.directions[at] for part, at in own)
        self.directions = np.concatenate([nothing, *along])
        self.outside = ~np.array([surface.contains(self.points) for surface in surfaces])

    def lumens(self, before: Stations, after: Stations) -> tuple[NeighborLumen, ...]:
        """The lumens, of which the stations are measured before any stent and after all."""
        measured = np.array([(2 * one.spheres.radii, one.equivalent) for one in (before, after)])
        measured[:, 0][self.outside] = np.nan
        ends = np.cumsum([len(at) for at in self._worst])[:-1]
        each = zip(self._parts, self._worst, np.split(measured, ends, axis=2), strict=False)
        return tuple(_lumen(part, at, pairs) for part, at, pairs in each)


class _Part(NamedTuple):
    """The part of a way whose wall has moved."""

    way: NeighborWay
    start: float
    """Distance along the way at which it begins, mm."""
    stations: Line
    """Stations on the way, equally spaced."""
    reach: float
    """Distance within which the wall round it is looked for, mm."""


class _Moved:
    """The wall that a stent has moved."""

    def __init__(self, before: Surface, after: Surface) -> None:
        motion = np.linalg.norm(after.points - before.points, axis=1)
        moved = np.flatnonzero(motion > 0)
        self.motion = motion[moved]
        self.wall = corner_tree(before)
        self.points = search_tree(before.points[moved]) if len(moved) else None

    def part_of(self, way: NeighborWay) -> _Part | None:
        """The part of a way whose wall has moved; None where there is none of some length."""
        if self.points is None or way.line.length <= SPACING:
            return None
        stations = way.line.resampled(SPACING).points
        distance = self.wall.query(stations)[0]
        beside = self.points.query_ball_point(stations, OWN_WIDTH * distance + SPACING)
        largest = np.array([self.motion[own].max(initial=0.0) for own in beside])
        rows = np.flatnonzero(largest > (ALIKE - 1) * distance)
        if not len(rows):
            return None
        step = way.line.length / (len(stations) - 1)
        start, end = max(rows[0] - 1, 0) * step, (rows[-1] + 1) * step
        own = way.line.cut(start, end)
        if own.length <= SPACING:
            return None
        return _Part(way, start, own.resampled(SPACING), FARTHEST * float(distance.max()))


def _worst(part: _Part, surfaces: tuple[Surface, Surface]) -> Indices:
    """The stations (k,) that lost most, as rays see it."""
    first, second = (_seen(surface, part) for surface in surfaces)
    with np.errstate(invalid="ignore", divide="ignore"):
        losses = np.nan_to_num((1 - second / first).max(axis=0), nan=-np.inf, neginf=-np.inf)
    return np.sort(np.argsort(losses)[-CLOSELY:])


def _lumen(part: _Part, worst: Indices, pairs: Floats) -> NeighborLumen:
    """The lumen of which diameters (2, 2, k) were measured: before and after, of both kinds."""
    # A sphere at a station on the surface, as at the end of a way, tells nothing.
    pairs = np.where(pairs > 0, pairs, np.nan)
    lost = np.nan_to_num(1 - pairs[1] / pairs[0], nan=-np.inf)
    # A section that opens into another lumen says little about this one.
    lost[1, ~(pairs[:, 1] < SUSPECT * pairs[:, 0]).all(axis=0)] = -np.inf
    # Where none is lost, rounding would choose.
    kind, place = np.unravel_index(np.argmax(np.round(lost, 6)), lost.shape)
    return NeighborLumen(
        part.way.name,
        part.way.line,
        part.start + float(part.stations.arc_lengths[worst[place]]),
        float(pairs[0, kind, place]),
        float(pairs[1, kind, place]),
        bool(kind == 1),
    )


def _seen(surface: Surface, part: _Part) -> Floats:
    """Narrowest width and mean width (2, n) of the sections, by rays from the way."""
    stations = part.stations
    near = near_wall(surface, stations.points, part.reach)
    rays = rays_from(near, stations.arc_lengths, stations.points, frames(stations)).distance
    wall = across_alone(np.where(np.isfinite(rays), rays, np.nan))
    width = wall + np.roll(wall, RAYS // 2, axis=1)
    return np.stack([width.min(axis=1), width.mean(axis=1)])
