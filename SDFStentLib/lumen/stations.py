"""Stations along an axis, and the width of the lumen there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import Surface, SurfaceIndex
from ..validation import Flags, Floats, Indices, Points
from .caps import in_caps
from .cross_section import equivalent_diameters
from .spheres import InscribedSpheres, inscribed_spheres
from .tolerances import ALIKE, OWN_WIDTH

SPACING = 1.0
"""Distance of the stations along a vessel, mm."""

FINE_STATIONS = 17
"""Places between the neighbors of a station where a lumen is looked at more closely: a smooth
throat is missed by less than 0.03 % of its reference."""

NEARLY = 1.05
"""Ratio to the narrowest station up to which others are looked at so, too: a wall of triangles has
dips that are shorter than stations are apart."""

MOST = 20_000
"""Stations of a line at most, and those that are kept for a surface, about 100 bytes each: a line
of kilometers is in another unit."""

CLOSELY = 3
"""Most places of a stent, or of a vessel beside it, that are looked at closely."""


class Stations(NamedTuple):
    """Places along an axis in order, and the measured lumen there.

    Attributes
    ----------
    points, directions : (n, 3) arrays
        Points on the axis, mm, and unit directions of the axis.
    spheres : InscribedSpheres
        The spheres; NaN where none is known.
    equivalent : (n,) array
        Equivalent diameters of the sections across, mm; NaN where there is none.
    """

    points: Points
    directions: Points
    spheres: InscribedSpheres
    equivalent: Floats

    def at(self, which: Indices | slice) -> Stations:
        """Some of the stations."""
        points, directions, spheres, equivalent = self
        return Stations(points[which], directions[which], spheres.at(which), equivalent[which])

    def among(self, which: Indices, points: Points, directions: Points) -> Stations:
        """These stations as some of others; nothing is known at the rest."""
        centers, values = np.full((len(points), 3), np.nan), np.full((2, len(points)), np.nan)
        centers[which] = self.spheres.centers
        values[:, which] = self.spheres.radii, self.equivalent
        return Stations(points, directions, InscribedSpheres(centers, values[0]), values[1])

    def sections(self, surface: Surface, caps: Flags) -> Floats:
        """Equivalent diameters (n,) of the sections across, mm, as of `measured_at`."""
        points, triangles = surface.points, surface.triangles
        places, ways, (_, radii), _ = self
        found = equivalent_diameters(points, triangles, places, ways)
        if not caps.any():
            return found
        # Beside a cap; farther away one belongs to a vessel into which the section opens.
        known = np.flatnonzero(radii > 0)
        near = SurfaceIndex(points, triangles.compress(caps, axis=0))
        beside = known[np.unique(near.near(places[known], OWN_WIDTH * radii[known]).query)]
        wall = triangles.compress(~caps, axis=0)
        found[beside] = np.nan
        # In the plane of an end rounding decides whether a section is closed.
        for aside in (0.0, 1 - ALIKE, ALIKE - 1):
            left = beside[np.isnan(found[beside])]
            at = places[left] + aside * radii[left, None] * ways[left]
            found[left] = equivalent_diameters(points, wall, at, ways[left])
        return found

    def followed_by(self, others: Stations) -> Stations:
        """These stations followed by others of the same surface."""
        spheres = zip(self.spheres, others.spheres, strict=True)
        return Stations(
            np.concatenate([self.points, others.points]),
            np.concatenate([self.directions, others.directions]),
            InscribedSpheres(*(np.concatenate(column) for column in spheres)),
            np.concatenate([self.equivalent, others.equivalent]),
        )


def measured_at(
    surface: Surface, points: Points, directions: Points, caps: Flags | None = None
) -> Stations:
    """Spheres and sections at places (n, 3) with directions (n, 3), wherever they are.

    Spheres do not meet the triangles in `caps` (m,), by default those of flat caps: one would climb
    along a cap, in many small steps, and touch what is no wall. A section is NaN where a cap cuts
    it off.
    """
    caps = in_caps(surface) if caps is None else caps
    wall = surface.triangles.compress(~caps, axis=0)
    spheres = inscribed_spheres(surface.points, wall, points, directions)
    measured = Stations(points, directions, spheres, np.full(len(points), np.nan))
    return measured._replace(equivalent=measured.sections(surface, caps))
