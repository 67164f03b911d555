"""Slivers, in an input or newly: no fault, but something to know before meshing."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..cautions import Caution
from ..validation import Indices, Place, Points, Triangles, as_place, read_only
from .face_quality import SLIVER_DEG, smallest_angles

MUCH_WORSE = 0.5
"""Share of its smallest angle that a triangle must have lost to be called much worse."""


class Slivers(NamedTuple):
    """Slivers of a surface.

    Attributes
    ----------
    triangles : (k,) array
        Ascending.
    angle, before : float
        Smallest angle of the worst, and that of the same triangle before, degrees; NaN for none.
    at : (x, y, z), optional
        Where the worst is, mm.
    """

    triangles: Indices
    angle: float = float("nan")
    before: float = float("nan")
    at: Place | None = None

    def cautions(self) -> tuple[Caution, ...]:
        """For the person who will mesh the surface; none without slivers."""
        if not len(self.triangles):
            return ()
        numbers = {"triangles": len(self.triangles), "angle_deg": self.angle}
        if np.isnan(self.before):
            return (Caution("slivers", numbers, self.at),)
        return (Caution("new-slivers", {**numbers, "before_deg": self.before}, self.at),)

    def as_dict(self) -> dict[str, Any]:
        """As it stands in a report."""
        found = bool(len(self.triangles))
        return {
            "triangle_ids": self.triangles.tolist(),
            "worst_deg": self.angle if found else None,
            "worst_before_deg": None if np.isnan(self.before) else self.before,
            "worst_at_mm": None if self.at is None else list(self.at),
        }


def slivers_among(
    points: Points, triangles: Triangles, among: Indices, before: Points | None = None
) -> Slivers:
    """The triangles with an angle below `SLIVER_DEG`; those that became so, where told.

    Parameters
    ----------
    points : (n, 3) array
        As stored, but in mm.
    triangles : (m, 3) array
    among : (k,) array
        Indices of the triangles to judge, ascending.
    before : (n, 3) array, optional
        Where the points were: only triangles that lost `MUCH_WORSE` of their smallest angle count.
    """
    angles = smallest_angles(points, triangles[among])
    found = angles < SLIVER_DEG
    among, angles = among[found], angles[found]
    were = np.full(len(among), np.nan)
    if before is not None:
        were = smallest_angles(before, triangles[among])
        found = angles <= (1 - MUCH_WORSE) * were
        among, angles, were = among[found], angles[found], were[found]
    if not len(among):
        return Slivers(read_only(among))
    worst = int(angles.argmin())
    middle = as_place(points[triangles[among[worst]]].mean(axis=0))
    return Slivers(read_only(among), float(angles[worst]), float(were[worst]), middle)
