"""What every radius-step rule needs to know, and the motion that it gives to free points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..validation import Floats
from .profiles import Profile


@dataclass(frozen=True)
class StepRule:
    """Distances, mm, and profiles of a radius step.

    Attributes
    ----------
    influence_distance : float
        Distance at which the deformation has decayed to zero.
    contact_tolerance : float
        Signed distance below which a point is in contact.
    step : float
        Radius step; the longest one where steps adapt.
    tolerance : float
        Largest estimated error of an adaptive step.
    falloff, blend : Profile
        Weights over the signed distance and over the distance to the nearest contact point.
    first_share : float
        First adaptive step over the longest: before contact no rate is known to predict with.
    """

    influence_distance: float
    contact_tolerance: float
    step: float
    tolerance: float
    falloff: Profile
    blend: Profile
    first_share: float = 0.125

    def rates(self, level_above: Floats, contact_distance: Floats) -> Floats:
        """Motion per radius growth of points that are not in contact, in [0, 1].

        Parameters
        ----------
        level_above : (n,) array
            Signed distance to the stent, mm.
        contact_distance : (n,) array
            Distance to the nearest contact point, mm; infinite where there is none.
        """
        near = np.minimum(contact_distance / self.influence_distance, 1)
        above = np.minimum(np.maximum(level_above / self.influence_distance, 0), 1)
        return self.falloff(above) * self.blend(near)
