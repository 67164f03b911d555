"""What is on a tree of vessels: where one goes on and another begins, and where it is narrow."""

from __future__ import annotations

from .lesion_measuring import lesions_after
from .lesion_value import HealthyPlace, Lesion
from .lesions import SMALL_VESSEL, find_lesions, lesion_after, lesions_within
from .marked_reference import lesion_against, lesions_against
from .narrowings import SMALLEST_DEGREE

__all__ = [
    "SMALLEST_DEGREE",
    "SMALL_VESSEL",
    "HealthyPlace",
    "Lesion",
    "find_lesions",
    "lesion_after",
    "lesion_against",
    "lesions_after",
    "lesions_against",
    "lesions_within",
]


def __dir__() -> list[str]:
    return __all__
