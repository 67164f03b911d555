"""What a report tells of one stent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..lumen import DiameterProfile
from ..validation import InputError, read_only
from ..vessel import Apposition, NeighborLumen, Ostium


@dataclass(frozen=True)
class StentResult:
    """What one stent is, and what it did to the lumen.

    `before` and `after` are measured at the same stations, over the stented length; the two
    profiles around it at those and beyond both ends.
    """

    description: Mapping[str, Any]
    """Device, lengths, diameters, axis and profile, with units in the keys (`..._mm`)."""
    before: DiameterProfile
    after: DiameterProfile
    prescribed_diameter: NDArray[np.float64]
    """Per station, mm; one number for all is enough."""
    branches: tuple[Ostium, ...] = ()
    neighbors: tuple[NeighborLumen, ...] = ()
    apposition: Apposition | None = None
    around_before: DiameterProfile | None = None
    around_after: DiameterProfile | None = None
    lesions: tuple[int, ...] | None = None
    """Numbers of the lesions that it covers; None when none were looked for."""

    @property
    def units(self) -> str:
        """Of the surface's file."""
        return str(self.description.get("axis", {}).get("units", "mm"))

    def __post_init__(self) -> None:
        stations = self.before.arc_length.shape
        if self.after.arc_length.shape != stations or not np.allclose(
            self.after.arc_length, self.before.arc_length, rtol=0, atol=1e-6
        ):
            raise InputError(
                "after: expected the stations of the profile before, got "
                f"{len(self.after.arc_length)} others; measure both along the same axis."
            )
        prescribed = np.asarray(self.prescribed_diameter, dtype=np.float64)
        if prescribed.shape not in ((), stations):
            raise InputError(
                f"prescribed_diameter: expected one number or {stations[0]}, "
                f"got shape {prescribed.shape}."
            )
        whole = read_only(np.broadcast_to(prescribed, stations))
        object.__setattr__(self, "prescribed_diameter", whole)


def stent_section(stent: StentResult) -> dict[str, Any]:
    """A stent as a report has it."""
    return {
        **stent.description,
        "lesions": stent.lesions,
        "diameters": _diameter_section(stent),
    }


def _along(stent: StentResult) -> dict[str, Any]:
    """The curves of the plot: nothing is prescribed beyond the ends of the stent."""
    before, after = stent.around_before or stent.before, stent.around_after or stent.after
    at, own = before.arc_length, stent.before.arc_length
    prescribed = np.interp(at, own, stent.prescribed_diameter, left=np.nan, right=np.nan)
    return {
        "arc_length_mm": at,
        "mis_before_mm": before.inscribed_diameter,
        "mis_after_mm": after.inscribed_diameter,
        "equivalent_before_mm": before.equivalent_diameter,
        "equivalent_after_mm": after.equivalent_diameter,
        "prescribed_mm": prescribed,
    }


def _diameter_section(stent: StentResult) -> dict[str, Any]:
    before, after = stent.before, stent.after
    error = after.inscribed_diameter - stent.prescribed_diameter
    return {
        "along": _along(stent),
        "stent_ends_mm": before.arc_length[[0, -1]],
        "over_stented_length": {
            "before": _statistics(before),
            "after": _statistics(after),
            "mean_after_minus_prescribed_mm": _mean(error),
        },
        "minimum_lumen": {
            "before_mm": before.minimum,
            "before_at_mm": before.minimum_arc_length,
            "after_mm": after.minimum,
            "after_at_mm": after.minimum_arc_length,
            **_beyond(stent),
        },
    }


def _beyond(stent: StentResult) -> dict[str, float]:
    """The narrowest of the measured vessel before and behind the stent; NaN where there is none."""
    ends = stent.before.arc_length[[0, -1]]
    found = {}
    for name, around in (("before", stent.around_before), ("after", stent.around_after)):
        least = math.nan
        if around is not None:
            is_beyond = (around.arc_length < ends[0]) | (around.arc_length > ends[1])
            values = around.inscribed_diameter[is_beyond]
            known = values[np.isfinite(values)]
            least = float(known.min()) if len(known) else math.nan
        found[f"beyond_{name}_mm"] = least
    return found


def _statistics(profile: DiameterProfile) -> dict[str, float]:
    return {
        "minimum_mm": profile.minimum,
        "maximum_mm": profile.maximum,
        "mean_mm": profile.mean,
        "sd_mm": profile.sd,
        "equivalent_mean_mm": _mean(profile.equivalent_diameter),
    }


def _mean(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan
