"""The shape of a stent as it is told."""

from __future__ import annotations

from typing import Any

from ..plan import shape_document
from ..treatment import TreatedStent


def shape_section(treated: TreatedStent) -> dict[str, Any] | None:
    """What makes a stent no cylinder, with the profile that came of it; None for a cylinder."""
    shape, profile = treated.stent.shape, treated.axis.profile
    if shape is None or profile is None:
        return None
    return {
        **(shape_document(shape) or {}),
        "fractions": profile.fractions,
        "diameters_mm": profile.diameters,
    }


def prescribed_words(treated: TreatedStent) -> str:
    """The prescribed diameter, or the smallest and the largest one."""
    profile = treated.axis.profile
    if profile is None or profile.diameters.min() == profile.widest:
        return f"{round(treated.stent.diameter, 2):g} mm"
    return f"{profile.diameters.min():.2f} to {profile.widest:.2f} mm"
