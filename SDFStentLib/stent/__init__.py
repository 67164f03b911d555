"""A stent: its size, where it goes, and the axis that follows from both."""

from __future__ import annotations

from .beside import beside, placement_points
from .device import CELLS, MAXIMUM_DIAMETER, MAXIMUM_LENGTH, Device
from .placement import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    ByValue,
    InputFile,
    Placement,
)
from .stent import DEFAULT_FORESHORTENING, Stent
from .stent_axis import StentAxis, stent_axis, straightened, straightened_axis

__all__ = [
    "CELLS",
    "DEFAULT_FORESHORTENING",
    "MAXIMUM_DIAMETER",
    "MAXIMUM_LENGTH",
    "AlongAxis",
    "AtCenter",
    "AtDistalEnd",
    "AtProximalEnd",
    "BetweenPoints",
    "ByValue",
    "Device",
    "InputFile",
    "Placement",
    "Stent",
    "StentAxis",
    "beside",
    "placement_points",
    "stent_axis",
    "straightened",
    "straightened_axis",
]


def __dir__() -> list[str]:
    return __all__
