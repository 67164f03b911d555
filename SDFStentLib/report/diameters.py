"""Diameters along a line through a vessel, as a table and in a document."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..geometry import length
from ..lumen import DiameterProfile
from ..units import MILLIMETERS
from ..validation import Points


class MeasuredLine(NamedTuple):
    """A line (n, 3), mm, along which diameters were measured."""

    title: str
    points: Points
    profile: DiameterProfile


def diameter_table(line: MeasuredLine, units: str) -> str:
    """Lines of text; the ends are in the unit of the file."""
    profile = line.profile
    ends = " to ".join(filed_point(line.points[end], units) for end in (0, -1))
    rows = [
        f"{line.title}: {length(line.points):.1f} mm, from {ends} {units}",
        "  at (mm)  inscribed (mm)  equivalent (mm)",
    ]
    for at, *diameters in zip(
        profile.arc_length, profile.inscribed_diameter, profile.equivalent_diameter, strict=True
    ):
        inscribed, equivalent = map(_cell, diameters)
        rows.append(f"{at:9.1f}  {inscribed:>14}  {equivalent:>15}")
    if math.isfinite(profile.minimum):
        rows.append(
            f"  inscribed: narrowest {profile.minimum:.2f} mm at {profile.minimum_arc_length:.1f} "
            f"mm, mean {profile.mean:.2f} mm, widest {profile.maximum:.2f} mm"
        )
    return "\n".join([*rows, ""])


def diameter_section(line: MeasuredLine) -> dict[str, Any]:
    """Plain values; None where a diameter is not known."""
    profile = line.profile
    return {
        "title": line.title,
        "start_mm": line.points[0].tolist(),
        "end_mm": line.points[-1].tolist(),
        "length_mm": length(line.points),
        "arc_length_mm": profile.arc_length.tolist(),
        "inscribed_mm": [_known(value) for value in profile.inscribed_diameter],
        "equivalent_mm": [_known(value) for value in profile.equivalent_diameter],
        "minimum_mm": _known(profile.minimum),
        "mean_mm": _known(profile.mean),
        "maximum_mm": _known(profile.maximum),
    }


def filed_point(point: Points, units: str) -> str:
    """A point, mm, as a file in that unit has it."""
    return "(" + ", ".join(f"{value / MILLIMETERS[units]:.4g}" for value in point) + ")"


def _cell(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
