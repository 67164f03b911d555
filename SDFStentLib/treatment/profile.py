"""The diameters of a stent along its axis, in the vessel that it is put into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry import Surface, nearest_distances
from ..lumen import off_caps
from ..stent import Stent, StentAxis
from ..validation import Floats


def with_profile(axis: StentAxis, stent: Stent, surface: Surface) -> StentAxis:
    """The axis of a stent with the diameters that it has along it; unchanged for a cylinder.

    Raises
    ------
    InputError
        Ends that are together longer than the stent.
    """
    if stent.shape is None:
        return axis
    profile = stent.shape.along(
        stent.diameter, axis.deployed_length, narrowest_fraction(axis, surface)
    )
    return replace(axis, profile=profile)


def narrowest_fraction(axis: StentAxis, surface: Surface) -> float:
    """Part of its length at which the vessel round an axis is narrowest.

    By its inscribed radius; where that is not known, by the nearest vertex of the wall.
    """
    radius = axis.inscribed_radius
    if not np.isfinite(radius).any():
        radius = nearest_distances(axis.points, off_caps(surface))
    along = axis.line.arc_lengths
    return float(along[np.nanargmin(radius)] / along[-1])


def prescribed_diameters(stent: Stent, axis: StentAxis, arc_length: Floats) -> Floats:
    """Diameters, mm, that a stent shall have at some arc lengths of its axis."""
    if axis.profile is None:
        return np.full(len(arc_length), float(stent.diameter))
    return axis.profile.at(arc_length / axis.deployed_length)
