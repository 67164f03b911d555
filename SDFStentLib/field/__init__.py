"""The stent as a distance field: a chain of capsules, joined by a smooth minimum."""

from __future__ import annotations

from .capsule_chain import FOLDS, CapsuleChain, as_chain, radius_correction
from .chain_field import Field
from .radius_shares import RadiusShares, fractions_of

__all__ = [
    "FOLDS",
    "CapsuleChain",
    "Field",
    "RadiusShares",
    "as_chain",
    "fractions_of",
    "radius_correction",
]


def __dir__() -> list[str]:
    return __all__
