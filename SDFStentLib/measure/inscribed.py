"""The largest sphere inside the lumen near each point of an axis.

The centre is free in the plane through the axis point normal to the axis. It climbs: at a centre c
every nearby triangle i has a distance d_i and a unit direction g_i away from it, and because the
distance to a triangle is convex,

    d_i(c + x) >= d_i + g_i x.

The step x therefore solves a small linear programme, largest t with t <= d_i + g_i x and x in a
box, and the true distance after the step is at least t: every step climbs. The new centre lies
inside the old sphere, which holds no wall, so a centre can never pass through one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import NearPairs, across, norm
from ..geometry import tangents as polyline_tangents
from ..validation import Floats, Indices, InputError, Points, Triangles, as_number, as_points
from .local_surface import LocalSurface
from .max_min_step import LinearRows, largest_steps

_FIRST_BOX, _SMALLEST_BOX, _LARGEST_BOX = 0.05, 0.005, 0.5
"""Half width of the box of a step, as a fraction of the present radius. With 0.5 even the corner
of the box is nearer than the wall."""

_ROUGH_TOLERANCE = 1e-3
"""Of a search among a part of the triangles, mm."""

_STATIONS = 64
"""Stations searched together: bounds the memory, and keeps the part of the surface local."""

_ROUNDS = 200

_ON_WALL = 1e-9
"""An axis point nearer to the wall than this, mm, lies on it: rounding tells no direction away."""
"""Most steps of a climb; one that is not done by then ends where it is, with the radius there."""


class InscribedSpheres(NamedTuple):
    """Centres (n, 3) and radii (n,), mm; NaN in both where there is no lumen round the point."""

    centers: Points
    radii: Floats

    def at(self, which: Indices | slice) -> InscribedSpheres:
        """Some of them."""
        return InscribedSpheres(self.centers[which], self.radii[which])


def inscribed_spheres(
    points: Points,
    triangles: Triangles,
    centers: ArrayLike,
    tangents: ArrayLike | None = None,
    *,
    tolerance: float = 1e-6,
) -> InscribedSpheres:
    """Maximum inscribed sphere at each axis point.

    Parameters
    ----------
    points, triangles : (k, 3) and (m, 3) arrays
        Of a surface, open or closed, or a part of one; orientation does not matter.
    centers : array_like, shape (n, 3)
        Axis points inside the lumen, mm, from where the search starts.
    tangents : array_like, shape (n, 3), optional
        Direction of the axis at each point, any length but zero. Default: from `centers` as a
        polyline.
    tolerance : float
        A centre stays when the linear model promises less gain than this, mm.

    Returns
    -------
    InscribedSpheres
        The radius is the exact distance from the returned centre to the surface, hence never too
        large. NaN when the centre climbs out of the surface's bounding box (the axis point was
        outside); 0 at an axis point on the wall.

    Notes
    -----
    The maximum is the one that a climb from the axis point reaches. In a cross-section with
    several pockets it is the pocket of the axis, and where a flat lumen has a rough wall the
    result may stay below the largest sphere by about the height of the roughness. Near a junction
    the sphere grows into it as far as the plane allows.

    Raises
    ------
    InputError
        Wrong shapes, a zero tangent, or a single centre without a tangent.
    """
    centers = as_points(centers, "centers")
    as_number(tolerance, "tolerance", unit="mm", above=0)
    if tangents is None and len(centers) < 2:
        raise InputError(
            f"centers: expected at least 2 points or a tangent for each, got {len(centers)}."
        )
    directions = polyline_tangents(centers) if tangents is None else _unit(tangents, centers)
    axes = across(directions)
    found = InscribedSpheres(np.empty_like(centers), np.empty(len(centers)))
    for start in range(0, len(centers), _STATIONS):
        block = slice(start, start + _STATIONS)
        surface = LocalSurface(points, triangles, centers[block])
        spheres = _largest_spheres(surface, centers[block], axes[block], tolerance)
        found.centers[block], found.radii[block] = spheres
    return found


def _largest_spheres(
    surface: LocalSurface, starts: Points, axes: Floats, tolerance: float
) -> InscribedSpheres:
    """Climb on few triangles first, then on all, then make sure that no wall lies between."""
    thinned = surface.thinned()
    if thinned is None:
        begin = InscribedSpheres(starts, surface.distances(starts))
        return _climb(surface, begin, axes, tolerance)
    rough = _largest_spheres(thinned, starts, axes, _ROUGH_TOLERANCE)
    lost = np.flatnonzero(np.isnan(rough.radii))
    # Fewer triangles are never nearer: the rough radius is an upper bound.
    centers, bounds = rough.centers.copy(), rough.radii.copy()
    centers[lost], bounds[lost] = starts[lost], surface.distances(starts[lost])
    begin = InscribedSpheres(centers, bounds)
    centers, radii = _climb(surface, begin, axes, tolerance, first_box=_SMALLEST_BOX)

    # Empty spheres that overlap lie in the same lumen, and most hold the axis point anyway.
    moved = np.linalg.norm(centers - starts, axis=1)
    doubtful = np.flatnonzero(~(moved < radii))
    exact = surface.distances(starts[doubtful])
    is_apart = ~(moved[doubtful] < radii[doubtful] + exact)
    again = doubtful[is_apart]
    begin = InscribedSpheres(starts[again], exact[is_apart])
    centers[again], radii[again] = _climb(surface, begin, axes[again], tolerance)
    return InscribedSpheres(centers, radii)


def _climb(
    surface: LocalSurface,
    begin: InscribedSpheres,
    axes: Floats,
    tolerance: float,
    *,
    first_box: float = _FIRST_BOX,
) -> InscribedSpheres:
    """Local maxima reached from the centers of spheres that are at most as large as given."""
    spheres = InscribedSpheres(begin.centers.copy(), begin.radii.copy())
    centers, radii = spheres
    box = first_box * radii
    active = np.flatnonzero(radii > _ON_WALL)
    near = _Neighbourhood(surface, len(centers))
    for _ in range(_ROUNDS):
        if len(active) == 0:
            break
        # Inside the box the radius grows and every distance shrinks by at most its half diagonal.
        reach = 2 * np.sqrt(2) * box[active]
        rows = _rows(near, spheres, axes, reach, active)
        radii[active] = rows.radii
        step, height = largest_steps(rows, box[active])
        moves = height - rows.radii > tolerance
        active, step, height = active[moves], step[moves], height[moves]
        length = np.linalg.norm(step, axis=1)
        centers[active] += np.einsum("ni,nij->nj", step, axes[active])
        # The true radius lies between `height` and this; the next round finds it.
        radii[active] += length
        near.forget(active, length)
        is_held = np.abs(step).max(axis=1) > 0.99 * box[active]
        box[active] = np.where(is_held, 3 * box[active], 2 * length)
        box[active] = np.clip(box[active], _SMALLEST_BOX * height, _LARGEST_BOX * height)
        outside = np.any((centers < surface.lowest) | (centers > surface.highest), axis=1)
        centers[outside], radii[outside] = np.nan, np.nan
        active = active[~outside[active]]
    if len(active):
        radii[active] = surface.distances(centers[active])
    return spheres


class _Neighbourhood:
    """Triangles near every centre, found once and thinned out as the centres settle."""

    def __init__(self, surface: LocalSurface, count: int) -> None:
        self._surface = surface
        self._covered = np.full(count, -np.inf)
        nothing = np.empty(0, dtype=np.int64)
        self._pairs = NearPairs(nothing, nothing, np.empty(0))

    def forget(self, active: Indices, moved: Floats) -> None:
        """Centres have moved: what is known of distances shrinks by as much."""
        self._covered[active] -= moved
        shift = np.full(len(self._covered), -np.inf)  # of those that are done
        shift[active] = moved
        query, triangle, bound = self._pairs
        self._pairs = NearPairs(query, triangle, bound - shift[query])

    def _find(self, centers: Points, which: Indices, wanted: Floats) -> None:
        """Search anew round some of the centres, as far as wanted."""
        found = self._surface.near(centers[which], wanted)
        self._covered[which] = wanted
        is_anew = np.zeros(len(centers), dtype=bool)
        is_anew[which] = True
        kept = np.flatnonzero(~is_anew[self._pairs.query])
        query = np.r_[self._pairs.query[kept], which[found.query]]
        order = np.argsort(query, kind="stable")
        triangle = np.r_[self._pairs.triangle[kept], found.triangle]
        bound = np.r_[self._pairs.bound[kept], found.bound]
        self._pairs = NearPairs(query[order], triangle[order], bound[order])

    def offsets(
        self, centers: Points, active: Indices, radii: Floats, spare: Floats
    ) -> tuple[Indices, Points, Floats]:
        """From the walls within `radii` of the active centres: query, offset and distance.

        Looks at a little more, up to `radii + spare`, so that it need not search at every step.
        """
        missing = radii > self._covered[active]
        if missing.any():
            growths = self._surface.growths
            self._find(centers, active[missing], (radii + spare)[missing])
            if self._surface.growths != growths and not missing.all():
                # It has grown, and its triangles have other numbers.
                self._find(centers, active, radii + spare)
        query, triangle, bound = self._pairs
        limit = np.full(len(centers), -np.inf)
        limit[active] = radii
        inner = np.flatnonzero(bound <= limit[query])
        query, triangle = query[inner], triangle[inner]
        offset = centers[query] - self._surface.index.closest_points(centers[query], triangle)
        bound[inner] = distance = norm(offset)
        return query, offset, distance


def _rows(
    near: _Neighbourhood, spheres: InscribedSpheres, axes: Floats, reach: Floats, active: Indices
) -> LinearRows:
    """Linear models of the distances that matter within the boxes, and the exact radii."""
    centers, radii = spheres
    query, offset, distance = near.offsets(centers, active, radii[active] + reach, reach)
    starts = np.searchsorted(query, active)
    radius = np.minimum.reduceat(distance, starts)
    limit = np.empty(len(centers))
    limit[active] = radius + reach
    matters = np.flatnonzero(distance <= limit[query])
    query, offset, distance = query[matters], offset[matters], distance[matters]
    slope = np.einsum("nij,nj->ni", axes[query], offset) / np.maximum(distance, 1e-300)[:, None]
    return LinearRows(distance, slope, np.searchsorted(query, active), radius)


def _unit(tangents: ArrayLike, centers: Points) -> Points:
    tangents = as_points(tangents, "tangents")
    if len(tangents) != len(centers):
        raise InputError(
            f"tangents: expected one for each of the {len(centers)} centers, got {len(tangents)}."
        )
    lengths = np.linalg.norm(tangents, axis=1)
    if np.any(lengths == 0):
        raise InputError(
            f"tangents: expected directions, got zero at point {np.argmin(lengths)}; "
            "remove repeated axis points."
        )
    return tangents / lengths[:, None]
