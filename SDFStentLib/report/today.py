"""The result of today of a plan that dilates a stent again later, as it is told."""

from __future__ import annotations

import math
from typing import Any

from ..plan import Today
from .lesions import degree_change
from .words import UNKNOWN


def today_sentences(today: Today | None) -> list[str]:
    """Lumen and stenosis before a stent is dilated again; none for a plan without a redilation."""
    if today is None:
        return []
    lumens = [
        f"stent {number} {UNKNOWN if math.isnan(width) else f'{width:.2f} mm'}"
        for number, width in today.minimum_lumen.items()
    ]
    degrees = [degree_change(one) for one in today.lesions or () if one.stents]
    stenosis = f"; stenosis by diameter: {'; '.join(degrees)}" if degrees else ""
    return [
        f"Today, before the redilation as stent {today.redilation}: narrowest lumen "
        f"{', '.join(lumens)}{stenosis}. All else is of the later result."
    ]


def today_section(today: Today | None) -> dict[str, Any] | None:
    """The same as values of JSON; null for a plan without a redilation."""
    if today is None:
        return None
    return {
        "before_stent": today.redilation,
        "stents": [
            {"number": number, "minimum_lumen_mm": width}
            for number, width in today.minimum_lumen.items()
        ],
        "lesions": None
        if today.lesions is None
        else [
            {
                "number": one.number,
                "stents": list(one.stents),
                "minimum_diameter_mm": one.after.minimum_diameter,
                "percent_diameter": one.after.percent_diameter,
            }
            for one in today.lesions
            if one.stents
        ],
        "sentences": today_sentences(today),
    }
