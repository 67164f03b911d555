"""Diameters along a stent and beyond both of its ends."""

from __future__ import annotations

import numpy as np

from ..geometry import Surface, cut
from .extended_axis import ExtendedAxis
from .metrics import DiameterProfile, diameter_profile


def profile_around(
    surface: Surface, axis: ExtendedAxis, own: DiameterProfile, spacing: float = 1.0
) -> DiameterProfile:
    """The profile of a stent, led on as far as its extended axis goes.

    Parameters
    ----------
    surface : Surface
        mm.
    axis : ExtendedAxis
        Of the stent.
    own : DiameterProfile
        `diameter_profile` along the stent, of the same surface.
    spacing : float
        Of the stations beyond the ends, mm.

    Returns
    -------
    DiameterProfile
        Positions count from the proximal end of the stent: negative proximal of it.
    """
    last = axis.before + axis.stent_length
    parts = [own]
    if axis.before > 0:
        proximal = diameter_profile(surface, cut(axis.points, 0.0, axis.before), spacing)
        # The end of the stent is a station of its own profile.
        parts = [proximal.taken(slice(None, -1)).shifted(-axis.before), *parts]
    if axis.after > 0:
        distal = diameter_profile(surface, cut(axis.points, last, np.inf), spacing)
        parts = [*parts, distal.taken(slice(1, None)).shifted(axis.stent_length)]
    return DiameterProfile.joined(parts)
