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

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...geometry import Surface, across, norm
from ...geometry import tangents as polyline_tangents
from ...validation import Floats, Indices, InputError, Points, Triangles, as_number, as_points
from .local_surface import LocalSurface
from .max_min_step import largest_steps
from .near_walls import Neighborhood
from .neighbors import are_stuck, rooms
from .wall_points import WallPoints

_FIRST_BOX, _SMALLEST_BOX, _LARGEST_BOX = 0.05, 0.005, 0.5
"""Half width of the box of a step, as a fraction of the present radius. With 0.5 even the corner
of the box is nearer than the wall."""

WAY_BOX = 0.25
"""The same on a way: from one place to the next the middle moves farther than a search's end does.
Where spheres end does not depend on it."""

_ROUGH_TOLERANCE = 1e-3
"""Of a search among a part of the triangles, mm."""

_TRIANGLES = 1 << 21
"""Of the spheres that are searched together, about: bounds the memory, some 100 MB. The fewer parts
the better: every step of a climb costs something, for however few stations."""

_ROUNDS = 200
"""Most steps of a climb; one that is not done by then ends where it is, with the radius there."""

_ROUGHLY, _FINER = 100, 30
"""Points of the wall round a sphere in the first search, and so many times more in the next."""

_SOME = 64
"""Stations that tell how fine the surface is."""

_GLANCES = 30
"""Steps of a look from one sphere to another, each as long as the wall is away."""

_ON_WALL = 1e-9
"""An axis point nearer to the wall than this, mm, lies on it: rounding tells no direction away."""


class InscribedSpheres(NamedTuple):
    """Centres (n, 3) and radii (n,), mm; NaN in both where there is no lumen round the point."""

    centers: Points
    radii: Floats

    def at(self, which: Indices | slice) -> InscribedSpheres:
        """Some of them."""
        return InscribedSpheres(self.centers[which], self.radii[which])


class Until(NamedTuple):
    """Where the search for a sphere ends."""

    tolerance: float = 1e-6
    """A centre stays when the linear model promises less gain than this, mm."""
    enough: Floats | float = np.inf
    """(n,) or one for all: a centre stays, too, when its sphere is larger than this, mm."""

    def at(self, which: Indices) -> Until:
        """That of some spheres."""
        enough = np.asarray(self.enough)
        return self._replace(enough=enough[which]) if enough.ndim else self


USUAL = Until()


def inscribed_spheres(
    points: Points,
    triangles: Triangles,
    centers: ArrayLike,
    tangents: ArrayLike | None = None,
    until: Until = USUAL,
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
    until : Until, optional

    Returns
    -------
    InscribedSpheres
        The radius is the exact distance from the returned centre to the surface, hence never too
        large. NaN when the centre climbs out of the surface's bounding box (the axis point was
        outside); 0 at an axis point on the wall.

    Notes
    -----
    The maximum is the one that a climb from the axis point reaches. In a cross-section with
    several pockets it is the pocket of the axis, unless the spheres of the stations before and
    behind tell of more room in its plane: then it is searched anew from there. Where a flat lumen
    has a rough wall the result may stay below the largest sphere by about the height of the
    roughness. Near a junction the sphere grows into it as far as the plane allows.

    Raises
    ------
    InputError
        Wrong shapes, a zero tangent, or a single centre without a tangent.
    """
    centers = as_points(centers, "centers")
    as_number(until.tolerance, "tolerance", unit="mm", above=0)
    if tangents is None and len(centers) < 2:
        raise InputError(
            f"centers: expected at least 2 points or a tangent for each, got {len(centers)}."
        )
    directions = polyline_tangents(centers) if tangents is None else _unit(tangents, centers)
    axes = across(directions)
    found = InscribedSpheres(np.empty_like(centers), np.empty(len(centers)))
    surface = LocalSurface(points, triangles, centers)
    for block in _parts(surface, centers):
        spheres = _largest_spheres(surface, centers[block], axes[block], until.at(block))
        found.centers[block], found.radii[block] = spheres
    _free_stuck(surface, found, centers, directions, until)
    return found


class SphereSearch:
    """Spheres at places that come one after the other, such as on a way that is looked for.

    Parameters
    ----------
    surface : Surface
    around : (n, 3) array
        Where the search begins, mm.
    reach : float
        How far from there places come, mm; farther ones take longer.
    """

    def __init__(self, surface: Surface, around: Points, reach: float) -> None:
        self._surface = LocalSurface(surface.points, surface.triangles, around)
        self._surface.cover(around, np.full(len(around), reach))

    def distances(self, places: Points) -> Floats:
        """From some places (n, 3) to the surface, mm."""
        return self._surface.distances(places)

    def spheres(self, centers: Points, directions: Points, until: Until) -> InscribedSpheres:
        """`inscribed_spheres` at places (n, 3), each climbed to straight from its place.

        Directions (n, 3) are of unit length.
        """
        begin = InscribedSpheres(centers, self._surface.distances(centers))
        return _climb(self._surface, begin, across(directions), until, first_box=WAY_BOX)


def _free_stuck(
    surface: LocalSurface,
    found: InscribedSpheres,
    stations: Points,
    directions: Points,
    until: Until,
) -> None:
    """Search those that their neighbors contradict anew, from where these leave room."""
    sides = rooms(stations, directions, *found)
    stuck = np.flatnonzero(are_stuck(found.radii, *sides) & (found.radii <= until.enough))
    if not len(stuck):
        return
    both = np.r_[stuck, stuck]
    starts = np.concatenate([side.places[stuck] for side in sides])
    anew = _largest_spheres(surface, starts, across(directions[both]), until.at(both))
    # What is larger as seen from one side only may be another vessel's.
    radii = np.where(np.isnan(anew.radii), np.inf, anew.radii).reshape(2, -1)
    smaller = anew.at(np.arange(len(stuck)) + len(stuck) * radii.argmin(axis=0))
    free = _see_each_other(surface, smaller, found.at(stuck))
    found.centers[stuck[free]], found.radii[stuck[free]] = smaller.at(free)


def _see_each_other(
    surface: LocalSurface, spheres: InscribedSpheres, others: InscribedSpheres
) -> Indices:
    """Numbers (k,) of the pairs of spheres between whose centers there is no wall."""
    offset = others.centers - spheres.centers
    gone, whole = spheres.radii.copy(), norm(offset)
    found = gone > whole - others.radii
    for _ in range(_GLANCES):
        left = np.flatnonzero(~found & (gone < whole))
        if not len(left):
            break
        places = spheres.centers[left] + (gone[left] / whole[left])[:, None] * offset[left]
        gone[left] += surface.distances(places)
        found[left] = gone[left] > whole[left] - others.radii[left]
    return np.flatnonzero(found)


def _parts(surface: LocalSurface, centers: Points) -> Iterator[Indices]:
    """Stations that are searched together: near each other, with not too many triangles."""
    todo = [np.arange(len(centers))] if len(centers) else []
    triangles = surface.triangles_round(centers) if todo else np.empty(0)
    # Ends: parts are halved until they are small, or one station.
    while todo:
        part = todo.pop()
        if len(part) == 1 or triangles[part].sum() <= _TRIANGLES:
            yield part
            continue
        half = len(part) // 2
        widest = int(np.ptp(centers[part], axis=0).argmax())
        order = np.argpartition(centers[part, widest], half)
        todo += [np.sort(part[order[:half]]), np.sort(part[order[half:]])]


def _largest_spheres(
    surface: LocalSurface, starts: Points, axes: Floats, until: Until
) -> InscribedSpheres:
    """Climb among points of the wall, then on it, then make sure that no wall lies between."""
    centers, bounds = _rough(surface, starts, axes, until._replace(tolerance=_ROUGH_TOLERANCE))
    lost = np.isnan(bounds)
    centers[lost], bounds[lost] = starts[lost], surface.distances(starts[lost])
    box = np.where(lost, _FIRST_BOX, _SMALLEST_BOX)
    begin = InscribedSpheres(centers, bounds)
    centers, radii = _climb(surface, begin, axes, until, first_box=box)

    # Empty spheres that overlap lie in the same lumen, and most hold the axis point anyway.
    moved = np.linalg.norm(centers - starts, axis=1)
    doubtful = np.flatnonzero(~(moved < radii - _ON_WALL))
    exact = surface.distances(starts[doubtful])
    is_apart = ~(moved[doubtful] < radii[doubtful] + exact - _ON_WALL)
    again = doubtful[is_apart]
    begin = InscribedSpheres(starts[again], exact[is_apart])
    centers[again], radii[again] = _climb(surface, begin, axes[again], until.at(again))
    return InscribedSpheres(centers, radii)


def _rough(surface: LocalSurface, starts: Points, axes: Floats, until: Until) -> InscribedSpheres:
    """Spheres among points of the wall, few first; radii are no smaller than to the wall.

    NaN where that leads out of the surface, and everywhere where the wall has few triangles.
    """
    some = starts[:: max(1, len(starts) // _SOME)]
    around = float(np.quantile(surface.triangles_round(some), 0.25))
    centers, radii = starts.copy(), np.full(len(starts), np.nan)
    strides = [max(1.0, around / _ROUGHLY)] if around > _ROUGHLY / 2 else []
    # Ends: what is appended falls to 2.
    while strides and strides[-1] > 2 * _FINER:
        strides.append(strides[-1] / _FINER)
    for number, stride in enumerate(strides):
        wall = WallPoints(surface, stride)
        centers = np.where(np.isnan(radii)[:, None], starts, centers)
        begin = InscribedSpheres(centers, wall.distances(centers))
        box = 2 * _SMALLEST_BOX if number else _FIRST_BOX
        centers, radii = _climb(wall, begin, axes, until, first_box=box)
    return InscribedSpheres(centers, radii)


def _climb(
    surface: LocalSurface | WallPoints,
    begin: InscribedSpheres,
    axes: Floats,
    until: Until,
    *,
    first_box: float | Floats = _FIRST_BOX,
) -> InscribedSpheres:
    """Local maxima reached from the centers of spheres that are at most as large as given."""
    spheres = InscribedSpheres(begin.centers.copy(), begin.radii.copy())
    centers, radii = spheres
    box = first_box * radii
    active = np.flatnonzero(radii > _ON_WALL)
    near = Neighborhood(surface, len(centers))
    for _ in range(_ROUNDS):
        if len(active) == 0:
            break
        # Inside the box the radius grows and every distance shrinks by at most its half diagonal.
        reach = 2 * np.sqrt(2) * box[active]
        rows = near.rows(centers, radii, axes, reach, active)
        radii[active] = rows.radii
        step, height = largest_steps(rows, box[active])
        moves = (height - rows.radii > until.tolerance) & (rows.radii <= until.at(active).enough)
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
