"""Proof that a surface is sound, and that a deployment left it so."""

from __future__ import annotations

from .certificate import Certificate, certificate_of, certify, check_surface
from .face_quality import Comparison, Verdict, degenerate_triangles, inverted_triangles
from .intersections import self_intersecting_triangles
from .promises import NARROWER, WIDER, LumenCheck, MotionCheck, Place

__all__ = [
    "NARROWER",
    "WIDER",
    "Certificate",
    "Comparison",
    "LumenCheck",
    "MotionCheck",
    "Place",
    "Verdict",
    "certificate_of",
    "certify",
    "check_surface",
    "degenerate_triangles",
    "inverted_triangles",
    "self_intersecting_triangles",
]


def __dir__() -> list[str]:
    return __all__
