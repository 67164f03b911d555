"""The solid of a branching synthetic vessel: a smooth union of tubes as one function of space."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from SDFStentLib.geometry import dot, norm, smooth_minimum
from SDFStentLib.validation import Floats, Points

from .axis import TrueAxis

SAMPLE_SPACING = 0.1
"""Spacing of samples of the axes, mm; axis and radius are parabolas in between, to within 1e-4."""


class TubeField(NamedTuple):
    """An axis and its radius by arc length, mm."""

    axis: TrueAxis
    radius: Callable[[Floats], Floats]


class Rim(NamedTuple):
    """A flat cut of a vessel: center (3,) and radius, mm, and unit normal (3,) out of the lumen."""

    center: Floats
    outward: Floats
    radius: float


class FieldValues(NamedTuple):
    """Values (n,) of a field, mm, negative inside, and its gradients (n, 3)."""

    value: Floats
    gradient: Floats


class _Table(NamedTuple):
    """A tube at its samples.

    Points, tangents and curvature vectors (n, 3) of the axis; radius with its first and second
    derivative (n, 3); lengths of axis before and after it for which each sample stands (n, 2).
    """

    points: Points
    tangents: Points
    bends: Points
    radii: Floats
    reach: Floats


class TubeUnion:
    """The solid `f(x) <= 0` of several tubes, blended smoothly where they meet.

    For each tube f is the distance to its axis minus the radius there; the tubes are joined in
    order by the smooth minimum of blend width w. Where only one tube is near, f is exactly that
    tube's. The first tube is open at both ends, the others at their end only: they start inside
    the first.

    Parameters
    ----------
    tubes : sequence of TubeField
    blend_width : float
        The width w, mm.
    beyond : float
        Distance by which tubes go on beyond their open ends, mm.
    open_ends : sequence of int, optional
        Numbers of the tubes that are open at their end; by default all. The others end where later
        ones start.
    """

    def __init__(
        self,
        tubes: Sequence[TubeField],
        blend_width: float,
        beyond: float,
        open_ends: Sequence[int] | None = None,
    ) -> None:
        # Late: scipy.spatial costs more to import than the rest of the library together.
        from scipy.spatial import KDTree

        self.tubes = tuple(tubes)
        self.blend_width = blend_width
        self.open_ends = range(len(self.tubes)) if open_ends is None else open_ends
        first, last = -beyond, [tube.axis.length for tube in self.tubes]
        for number in self.open_ends:
            last[number] += beyond
        starts = [first] + [0.0] * (len(self.tubes) - 1)
        self._tables = [
            _table(tube, np.linspace(start, end, int(np.ceil((end - start) / SAMPLE_SPACING)) + 1))
            for tube, start, end in zip(self.tubes, starts, last, strict=True)
        ]
        self._trees = [KDTree(table.points) for table in self._tables]

    def __call__(self, points: Points) -> FieldValues:
        """The field at points (n, 3)."""
        value, gradient = self._tube_field(0, points)
        for number in range(1, len(self.tubes)):
            other, other_gradient = self._tube_field(number, points)
            value, share = smooth_minimum(value, other, self.blend_width)
            gradient = share[:, None] * gradient + (1 - share)[:, None] * other_gradient
        return FieldValues(value, gradient)

    def rims(self) -> list[Rim]:
        """The rim at the start of the first tube, then those of the open ends in order."""
        ends = [(self.tubes[0], 0.0, -1.0)]
        ends += [(self.tubes[n], self.tubes[n].axis.length, 1.0) for n in self.open_ends]
        return [
            Rim(
                tube.axis.point(at)[0],
                np.round(sign * tube.axis.tangent(at)[0], 14),  # along a coordinate axis: exactly
                float(tube.radius(np.array([at]))[0]),
            )
            for tube, at, sign in ends
        ]

    def projected(self, points: Points, steps: int = 2) -> Points:
        """Points moved onto the surface along the gradient (Newton)."""
        for _ in range(steps):
            value, gradient = self(points)
            squared = np.maximum(dot(gradient, gradient), 0.01)
            points = points - (value / squared)[:, None] * gradient
        return points

    def inscribed_radii(self, centers: Points, wall: Points) -> Floats:
        """Radius (n,) of the largest sphere around each point inside the solid, mm.

        `wall` (k, 3), points of the surface fine enough to start from, is refined: the sphere
        touches the wall where the line from its center runs along the gradient. Flat ends do not
        count.
        """
        from scipy.spatial import KDTree  # late, as above

        radii, nearest = KDTree(wall).query(centers)
        touching = wall[nearest]
        for _ in range(10):
            gradient = self(touching).gradient
            normal = gradient / np.linalg.norm(gradient, axis=1)[:, None]
            touching = self.projected(centers + radii[:, None] * normal)
            radii = np.minimum(radii, np.linalg.norm(touching - centers, axis=1))
        return np.asarray(radii)

    def bounds(self) -> tuple[Floats, Floats]:
        """Corners of a box around the solid, mm."""
        corners = [
            table.points + sign * (table.radii[:, 0].max() + self.blend_width)
            for table in self._tables
            for sign in (-1, 1)
        ]
        return np.vstack(corners).min(axis=0), np.vstack(corners).max(axis=0)

    def _tube_field(self, number: int, points: Points) -> tuple[Floats, Floats]:
        table = self._tables[number]
        nearest = self._trees[number].query(points)[1]
        tangent, bend = table.tangents[nearest], table.bends[nearest]
        offset = points - table.points[nearest]
        # The foot of the perpendicular on the parabola; reach ends the open ends and the start.
        step = dot(offset, tangent)
        step = step / np.maximum(1 - dot(offset, bend), 0.1)
        step = np.clip(step, table.reach[nearest, 0], table.reach[nearest, 1])[:, None]
        offset -= step * tangent + 0.5 * step**2 * bend
        radius, slope, change = table.radii[nearest].T[:, :, None]
        distance = norm(offset)
        gradient = offset / np.maximum(distance, 1e-12)[:, None]
        gradient -= (slope + change * step) * (tangent + step * bend)
        return distance - (radius + slope * step + 0.5 * change * step**2)[:, 0], gradient


def _table(tube: TubeField, samples: Floats) -> _Table:
    ahead, behind = samples + 1e-3, samples - 1e-3
    radius, after, before = tube.radius(samples), tube.radius(ahead), tube.radius(behind)
    radii = np.stack([radius, (after - before) / 2e-3, (after - 2 * radius + before) / 1e-6], 1)
    radii[[0, -1], 1:] = 0
    bends = (tube.axis.tangent(ahead) - tube.axis.tangent(behind)) / 2e-3
    reach = np.tile([-SAMPLE_SPACING, SAMPLE_SPACING], (len(samples), 1))
    reach[0, 0] = reach[-1, 1] = 0
    return _Table(tube.axis.point(samples), tube.axis.tangent(samples), bends, radii, reach)
