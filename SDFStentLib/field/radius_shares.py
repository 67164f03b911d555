"""A stent whose radius changes along its axis, and how far it pushes beyond its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry import Line, dot, frames, norm, product
from ..validation import Floats, InputError, Points, as_number, read_only

WALL_SPACING, WALL_RAYS = 0.5, 24
"""Spacing along the stent, mm, and number around it, of the points that stand for its surface."""

INSIDE = 0.999
"""Share of the radius below which a point lies inside of the stent."""


@dataclass(frozen=True, eq=False)
class RadiusShares:
    """The radius of a stent along its axis, as parts of the largest one.

    While the stent expands the shares stay as they are: it grows in proportion.

    Attributes
    ----------
    fractions : (k,) array
        Places as parts of the length from the proximal end, rising from 0 to 1.
    shares : (k,) array
        Radius there over the largest radius, above 0 and up to 1, linear in between.
    cap_height : float
        Height of the stent's caps over its radius there: 1 is half a sphere.
    """

    fractions: Floats
    shares: Floats
    cap_height: float = 1.0

    def __post_init__(self) -> None:
        fractions, shares = np.asarray(self.fractions), np.asarray(self.shares)
        if fractions.shape != shares.shape or fractions.ndim != 1 or len(fractions) < 2:
            raise InputError(
                "radius shares: expected as many fractions as shares, two at least, got "
                f"{fractions.shape} and {shares.shape}."
            )
        if fractions[0] != 0 or fractions[-1] != 1 or not (np.diff(fractions) > 0).all():
            raise InputError("radius shares: expected fractions that rise from 0 to 1.")
        if not ((shares > 0) & (shares <= 1)).all():
            raise InputError("radius shares: expected shares above 0 and up to 1.")
        as_number(self.cap_height, "cap height", above=0, maximum=1)
        object.__setattr__(self, "fractions", read_only(fractions))
        object.__setattr__(self, "shares", read_only(shares))

    @property
    def reversed(self) -> RadiusShares:
        """The shares of the same stent with its nodes the other way round."""
        return RadiusShares(1 - self.fractions[::-1], self.shares[::-1], self.cap_height)

    @property
    def are_flattened(self) -> bool:
        """Whether the caps beyond the ends are flatter than half spheres."""
        return self.cap_height < 1

    def at(self, points: Points, axis: Line) -> Floats:
        """Share (n,) of the radius that the stent has where it is nearest to points (n, 3)."""
        share = self.along(fractions_of(points, axis))
        return share * self._cap_share(points, axis) if self.are_flattened else share

    def along(self, fractions: Floats) -> Floats:
        """Shares (n,) at places given as parts (n,) of the length."""
        return np.interp(fractions, self.fractions, self.shares)

    def inscribed(self, axis: Line, radius: float, stations: Points, *, in_caps: bool) -> Floats:
        """Radii (n,), mm, of the spheres round stations of the axis that fit into the stent.

        A sphere touches the stent where that is narrower beside it, or bends toward it. With
        `in_caps`, spheres near the ends fit into flattened caps as well; else the ends are open.

        Parameters
        ----------
        axis : Line
            Axis through the nodes of the stent.
        radius : float
            Largest radius of the stent, mm.
        stations : (n, 3) array
            Centers of the spheres, mm.
        in_caps : bool
            Whether flattened caps bound the spheres.
        """
        wall = self._wall(axis, radius, in_caps)
        return np.array([norm(wall - station).min() for station in stations])

    def _wall(self, axis: Line, radius: float, in_caps: bool) -> Points:
        """Points of the stent's surface, mm."""
        length = float(axis.arc_lengths[-1])
        even = np.linspace(0, 1, max(2, int(np.ceil(length / WALL_SPACING))) + 1)
        # The corners of a tabulated profile; a smooth one has so many that even places will do.
        corners = self.fractions if len(self.fractions) < len(even) else even
        at = np.union1d(even, corners)
        centers = axis.at(at * length)
        frame, own = frames(Line(centers)), radius * self.along(at)
        angles = np.linspace(0, 2 * np.pi, WALL_RAYS, endpoint=False)[:, None, None]
        around = np.cos(angles) * frame[:, 1] + np.sin(angles) * frame[:, 2]
        wall = [(centers + own[:, None] * around).reshape(-1, 3)]
        if in_caps and self.are_flattened:
            for end, way in ((0, -1.0), (-1, 1.0)):
                for angle in np.linspace(0, np.pi / 2, 20):
                    height = way * self.cap_height * own[end] * np.sin(angle) * frame[end, 0]
                    ring = np.cos(angle) * own[end] * around[:, end]
                    wall.append(centers[end] + height + ring)
        points = np.concatenate(wall)
        # In a bend a part of the surface lies inside of the rest.
        inside = axis.nearest(points).distances < radius * self.at(points, axis) * INSIDE
        return points[~inside]

    def _cap_share(self, points: Points, axis: Line) -> Floats:
        """Radius toward points beyond an end, over that of a half sphere: an ellipsoid's; 1
        elsewhere."""
        share, nodes = np.ones(len(points)), axis.points
        for end, inner in (nodes[:2], nodes[:-3:-1]):
            along = (end - inner) / np.linalg.norm(end - inner)
            offset = points - end
            distance = norm(offset)
            height = product(offset, along)
            beyond = (height > 0) & (distance > 0)
            beyond &= axis.nearest(points).distances >= distance * (1 - 1e-9)
            cosine = height[beyond] / distance[beyond]
            share[beyond] = 1 / np.sqrt(1 - cosine**2 + (cosine / self.cap_height) ** 2)
        return share


def fractions_of(points: Points, axis: Line) -> Floats:
    """The fraction (n,) of an axis that lies before the feet of points (n, 3), from 0 to 1.

    On the outer side of a bend a whole wedge is nearest to a single node, and a steep profile would
    turn into stairs. So a foot moves evenly from the plane across the axis at one node to the next.
    """
    nodes, arc, across = axis.points, axis.arc_lengths, _turning_tangents(axis)
    last = len(nodes) - 2
    foot = axis.nearest(points)
    segment = foot.segments
    for node, way in ((0, -1), (1, 1)):
        height = dot(points - nodes[segment + node], across[segment + node])
        segment = np.clip(segment + way * (way * height > 0), 0, last)
    before = dot(points - nodes[segment], across[segment])
    behind = dot(nodes[segment + 1] - points, across[segment + 1])
    whole = before + behind
    # Beyond the center of a bend, where planes cross, the nearest place is as good as any.
    share = np.divide(before, whole, out=foot.fractions.copy(), where=whole > 0).clip(0, 1)
    return (arc[segment] + share * (arc[segment + 1] - arc[segment])) / arc[-1]


def _turning_tangents(axis: Line) -> Points:
    """Unit tangents (m, 3); at the ends they go on turning as the axis does beside them."""
    nodes, found = axis.points, axis.directions.copy()
    if len(nodes) > 2:
        for end, inner in ((0, 1), (-1, -2)):
            side = nodes[end] - nodes[inner]
            side = side / np.linalg.norm(side)
            found[end] = 2 * (side @ found[inner]) * side - found[inner]
    return found
