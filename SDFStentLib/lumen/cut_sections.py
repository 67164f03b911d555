"""Sections of a vessel at an ostium, without the lumen of the neighbor."""

from __future__ import annotations

import numpy as np

from ..geometry import Line, Surface, frames
from ..validation import Flags, Floats, Points
from .expected_wall import LEAVES, across_alone, expected_wall, far_reach, section_radius
from .openings import labels_round
from .wall_map import RAYS, near_wall, rays_from

SUSPECT = 1.2
"""Equivalent over inscribed diameter that may come of another lumen; openings are looked for."""

FAR = 2.0
"""An opening leads into another lumen if a ray into it goes on for so many expected radii."""


def cut_at_ostia(
    surface: Surface, stations: Points, centers: Points, inscribed: Floats, equivalent: Floats
) -> tuple[Floats, Flags]:
    """Equivalent diameters (n,), and at which stations an ostium cuts them.

    Parameters
    ----------
    surface : Surface
        mm.
    stations, centers : (n, 3) arrays
        Equally spaced axis points, in order, and the centers of the spheres there, mm.
    inscribed, equivalent : (n,) arrays
        Diameters there, mm; NaN where unknown. A section that opens into another lumen has the
        area of both.
    """
    with np.errstate(invalid="ignore"):
        suspect = equivalent > SUSPECT * inscribed
    if not suspect.any():
        return equivalent, suspect
    middles = np.where(np.isfinite(centers), centers, stations)
    near = near_wall(surface, stations, far_reach(surface, stations))
    line = Line(stations)
    wall = rays_from(near, line.arc_lengths, middles, frames(line))
    # A path may end in a junction: its vessel goes on as the section there is without openings.
    ends = across_alone(wall.distance[[0, -1]])
    expected = expected_wall(wall, section_radius(wall.distance), ends)
    leaves = wall.distance > LEAVES * expected
    label = labels_round(leaves)
    far = np.unique(label[leaves & (wall.distance > FAR * expected)])
    leaves &= np.isin(label, far)
    is_cut = suspect & leaves.any(axis=1)
    rays = np.where(leaves, expected, wall.distance)
    # Of the polygon with a corner on every ray.
    area = (rays * np.roll(rays, -1, axis=1)).sum(axis=1) * np.sin(2 * np.pi / RAYS) / 2
    whole = 2 * np.sqrt(area / np.pi)
    is_cut &= np.isfinite(whole)
    return np.where(is_cut, np.fmin(whole, equivalent), equivalent), is_cut
