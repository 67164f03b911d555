"""A stent: its size, where it goes, and the axis that follows from both."""

from __future__ import annotations

from .balloon import (
    MOST_RECOIL,
    RAISED_RECOIL,
    USUAL_RECOIL,
    WIDE_BALLOON,
    Balloon,
    balloon_by_rule,
)
from .beside import beside, placement_points
from .device import CELLS, MAXIMUM_DIAMETER, MAXIMUM_LENGTH, Device
from .lattice import Lattice, LatticeDesign, design_of, laid_along, stent_lattice, straight_lattice
from .placement import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtProximalEnd,
    BetweenPoints,
    ByValue,
    InputFile,
    OfStent,
    Placement,
)
from .redilation import dilated_again, redilated
from .shape import DiametersAlong, Shape, StentEnd, Waist
from .stent import DEFAULT_FORESHORTENING, KEPT, Stent
from .stent_axis import StentAxis, moved_axis, stent_axis
from .straightened import TurnedWay, straight_way, straightened, turned_way

__all__ = [
    "CELLS",
    "DEFAULT_FORESHORTENING",
    "KEPT",
    "MAXIMUM_DIAMETER",
    "MAXIMUM_LENGTH",
    "MOST_RECOIL",
    "RAISED_RECOIL",
    "USUAL_RECOIL",
    "WIDE_BALLOON",
    "AlongAxis",
    "AtCenter",
    "AtDistalEnd",
    "AtProximalEnd",
    "Balloon",
    "BetweenPoints",
    "ByValue",
    "Device",
    "DiametersAlong",
    "InputFile",
    "Lattice",
    "LatticeDesign",
    "OfStent",
    "Placement",
    "Shape",
    "Stent",
    "StentAxis",
    "StentEnd",
    "TurnedWay",
    "Waist",
    "balloon_by_rule",
    "beside",
    "design_of",
    "dilated_again",
    "laid_along",
    "moved_axis",
    "placement_points",
    "redilated",
    "stent_axis",
    "stent_lattice",
    "straight_lattice",
    "straight_way",
    "straightened",
    "turned_way",
]


def __dir__() -> list[str]:
    return __all__
