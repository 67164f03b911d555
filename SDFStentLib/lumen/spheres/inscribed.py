"""The largest sphere inside the lumen near each point of an axis.

How a sphere climbs there, `climb` tells: roughly first, among points that stand for the wall.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...geometry import Line, Surface, across, norm
from ...threads import side_by_side
from ...validation import Floats, Indices, InputError, Points, Triangles, as_number, as_points
from ..tolerances import PAIRS, ROUNDS
from .climb import (
    WAY_BOX,
    InscribedSpheres,
    Until,
    climbed,
    exact_spheres,
    in_their_lumen,
    rough_spheres,
)
from .local_surface import LocalSurface
from .neighbors import are_stuck, rooms

USUAL = Until()

MANY = 2000
"""Number of stations from which on two threads look for spheres: so many take half a second."""


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
        Surface or a part of one, open or closed; orientation does not matter.
    centers : array_like, shape (n, 3)
        Axis points inside the lumen, mm, from where the search starts.
    tangents : array_like, shape (n, 3), optional
        Direction of the axis at each point, any length but zero. Default: from `centers` as a
        polyline.
    until : Until, optional

    Returns
    -------
    InscribedSpheres
        The radius is the exact distance from the returned center to the surface, hence never too
        large. NaN when the center climbs out of the surface's bounding box (the axis point was
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
        Wrong shapes, a zero tangent, or a single center without a tangent.
    """
    centers = as_points(centers, "centers")
    as_number(until.tolerance, "tolerance", unit="mm", above=0)
    if tangents is None and len(centers) < 2:
        raise InputError(
            f"centers: expected at least 2 points or a tangent for each, got {len(centers)}."
        )
    directions = Line(centers).directions if tangents is None else _unit(tangents, centers)
    search = StationSearch(LocalSurface(points, triangles, centers), centers, directions, until)
    if len(centers) >= MANY:
        search.climb_by_halves(points, triangles)
    return search.exact()


class StationSearch:
    """Search for spheres at stations: roughly at all, exactly on request.

    Parameters
    ----------
    surface : LocalSurface
        Surface that bounds the spheres.
    centers, until
        As of `inscribed_spheres`.
    directions : (n, 3) array
        Unit directions of the axis.
    """

    def __init__(
        self, surface: LocalSurface, centers: Points, directions: Points, until: Until
    ) -> None:
        self.surface = surface
        self._stations, self._directions, self._until = centers, directions, until
        self._is_exact = np.zeros(len(centers), dtype=bool)
        self._climbed = InscribedSpheres(np.empty_like(centers), np.empty(len(centers)))

    @cached_property
    def _around(self) -> Floats:
        """The approximate number of triangles (n,) that a sphere round a station has."""
        any_stations = len(self._stations) > 0
        return self.surface.triangles_round(self._stations) if any_stations else np.empty(0)

    @cached_property
    def rough(self) -> InscribedSpheres:
        """Spheres of all stations among middles of the wall's triangles, no smaller than exact.

        They are larger by about h^2 / (8 r) where those are h apart. Where there are few of them,
        or they lead out of the lumen, the sphere is the exact one.
        """
        found = InscribedSpheres(np.empty_like(self._stations), np.empty(len(self._stations)))
        axes = across(self._directions)
        for block in _parts(self._stations, self._around):
            starts, until = self._stations[block], self._until.at(block)
            rough = rough_spheres(self.surface, starts, axes[block], until, self._around[block])
            spheres, again = in_their_lumen(self.surface, starts, axes[block], until, rough)
            found.centers[block], found.radii[block] = spheres
            self._is_exact[block[again]] = True
        self._climbed.centers[:], self._climbed.radii[:] = found
        return found

    def exact(self, which: Indices | slice = slice(None)) -> InscribedSpheres:
        """Spheres of some stations, or of all, in the order in which they come."""
        asked = np.arange(len(self._stations))[which]
        if not self._is_exact[asked].all():
            self._climb(asked)
        stations, directions = self._stations[asked], self._directions[asked]
        found = self._climbed.at(asked)
        _free_stuck(self.surface, found, stations, directions, self._until.at(asked))
        return found

    def climb_by_halves(self, points: Points, triangles: Triangles) -> None:
        """Climb at all stations ahead, in two threads: a surface that grows is for one alone."""
        half = len(self._stations) // 2
        sides = slice(half), slice(half, None)
        found = side_by_side(lambda side: self._climbed_at(side, points, triangles), sides)
        for side, spheres in zip(sides, found, strict=True):
            self._climbed.centers[side], self._climbed.radii[side] = spheres
        self._is_exact[:] = True

    def _climbed_at(self, side: slice, points: Points, triangles: Triangles) -> InscribedSpheres:
        stations, until = self._stations[side], self._until.at(side)
        wall = LocalSurface(points, triangles, stations)
        part = StationSearch(wall, stations, self._directions[side], until)
        part._around = self._around[side]  # as of all: it decides how roughly they begin
        part._climb(np.arange(len(stations)))
        return part._climbed

    def _climb(self, which: Indices) -> None:
        """Climb on the wall itself at those of some stations that need it."""
        rough, stations, axes = self.rough, self._stations, across(self._directions)
        left = np.unique(which[~self._is_exact[which]])
        for part in _parts(stations[left], self._around[left]):
            own = left[part]
            begin = rough.at(own), self._until.at(own)
            spheres = exact_spheres(self.surface, stations[own], axes[own], *begin)
            self._climbed.centers[own], self._climbed.radii[own] = spheres
            self._is_exact[own] = True


class SphereSearch:
    """Search for spheres at one place after another, such as on a way that is looked for.

    Parameters
    ----------
    surface : Surface
    around : (n, 3) array
        Places where the search begins, mm.
    reach : float
        Distance from there to the places to come, mm; farther ones take longer.
    """

    def __init__(self, surface: Surface, around: Points, reach: float) -> None:
        self._surface = LocalSurface(surface.points, surface.triangles, around)
        self._surface.cover(around, np.full(len(around), reach))

    def distances(self, places: Points) -> Floats:
        """Distances from some places (n, 3) to the surface, mm."""
        return self._surface.distances(places)

    def spheres(self, centers: Points, directions: Points, until: Until) -> InscribedSpheres:
        """`inscribed_spheres` at places (n, 3), each climbed to straight from its place.

        Directions (n, 3) are of unit length.
        """
        begin = InscribedSpheres(centers, self._surface.distances(centers))
        return climbed(self._surface, begin, across(directions), until, first_box=WAY_BOX)


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
    axes, around = across(directions[both]), surface.triangles_round(starts)
    rough = rough_spheres(surface, starts, axes, until.at(both), around)
    anew = exact_spheres(surface, starts, axes, rough, until.at(both))
    # What is larger as seen from one side only may be another vessel's.
    radii = np.where(np.isnan(anew.radii), np.inf, anew.radii).reshape(2, -1)
    smaller = anew.at(np.arange(len(stuck)) + len(stuck) * radii.argmin(axis=0))
    free = _see_each_other(surface, smaller, found.at(stuck))
    found.centers[stuck[free]], found.radii[stuck[free]] = smaller.at(free)


def _see_each_other(
    surface: LocalSurface, spheres: InscribedSpheres, others: InscribedSpheres
) -> Indices:
    """Indices (k,) of the pairs of spheres without wall between their centers."""
    offset = others.centers - spheres.centers
    gone, whole = spheres.radii.copy(), norm(offset)
    found = gone > whole - others.radii
    for _ in range(ROUNDS):
        left = np.flatnonzero(~found & (gone < whole))
        if not len(left):
            break
        places = spheres.centers[left] + (gone[left] / whole[left])[:, None] * offset[left]
        gone[left] += surface.distances(places)
        found[left] = gone[left] > whole[left] - others.radii[left]
    return np.flatnonzero(found)


def _parts(centers: Points, triangles: Floats) -> Iterator[Indices]:
    """Stations that are searched together: near each other, with not too many triangles (n,)."""
    todo = [np.arange(len(centers))] if len(centers) else []
    # Ends: parts are halved until they are small, or one station.
    while todo:
        part = todo.pop()
        if len(part) == 1 or triangles[part].sum() <= PAIRS:
            yield part
            continue
        half = len(part) // 2
        widest = int(np.ptp(centers[part], axis=0).argmax())
        order = np.argpartition(centers[part, widest], half)
        todo += [np.sort(part[order[:half]]), np.sort(part[order[half:]])]


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
