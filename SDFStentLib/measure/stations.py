"""Stations along an axis, and how wide the lumen is there."""

from __future__ import annotations

from typing import NamedTuple

from ..validation import Floats, Points
from .inscribed import InscribedSpheres


class Stations(NamedTuple):
    """Places along an axis in order, and what is known of the lumen there.

    Attributes
    ----------
    points, directions : (n, 3) arrays
        On the axis, mm, and unit directions of the axis.
    spheres : InscribedSpheres
        NaN where none is known.
    equivalent : (n,) array
        Equivalent diameters of the sections across, mm; NaN where there is none.
    """

    points: Points
    directions: Points
    spheres: InscribedSpheres
    equivalent: Floats
