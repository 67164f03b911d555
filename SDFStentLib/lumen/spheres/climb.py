"""Climb of a sphere to the middle of a lumen.

The center is free in the plane through the axis point normal to the axis. It climbs: at a center c
every nearby triangle i has a distance d_i and a unit direction g_i away from it, and because the
distance to a triangle is convex,

    d_i(c + x) >= d_i + g_i x.

The step x therefore solves a small linear program, largest t with t <= d_i + g_i x and x in a
box, and the true distance after the step is at least t: every step climbs. The new center lies
inside the old sphere, which holds no wall, so a center can never pass through one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...validation import Floats, Indices, Points
from ..tolerances import ROUNDING, ROUNDS
from .local_surface import LocalSurface
from .max_min_step import largest_steps
from .near_walls import Neighborhood
from .wall_points import WallPoints

_FIRST_BOX, _SMALLEST_BOX, _LARGEST_BOX = 0.05, 0.005, 0.5
"""Half width of the box of a step, as a fraction of the present radius. With 0.5 even the corner
of the box is nearer than the wall."""

WAY_BOX = 0.25
"""Box on a way: from one place to the next the middle moves farther than a search's end does. Where
spheres end does not depend on it."""

CORNERS = 2 * np.sqrt(2)
"""Distance beyond a radius, in half widths of the box, past which wall plays no part in a step:
inside the box the radius grows and every distance shrinks by at most its half diagonal."""

ROUGHLY = 60
"""Number of the wall's points round a sphere that tell about where it ends."""

_ALIKE = 4
"""Ratio of the triangles round two places up to which these are searched roughly together: every
step of a search costs something."""

_FINER = 30
"""Factor on their number from one rough search to the next."""


class InscribedSpheres(NamedTuple):
    """Centers (n, 3) and radii (n,), mm; NaN in both where there is no lumen round the point."""

    centers: Points
    radii: Floats

    def at(self, which: Indices | slice) -> InscribedSpheres:
        """Some of them."""
        return InscribedSpheres(self.centers[which], self.radii[which])


class Until(NamedTuple):
    """Criteria that end the search for a sphere."""

    tolerance: float = 1e-6
    """A center stays when the linear model promises less gain than this, mm."""
    enough: Floats | float = np.inf
    """(n,) or one for all: a center stays, too, when its sphere is larger than this, mm."""

    def at(self, which: Indices | slice) -> Until:
        """The ends of the searches for some spheres."""
        enough = np.asarray(self.enough)
        return self._replace(enough=enough[which]) if enough.ndim else self


def exact_spheres(
    surface: LocalSurface, starts: Points, axes: Floats, rough: InscribedSpheres, until: Until
) -> InscribedSpheres:
    """Climb on the wall from rough spheres, then make sure that no wall lies between."""
    centers, bounds = rough.centers.copy(), rough.radii.copy()
    lost = np.isnan(bounds)
    centers[lost], bounds[lost] = starts[lost], surface.distances(starts[lost])
    # Most hold their axis points however small they may be in the end.
    moved = np.linalg.norm(centers - starts, axis=1)
    some = np.flatnonzero(~(moved < surface.least(centers) - ROUNDING))
    found = InscribedSpheres(centers[some], surface.distances(centers[some]))
    bounds[some[_beyond_wall(surface, starts[some], axes[some], found)]] = np.nan
    box = np.where(lost, _FIRST_BOX, _SMALLEST_BOX)
    begin = InscribedSpheres(centers, bounds)
    spheres = climbed(surface, begin, axes, until, first_box=box)
    return in_their_lumen(surface, starts, axes, until, spheres)[0]


def in_their_lumen(
    surface: LocalSurface, starts: Points, axes: Floats, until: Until, found: InscribedSpheres
) -> tuple[InscribedSpheres, Indices]:
    """Spheres, those climbed to anew that a wall may part from their axis points, and which."""
    centers, radii = found
    again, exact = _apart(surface, starts, found)
    begin = InscribedSpheres(starts[again], exact)
    centers[again], radii[again] = climbed(surface, begin, axes[again], until.at(again))
    return InscribedSpheres(centers, radii), again


def _apart(
    surface: LocalSurface, starts: Points, found: InscribedSpheres
) -> tuple[Indices, Floats]:
    """Spheres that a wall may part from their axis points, and how far it is from those, mm."""
    # Empty spheres that overlap lie in the same lumen, and most hold the axis point anyway.
    moved = np.linalg.norm(found.centers - starts, axis=1)
    doubtful = np.flatnonzero(~(moved < found.radii - ROUNDING))
    exact = surface.distances(starts[doubtful])
    is_apart = ~(moved[doubtful] < found.radii[doubtful] + exact - ROUNDING)
    return doubtful[is_apart], exact[is_apart]


def _beyond_wall(
    surface: LocalSurface, starts: Points, axes: Floats, found: InscribedSpheres
) -> Indices:
    """Spheres beyond a closed section of the wall round their axis points.

    A center stays in its plane and passes through no wall: however far such a sphere climbs, often
    out of the whole surface, it will be apart.
    """
    apart, _ = _apart(surface, starts, found)
    parted = [surface.parts(starts[n], found.centers[n], axes[n]) for n in apart.tolist()]
    return apart[np.array(parted, dtype=bool)]


def rough_spheres(
    surface: LocalSurface, starts: Points, axes: Floats, until: Until, around: Floats
) -> InscribedSpheres:
    """Spheres among points of the wall, few first; radii are no smaller than to the wall.

    NaN where that leads out of the surface, and where the wall has few triangles `around` (n,).
    """
    found = InscribedSpheres(starts.copy(), np.full(len(starts), np.nan))
    # Among about as many points round every sphere, whatever its size and what else is searched:
    # where a lumen is widest in two places, the first steps decide between them.
    size = np.floor(np.log(np.maximum(around, 1) / ROUGHLY) / np.log(_ALIKE)).astype(int)
    is_told = around > ROUGHLY / 2
    for each in np.unique(size[is_told]).tolist():
        own = np.flatnonzero(is_told & (size == each))
        stride = max(1.0, float(_ALIKE) ** each)
        spheres = _among_points(surface, stride, starts[own], axes[own], until.at(own))
        found.centers[own], found.radii[own] = spheres
    return found


def _among_points(
    surface: LocalSurface, stride: float, starts: Points, axes: Floats, until: Until
) -> InscribedSpheres:
    """Spheres among the middles of one triangle of so many, then of more of them."""
    centers, radii = starts.copy(), np.full(len(starts), np.nan)
    strides = [stride]
    # Ends: what is appended falls to 2.
    while strides[-1] > 2 * _FINER:
        strides.append(strides[-1] / _FINER)
    for number, each in enumerate(strides):
        wall = WallPoints(surface, each)
        centers = np.where(np.isnan(radii)[:, None], starts, centers)
        begin = InscribedSpheres(centers, wall.distances(centers))
        box = 2 * _SMALLEST_BOX if number else _FIRST_BOX
        centers, radii = climbed(wall, begin, axes, until, first_box=box)
    return InscribedSpheres(centers, radii)


def climbed(
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
    active = np.flatnonzero(radii > ROUNDING)
    near = Neighborhood(surface, len(centers))
    for _ in range(ROUNDS):
        if len(active) == 0:
            break
        reach = CORNERS * box[active]
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
        box[active] = next_boxes(step, height, box[active])
        outside = np.any((centers < surface.lowest) | (centers > surface.highest), axis=1)
        centers[outside], radii[outside] = np.nan, np.nan
        active = active[~outside[active]]
    if len(active):
        radii[active] = surface.distances(centers[active])
    return spheres


def next_boxes(step: Floats, height: Floats, box: Floats) -> Floats:
    """Half widths (n,) of the next boxes after steps (n, 2) to some heights: wider where a box held
    its step."""
    is_held = np.abs(step).max(axis=1) > 0.99 * box
    wanted = np.where(is_held, 3 * box, 2 * np.linalg.norm(step, axis=1))
    return np.clip(wanted, _SMALLEST_BOX * height, _LARGEST_BOX * height)
