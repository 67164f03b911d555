"""Proof that a surface is sound, and that a deployment left it so."""

from __future__ import annotations

from .certificate import CERTIFIED, NOT_CERTIFIED, Certificate, certificate_of, certify
from .comparison import Comparison, Verdict
from .intersections import self_intersecting_triangles
from .promises import (
    NARROWER,
    NOTICEABLY_NARROWER,
    WIDER,
    LumenCheck,
    MotionCheck,
    Place,
    WallCheck,
)
from .surface_check import SurfaceCheck, check_surface

__all__ = [
    "CERTIFIED",
    "NARROWER",
    "NOTICEABLY_NARROWER",
    "NOT_CERTIFIED",
    "WIDER",
    "Certificate",
    "Comparison",
    "LumenCheck",
    "MotionCheck",
    "Place",
    "SurfaceCheck",
    "Verdict",
    "WallCheck",
    "certificate_of",
    "certify",
    "check_surface",
    "self_intersecting_triangles",
]


def __dir__() -> list[str]:
    return __all__
