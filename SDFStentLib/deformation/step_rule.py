"""What every radius-step rule needs to know."""

from __future__ import annotations

from dataclasses import dataclass

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
    """

    influence_distance: float
    contact_tolerance: float
    step: float
    tolerance: float
    falloff: Profile
    blend: Profile
