"""The lumen of a surface, measured only once at every station while the surface is in use."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..geometry import Surface, dot, faces_at, in_box, norm, product, search_tree
from ..validation import Flags, Floats, Points, Triangles
from .spheres import InscribedSpheres, inscribed_spheres
from .stations import MOST, Stations, measured_at
from .tolerances import ALIKE, PAIRS

_APART = 1 / np.sqrt(3.0)
"""Largest distance of a place of a triangle from all of its corners, over its longest side."""


class MovedWall(NamedTuple):
    """Triangles of which a corner has moved: where they were, and where they are."""

    places: Points
    """(k, 3) their corners before and after, mm."""
    apart: float
    """No place of them is farther from all corners, mm."""

    def within(self, points: Points, reach: float) -> MovedWall:
        """The part of it in the box that reaches `reach` mm beyond some points (n, 3)."""
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        kept = in_box(self.places, low, high)
        return MovedWall(self.places.compress(kept, axis=0), self.apart)

    def comes_near(self, centers: Points, radii: Floats) -> Flags:
        """Whether it may reach each ball (n,); true for a ball whose radius is not known."""
        is_near = np.isnan(radii)
        if len(self.places):
            tree = search_tree(self.places)
            reach = radii + self.apart
            columns = zip(centers.T, self.places.T, strict=True)
            beside = [(x + reach >= y.min()) & (x - reach <= y.max()) for x, y in columns]
            known = np.flatnonzero(np.logical_and.reduce(beside))
            is_near[known] = tree.query(centers[known])[0] <= reach[known]
        return is_near

    def crosses(self, points: Points, normals: Points) -> Flags:
        """Whether it may cut each plane (n,) through some points with normals (n, 3)."""
        found = np.zeros(len(points), dtype=bool)
        block = max(1, PAIRS // max(1, len(self.places)))
        for first in range(0, len(points) if len(self.places) else 0, block):
            rows = slice(first, first + block)
            heights = product(normals[rows], self.places.T)
            origin = dot(normals[rows], points[rows])
            found[rows] = (heights.min(axis=1) <= origin) & (heights.max(axis=1) >= origin)
        return found


def moved_wall(before: Surface, after: Surface) -> MovedWall:
    """The triangles that have moved between two states of a surface, which have the
    same triangles."""
    # By column: reductions over rows of three are slow.
    columns = zip(before.points.T, after.points.T, strict=True)
    is_moved = np.logical_or.reduce([one != other for one, other in columns])
    has_moved = faces_at(is_moved, before.corners.T)
    triangles = before.triangles.compress(has_moved, axis=0)
    is_corner = np.zeros(len(is_moved), dtype=bool)
    is_corner[triangles] = True
    points = before.points, after.points
    apart = _APART * max(_longest_side(state, triangles) for state in points)
    return MovedWall(np.concatenate([state.compress(is_corner, axis=0) for state in points]), apart)


def _longest_side(points: Points, triangles: Triangles) -> float:
    corners = [points.take(column, axis=0) for column in triangles.T]
    return max(float(norm(corners[k] - corners[k - 1]).max(initial=0.0)) for k in range(3))


_known: WeakKeyDictionary[Surface, dict[tuple[bytes, bytes], Stations]] = WeakKeyDictionary()
"""Stations that were measured together, by places and directions."""


def measured_once(surface: Surface, points: Points, directions: Points) -> Stations:
    """The result of `measured_at` for a vessel before treatment; stations that were measured
    together before are not measured again.

    A surface cannot change, and only the axis of a stent matters: if another diameter is tried, all
    results are known. A sphere is searched from those beside it, so that stations which are
    measured with others differ by about 1e-8 mm: nothing that was asked before changes an answer.
    """
    known = _known.setdefault(surface, {})
    key = points.tobytes(), directions.tobytes()
    found = known.get(key)
    if found is None:
        if sum(len(one.points) for one in [*known.values()]) > MOST:
            known.clear()
        found = known[key] = measured_at(surface, points, directions)
        for values in (*found.spheres, found.equivalent):
            values.setflags(write=False)
    return found


def measured_after(
    before: Stations,
    moved: MovedWall,
    surface: Surface,
    caps: Flags,
    outside: Flags | None = None,
) -> Stations:
    """The result of `measured_at` for a vessel after treatment; stations that no moved wall is
    near keep their results.

    Parameters
    ----------
    before : Stations
        The results before it.
    moved : MovedWall
        The wall moved between the two states.
    surface : Surface
        The vessel after it.
    caps : (m,) bool array
        The triangles that were in flat caps before it: one that is bulged since is no wall either.
    outside : (n,) bool array, optional
        The stations that are known to be outside of it: there is no sphere.
    """
    points, directions = before.points, before.directions
    centers, radii = before.spheres.centers.copy(), before.spheres.radii.copy()
    equivalent = before.equivalent.copy()
    is_changed = moved.comes_near(centers, ALIKE * radii) | ~(radii > 0)
    if outside is not None:
        is_changed &= ~outside
        centers[outside], radii[outside] = np.nan, np.nan
    changed = np.flatnonzero(is_changed)
    wall = surface.triangles.compress(~caps, axis=0)
    centers[changed], radii[changed] = inscribed_spheres(
        surface.points, wall, points[changed], directions[changed]
    )
    cut = np.flatnonzero(moved.crosses(points, directions))
    measured = Stations(points, directions, InscribedSpheres(centers, radii), equivalent)
    equivalent[cut] = measured.at(cut).sections(surface, caps)
    return measured
