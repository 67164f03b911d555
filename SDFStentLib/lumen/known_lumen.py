"""The lumen of a surface, every station measured once for as long as the surface is in use."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from ..geometry import Surface
from ..validation import Floats, Points, Triangles
from .closed_ends import OpenWall
from .cross_section import equivalent_diameters
from .moved_wall import MovedWall
from .spheres import InscribedSpheres, inscribed_spheres
from .stations import Stations, measured_at

_BESIDE = 1.02
"""Wall farther from a sphere's center than so many radii plays no part in its climb's end."""

MOST = 20_000
"""Stations that are kept of one surface, about 100 bytes each; then all are forgotten."""

_known: WeakKeyDictionary[Surface, dict[tuple[bytes, bytes], Floats]] = WeakKeyDictionary()
"""By place and direction, and caps left out: center and radius of sphere, equivalent diameter."""


def measured_once(
    surface: Surface, points: Points, directions: Points, wall: OpenWall | None = None
) -> Stations:
    """`measured_at` of a vessel before treatment; what was measured there before is not again.

    A surface cannot change, and nothing about a stent but its axis matters: where another diameter
    is tried, or another stent moved, all is known.
    """
    known = _known.setdefault(surface, {})
    # Two stents may leave out different caps.
    seen, caps = (None, b"") if wall is None else (wall.triangles, wall.caps.tobytes())
    rows = np.column_stack([points, directions])
    keys = [(row.tobytes(), caps) for row in rows]
    if len(known) > MOST:
        known.clear()
    # Read once: another thread may forget everything meanwhile.
    found = [known.get(key) for key in keys]
    missing = np.array([values is None for values in found], dtype=bool)
    if missing.any():
        anew = measured_at(surface, points[missing], directions[missing], seen)
        measured = np.column_stack([anew.spheres.centers, anew.spheres.radii, anew.equivalent])
        for index, values in zip(np.flatnonzero(missing), measured, strict=True):
            known[keys[index]] = found[index] = values
    stations = np.array(found, dtype=np.float64).reshape(-1, 5)
    spheres = InscribedSpheres(stations[:, :3].copy(), stations[:, 3].copy())
    return Stations(points, directions, spheres, stations[:, 4].copy())


def measured_after(
    before: Stations, moved: MovedWall, surface: Surface, wall: Triangles | None = None
) -> Stations:
    """`measured_at` of a vessel after treatment; what nothing has moved near is as it was.

    Parameters
    ----------
    before : Stations
        What was measured before it.
    moved : MovedWall
        From then to now.
    surface : Surface
        After it.
    wall : (k, 3) array, optional
        Its triangles that spheres see.
    """
    points, directions = before.points, before.directions
    centers, radii = before.spheres.centers.copy(), before.spheres.radii.copy()
    equivalent = before.equivalent.copy()
    changed = np.flatnonzero(moved.comes_near(centers, _BESIDE * radii) | ~(radii > 0))
    seen = surface.triangles if wall is None else wall
    centers[changed], radii[changed] = inscribed_spheres(
        surface.points, seen, points[changed], directions[changed]
    )
    cut = np.flatnonzero(moved.crosses(points, directions))
    equivalent[cut] = equivalent_diameters(
        surface.points, surface.triangles, points[cut], directions[cut]
    )
    return Stations(points, directions, InscribedSpheres(centers, radii), equivalent)
