"""What flows, and the units in which it is told."""

from __future__ import annotations

from typing import NamedTuple

PASCAL_PER_MMHG = 133.322
PER_ML = 1e-6
"""Cubic meters in a milliliter."""


class Blood(NamedTuple):
    """Of an adult at the shear of large vessels, the values of the SimVascular examples."""

    density: float = 1060.0
    """kg/m^3."""
    viscosity: float = 0.004
    """Pa s."""


ADULT = Blood()
