"""Synthetic vessels whose axes, radii and openings are known exactly."""

from __future__ import annotations

from .phantoms import (
    arch_with_coarctation,
    bent_tube,
    branching_pulmonary_artery,
    hairpin_tube,
    helix_tube,
    stenosed_tube,
    straight_tube,
    tube_with_neighbor,
)
from .tree import vascular_tree
from .value import Opening, Phantom, Throat, Vessel

__all__ = [
    "Opening",
    "Phantom",
    "Throat",
    "Vessel",
    "arch_with_coarctation",
    "bent_tube",
    "branching_pulmonary_artery",
    "hairpin_tube",
    "helix_tube",
    "stenosed_tube",
    "straight_tube",
    "tube_with_neighbor",
    "vascular_tree",
]


def __dir__() -> list[str]:
    return __all__
