"""The shape of a stent as it is told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..plan import shape_document
from ..treatment import TreatedStent
from .words import millimeters, number_text


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


def shape_rows(shape: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Name and value of what makes a stent no cylinder."""
    if shape is None:
        return []
    rows = []
    waist = shape.get("waist")
    if waist:
        rows.append(("Waist", millimeters(waist["diameter"])))
    for key, words in (("start", "Proximal end"), ("end", "Distal end")):
        end = shape.get(key)
        if end:
            sizes = f"{millimeters(end['diameter'])} at the end, over {millimeters(end['length'])}"
            rows.append((f"{words} of the stent", sizes))
    if shape.get("table"):
        rows.append(("Profile", f"a table of {len(shape['table'])} diameters"))
    diameters = shape["diameters_mm"]
    rows.append(("Prescribed along it", f"{min(diameters):.2f} to {max(diameters):.2f} mm"))
    if shape.get("cap_height", 1) != 1:
        rows.append(
            ("Caps beyond its ends", f"{number_text(shape['cap_height'], 2)} of the radius")
        )
    return rows
