"""How wide a lumen is, what a stent covers, and how far tissue was stretched."""

from __future__ import annotations

from .caps import bulged_caps, caps_across
from .coverage import BranchOstium, branch_ostia
from .cross_section import equivalent_diameters, winding_numbers
from .inscribed import InscribedSpheres, inscribed_spheres
from .lesion_value import HealthyPlace, Lesion
from .lesions import find_lesions, lesion_after, lesion_against, lesions_within
from .local_surface import LocalSurface
from .metrics import DiameterProfile, diameter_profile
from .narrowings import SMALLEST_DEGREE
from .stretch import displacements, face_stretches
from .tree_lumen import closed_surface

__all__ = [
    "SMALLEST_DEGREE",
    "BranchOstium",
    "DiameterProfile",
    "HealthyPlace",
    "InscribedSpheres",
    "Lesion",
    "LocalSurface",
    "branch_ostia",
    "bulged_caps",
    "caps_across",
    "closed_surface",
    "diameter_profile",
    "displacements",
    "equivalent_diameters",
    "face_stretches",
    "find_lesions",
    "inscribed_spheres",
    "lesion_after",
    "lesion_against",
    "lesions_within",
    "winding_numbers",
]


def __dir__() -> list[str]:
    return __all__
