"""Ends of a lumen that were cut flat and whose rims are round: of a scan, or smoothed.

Along a vessel and in a round tip the wall turns away within the radius of a ball that touches it.
Where it is flat about as far as the widest ball there is wide, it closes the vessel across, however
short that is.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..geometry import (
    Surface,
    across,
    dot,
    face_areas,
    norm,
    paired_sides,
    search_tree,
    signed_volume,
    vertex_normals,
)
from ..lumen import ACROSS, ALIKE, CENTERED, OWN_WIDTH, WITHIN, Spot, are_ends, spot
from ..threads import threads
from ..validation import Floats, Indices, Points

FLAT = 0.57
"""Radius of a spot that looks the same way within `ACROSS`, over that of the widest ball there,
from which it is flat: in a round wall it is 0.5, by geometry, in a patient's 0.55 at most, in ends
of scans 0.58 to 0.94."""

_AROUND = 2.0
"""Distance from a place, in radii of the widest ball there, within which its flat spot is looked
for: more than `OWN_WIDTH`, as what is wider is wall along a vessel."""

_WITHIN = 0.5
"""Distance from a flat end, in the same radii, at which its line ends: there the vessel has its
whole width, however round its rim is."""

_LINES = 4
"""Number of lines across a place along which the wall has to be flat; two miss a spot that bends
between them."""


class BluntEnd(NamedTuple):
    """An end of a lumen that was cut flat."""

    place: Points
    """(3,) place in the lumen below the middle of its flat part, mm."""
    radius: float
    """Radius of the widest ball that touches it, mm."""


def blunt_ends(surface: Surface, at_wall: Floats) -> list[BluntEnd]:
    """The ends of a lumen that were cut flat, however round their rims are, the widest first.

    Parameters
    ----------
    surface : Surface
        Closed, mm.
    at_wall : (n,) array
        Radius of the widest inner ball that touches each of its points, mm.
    """
    found = list(_FacesAndBalls(surface, at_wall).flat_spots())
    is_end = are_ends(surface, [one for one, _ in found])
    return [
        BluntEnd(one.center - _WITHIN * radius * one.across, radius)
        for (one, radius), is_own in zip(found, is_end, strict=True)
        if is_own
    ]


class _FacesAndBalls:
    """The faces of a wall, and how wide the lumen is at its points."""

    def __init__(self, surface: Surface, at_wall: Floats) -> None:
        self.points, self.triangles = surface.points, surface.wound_triangles
        self.radii = at_wall
        outward = np.sign(signed_volume(self.points, self.triangles))
        self.areas = face_areas(self.points, self.triangles)
        self.at_points = outward * vertex_normals(self.points, self.triangles)
        # Of a face by those beside it: one alone may lean by more where a border of voxels was.
        even = self.at_points[self.triangles].sum(axis=1)
        self.normals = even / np.maximum(norm(even), np.finfo(float).tiny)[:, None]
        self.middles = self.points[self.triangles].mean(axis=1)
        self._has = np.zeros(len(self.triangles) + 1, dtype=bool)
        """A mask of faces, empty between calls; one more for the side without a neighbor."""

    @cached_property
    def _near(self) -> Any:
        return search_tree(self.middles)

    @cached_property
    def _beyond_sides(self) -> Indices:
        """The face (m, 3) beyond each side, m where there is none."""
        found = np.full(self.triangles.size, len(self.triangles))
        one, other = paired_sides(self.triangles).T
        found[one], found[other] = other // 3, one // 3
        return found.reshape(-1, 3)

    def flat_spots(self) -> Iterator[tuple[Spot, float]]:
        """The spots that are flat about as far as the widest ball is wide that touches them, and
        the radius of this, mm."""
        is_known = np.zeros(len(self.points), dtype=bool)
        seeds = self._flat_around(self._wide())
        for point in seeds[np.argsort(-self.radii[seeds], kind="stable")].tolist():
            if not is_known[point] and (found := self._spot(point)):
                own = self.triangles[found.faces]
                is_known[own] = True
                radius = float(self.radii[own].max())
                if found.narrow > FLAT * radius and found.wide < OWN_WIDTH * radius:
                    # Its vessel is as wide as the ball, beyond the round rim.
                    yield found._replace(wide=max(found.wide, radius)), radius

    def _wide(self) -> Indices:
        """Points that about as wide a ball touches as those beside: in the middle of a flat end."""
        beside = np.zeros(len(self.points))
        widest = self.radii[self.triangles].max(axis=1)
        for corner in self.triangles.T:
            np.maximum.at(beside, corner, widest)
        return np.flatnonzero((self.radii > 0) & (self.radii > WITHIN * beside))

    def _flat_around(self, points: Indices) -> Indices:
        """Those of some points round which the wall looks the same way about as far as the ball is
        wide, and below which the lumen does not go on to both sides, as in a vessel along them."""
        share = 1 / OWN_WIDTH
        for side in range(2 * _LINES):
            beside = self._beside(points, side, share, 0.0)[1]
            points = points[dot(self.normals[beside], self.at_points[points]) > ACROSS]
        for side in range(_LINES):
            away = [self._beside(points, one, 1.0, share)[0] for one in (side, side + _LINES)]
            points = points[np.minimum(*away) < CENTERED * self.radii[points]]
        return points

    def _beside(
        self, points: Indices, side: int, across_by: float, below_by: float
    ) -> tuple[Floats, Indices]:
        """Distance from the wall, and the face there, of places beside some points and below them,
        in radii of their balls."""
        normals = self.at_points[points]
        one, other = across(normals).swapaxes(0, 1)
        turn = np.pi * side / _LINES
        way = across_by * (np.cos(turn) * one + np.sin(turn) * other) - below_by * normals
        places = self.points[points] + self.radii[points, None] * way
        away, face = self._near.query(places, workers=threads())
        return away, face

    def _spot(self, point: int) -> Spot | None:
        """The spot round a point that looks the same way on the whole; None in a fold."""
        place, radius = self.points[point], self.radii[point]
        near = np.sort(self._near.query_ball_point(place, _AROUND * radius)).astype(np.int64)
        # The wall of a vessel that touches this one is as near, and looks the other way.
        near = near[self.normals[near] @ self.at_points[point] > 0]
        away = norm(self.middles[near] - place)
        beside = near[away < max(radius / OWN_WIDTH, ALIKE * away.min(initial=np.inf))]
        mean = self.areas[beside] @ self.normals[beside]
        length = np.linalg.norm(mean)
        own = near[self.normals[near] @ mean > ACROSS * length]
        if not len(own):
            return None
        normal = mean / length
        own = self._part(own, int(own[norm(self.middles[own] - place).argmin()]))
        middle = self.areas[own] @ self.middles[own] / self.areas[own].sum()
        center = self.middles[own[norm(self.middles[own] - middle).argmin()]]
        return spot(self.points, self._rim(own), normal, own, center)

    def _part(self, faces: Indices, one: int) -> Indices:
        """Those of some faces that hang together with one of them across sides."""
        self._has[faces] = True
        front = np.array([one])
        # Ends: every face is in front once.
        while len(front):
            self._has[front] = False
            beside = self._beyond_sides[front].ravel()
            front = np.unique(beside[self._has[beside]])
        part = faces[~self._has[faces]]
        self._has[faces] = False
        return part

    def _rim(self, faces: Indices) -> Indices:
        """The edges (k, 2) between some faces and others, in the direction of these."""
        self._has[faces] = True
        face, side = np.nonzero(~self._has[self._beyond_sides[faces]])
        self._has[faces] = False
        corners = self.triangles[faces[face]]
        rows = np.arange(len(face))
        return np.column_stack([corners[rows, side], corners[rows, (side + 1) % 3]])
