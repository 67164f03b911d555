"""Fall-off profiles and blending masks of the published method, and the rule of a radius step.

Source: SDFStent, arXiv 2605.22009, section 2 (fall-off, `get_alphas`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats, InputError

Profile = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""A weight as a function of distance over influence distance; called with values in [0, 1]."""


def compact_falloff(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """The paper's fall-off `(1 - x^2)^2`: flat at 0 and at 1."""
    return (1 - fraction**2) ** 2


def wendland_falloff(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Wendland's C2 function `(1 - x)^4 (4 x + 1)`, narrower than the paper's.

    Reference: H. Wendland, Adv. Comput. Math. 4 (1995), doi 10.1007/BF02123482.
    """
    return (1 - fraction) ** 4 * (4 * fraction + 1)


def cosine_falloff(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Half a cosine wave, `(1 + cos pi x) / 2`."""
    return 0.5 * (1 + np.cos(np.pi * fraction))


def linear_blend(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """The paper's blending mask `1 - x`."""
    return 1 - fraction


def quadratic_blend(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Blending mask `(1 - x)^2`."""
    return (1 - fraction) ** 2


def exponential_blend(fraction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Exponential blending mask, scaled to be exactly 1 at 0 and 0 at 1.

    The paper names an exponential mask without its constant; the rate 3 is our choice.
    """
    return np.expm1(3 * (1 - fraction)) / np.expm1(3.0)


FALLOFFS: dict[str, Profile] = {
    "compact": compact_falloff,
    "wendland": wendland_falloff,
    "cosine": cosine_falloff,
}
BLENDS: dict[str, Profile] = {
    "linear": linear_blend,
    "quadratic": quadratic_blend,
    "exponential": exponential_blend,
}


def as_profile(choice: str | Profile, known: dict[str, Profile], name: str) -> Profile:
    """The profile of a given name, or the given function after a check.

    Raises
    ------
    InputError
        An unknown name, or a function that does not fall from 1 at 0 to 0 at 1 within [0, 1].
    """
    if isinstance(choice, str):
        if choice not in known:
            raise InputError(f"{name}: expected one of {', '.join(known)}, got {choice!r}.")
        return known[choice]
    samples = np.asarray(choice(np.linspace(0, 1, 33)), dtype=np.float64)
    fits = (
        samples.shape == (33,)
        and np.isfinite(samples).all()
        and abs(samples[0] - 1) < 1e-9
        and abs(samples[-1]) < 1e-9
        and samples.min() > -1e-9
        and samples.max() < 1 + 1e-9
    )
    if not fits:
        raise InputError(
            f"{name}: expected a function of an array that falls from 1 at 0 to 0 at 1 and stays "
            f"between them, got values from {samples.flat[0]:g} to {samples.flat[-1]:g}."
        )
    return choice


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
        First adaptive step over the longest; before contact no rate is known to predict it from.
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
