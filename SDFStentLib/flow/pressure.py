"""Pressure drop of a stretch of vessel by published closed forms, as a band.

No closed form is a measurement: against a solver, or a catheter, each is wrong by as much as the
whole difference between them, and after a stent all are too low. What is said is a band.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..lumen import DiameterProfile
from ..units import MOST_FLOW
from ..validation import Floats, InputError, as_number
from .blood import ADULT, PASCAL_PER_MMHG, Blood
from .integral import integral_to

TURBULENCE = 1.52
"""K_t of the loss behind a stenosis (Young and Tsai, J Biomech 1973;6:395)."""

NARROWED = 0.3
"""Share by which a stretch is narrower than its ends from which it is a stenosis and no less."""

TOO_LOW = {True: 1.66, False: 3.4}
"""By how much the forms may be too low. In a stenosis 1.46 to 1.664 (fits to computed flow in
coronary arteries); without one the losses at the entry, which they lack, prevail: 2 to 3.4 times
in the one stented artery that was compared with a solver."""


class VesselBlock(NamedTuple):
    """What a lumped (0D) model of a stretch of vessel needs, in SI units.

    The drop is `resistance * Q + stenosis * Q * abs(Q) + inertance * dQ/dt`.
    """

    length: float
    """m."""
    resistance: float
    """Poiseuille along the lumen, Pa s/m^3."""
    stenosis: float
    """Loss behind the narrowest place, Pa s^2/m^6."""
    inertance: float
    """Pa s^2/m^3."""
    narrowest: float
    """Area, m^2."""


class PressureBand(NamedTuple):
    """Between the lowest of the closed forms and the highest times what it may be too low."""

    flow: float
    """mL/s."""
    low: float
    """mmHg."""
    high: float
    """mmHg."""


def vessel_block(arc_length: Floats, diameter: Floats, blood: Blood = ADULT) -> VesselBlock:
    """The lumped model of a stretch of vessel.

    Parameters
    ----------
    arc_length, diameter : (n,) arrays
        Stations along it and the diameter there, mm.
    blood : Blood

    Raises
    ------
    InputError
        Fewer than two stations, or a diameter that is not known.
    """
    if len(arc_length) < 2 or not np.isfinite(diameter).all():
        raise InputError(
            "pressure: expected diameters along a stretch of vessel, some are not known; "
            "choose another stretch."
        )
    x, area = 1e-3 * np.asarray(arc_length), np.pi / 4 * (1e-3 * np.asarray(diameter)) ** 2
    healthy, narrowest = 0.5 * (area[0] + area[-1]), float(area.min())
    ratio = max(healthy / narrowest - 1.0, 0.0)
    return VesselBlock(
        length=float(x[-1] - x[0]),
        resistance=8 * np.pi * blood.viscosity * float(integral_to(area**-2.0, x)[-1]),
        stenosis=TURBULENCE * blood.density / (2 * healthy**2) * ratio**2,
        inertance=blood.density * float(integral_to(1 / area, x)[-1]),
        narrowest=narrowest,
    )


def pressure_band(profile: DiameterProfile, flow: float, blood: Blood = ADULT) -> PressureBand:
    """The pressure drop over a stretch of vessel at a steady flow, as a band.

    Its low end is the lowest of three closed forms, its high end the highest of them times what
    they are known to be too low (`TOO_LOW`): Poiseuille's loss along the lumen and Young and
    Tsai's loss behind the narrowest place, of the inscribed diameters and of the equivalent
    ones, and 4 v^2 of the mean velocity in the narrowest inscribed circle.

    Parameters
    ----------
    profile : DiameterProfile
        Along the stretch, without a side branch in it: flow that leaves there is not known.
    flow : float
        Steady, mL/s.
    blood : Blood

    Raises
    ------
    InputError
        A flow that is not positive, or a diameter of the profile that is not known.
    """
    flow = as_number(flow, "flow", unit="mL/s", above=0, maximum=MOST_FLOW)
    blocks = [
        vessel_block(profile.arc_length, diameter, blood)
        for diameter in (profile.inscribed_diameter, profile.equivalent_diameter)
    ]
    forms = [*(_steady(block, flow) for block in blocks), _bernoulli(blocks[0], flow)]
    ends = profile.inscribed_diameter[[0, -1]]
    return PressureBand(flow, *band_of(forms, 1 - profile.minimum / float(ends.mean())))


def band_of(forms: Sequence[float], narrowing: float) -> tuple[float, float]:
    """Low and high end of what some closed forms say, by the share that a vessel is narrowed.

    From a vessel without a stenosis to one what they are too low by changes evenly.
    """
    too_low = float(np.interp(narrowing, (0.0, NARROWED), (TOO_LOW[False], TOO_LOW[True])))
    return min(forms), too_low * max(forms)


def _steady(block: VesselBlock, flow: float) -> float:
    q = 1e-6 * flow
    return (block.resistance + block.stenosis * q) * q / PASCAL_PER_MMHG


def _bernoulli(block: VesselBlock, flow: float) -> float:
    """4 v^2 in mmHg, v in m/s, as echocardiography has it."""
    return 4 * (1e-6 * flow / block.narrowest) ** 2
