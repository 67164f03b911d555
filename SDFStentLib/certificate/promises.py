"""The promises of a deployment about its stent, as values: motion of the wall, width
of the lumen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..cautions import Caution
from ..units import place_text
from ..validation import Place

NARROWER = 0.03
"""Share of the prescribed diameter by which a lumen may be narrower and still count as prescribed.

Facets that were stretched across a flow divider or untangled lie inside by up to 2.2 % of it; the
lumen of other stents is mostly within 0.3 %, on coarse meshes within 1.4 %.
"""

NOTICEABLY_NARROWER = 0.015
"""Share of the prescribed diameter by which a lumen may be narrower without being mentioned: coarse
meshes and facets beside the ends miss that much."""

WIDER = 0.05
"""Share by which a lumen may be wider than both the prescribed and the native one."""

ROUNDING = 1e-6
"""Rounding of a distance, mm."""


@dataclass(frozen=True)
class MotionCheck:
    """Motion of the wall at the point that comes nearest to its bound or exceeds it most.

    Attributes
    ----------
    distance, bound : float
        Motion of that point, and its bound by the method, mm.
    point : (x, y, z)
        Place of that point before, mm.
    """

    distance: float
    bound: float
    point: Place

    @property
    def passed(self) -> bool:
        """Whether no point moved farther than the method can move it."""
        return self.distance <= self.bound + ROUNDING

    def fault(self, units: str = "mm") -> str:
        """The fault and its place as a part of a sentence; `units` are those of the file."""
        return (
            f"a point that moved {self.distance:.1f} mm, "
            f"{self.distance - self.bound:.3g} mm farther than the method moves it, "
            f"from {place_text(self.point, units)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """The check as a part of a report."""
        return {
            "passed": self.passed,
            "distance_mm": self.distance,
            "bound_mm": self.bound,
            "point_mm": list(self.point),
        }


@dataclass(frozen=True)
class WallCheck:
    """The wall along a stent at the place where it lies deepest inside of the stent.

    Attributes
    ----------
    prescribed : float
        Radius of the stent there, mm.
    depth : float
        Shortest way from there out of the stent, mm; 0 where no wall lies clearly inside.
    at : (x, y, z)
        Place of the wall, mm.
    """

    prescribed: float
    depth: float
    at: Place

    @property
    def passed(self) -> bool:
        """Whether the wall is not inside by more than `NARROWER`."""
        return self.depth <= NARROWER * self.prescribed

    def fault(self, units: str = "mm") -> str:
        """The fault and its place as a part of a sentence; `units` are those of the file."""
        return (
            f"wall {self.depth:.2f} mm inside of the stent, whose radius is "
            f"{self.prescribed:.2f} mm there, near {place_text(self.at, units)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """The check as a part of a report."""
        return {
            "prescribed_radius_mm": self.prescribed,
            "inside_mm": self.depth,
            "at_mm": list(self.at),
        }


@dataclass(frozen=True)
class LumenCheck:
    """The width of the lumen along a stent.

    Attributes
    ----------
    prescribed : float
        Prescribed diameter at the station where the lumen is narrowest relative to it, mm.
    narrowest, widest : float
        Diameter of the inscribed sphere where that misses the prescribed one most, mm; the
        prescribed one where no station misses it by more than the tolerance. 0 where the stent
        lies outside of the vessel.
    native : float
        Diameter that the lumen may have at the widest station, mm: the native one or the stent's.
    narrowest_at, widest_at : (x, y, z)
        Stations of the axis, mm.
    wall : WallCheck
        Check of the wall itself, as spheres lie where there is room, not where the stent is.
    """

    prescribed: float
    narrowest: float
    narrowest_at: Place
    widest: float
    widest_at: Place
    native: float
    wall: WallCheck

    @property
    def is_narrow(self) -> bool:
        """Whether the lumen is narrower than prescribed by more than `NARROWER`."""
        return self.narrowest < (1 - NARROWER) * self.prescribed

    @property
    def shortfall(self) -> float:
        """Largest share of the prescribed width that the lumen lacks, or that wall inside takes."""
        return max(1 - self.narrowest / self.prescribed, self.wall.depth / self.wall.prescribed)

    def cautions(self) -> tuple[Caution, ...]:
        """A caution if the lumen is narrower than prescribed by more than a little."""
        if not NOTICEABLY_NARROWER < self.shortfall < 1:
            return ()
        found, wanted, place = self._narrowest_place()
        widths = {"found_mm": found, "prescribed_mm": wanted, "percent": 100 * self.shortfall}
        return (Caution("narrower", widths, place),)

    def in_words(self, units: str = "mm") -> str:
        """Narrowing of the lumen against what is prescribed, as a part of a sentence."""
        if self.shortfall <= NOTICEABLY_NARROWER:
            most = f"{100 * NOTICEABLY_NARROWER:g} %"
            return f"its lumen is nowhere more than {most} narrower than prescribed"
        found, wanted, place = self._narrowest_place()
        return (
            f"its lumen is up to {100 * self.shortfall:.1f} % narrower than prescribed, "
            f"{found:.2f} instead of {wanted:.2f} mm near {place_text(place, units)}"
        )

    def _narrowest_place(self) -> tuple[float, float, Place]:
        """The diameter left where most is missing, the prescribed one, and the place, mm."""
        if self.wall.depth / self.wall.prescribed < self.shortfall:
            return self.narrowest, self.prescribed, self.narrowest_at
        wall = self.wall
        return 2 * (wall.prescribed - wall.depth), 2 * wall.prescribed, wall.at

    @property
    def is_wide(self) -> bool:
        """Whether the lumen is wider than prescribed and than before by more than `WIDER`."""
        return self.widest > (1 + WIDER) * self.native

    @property
    def passed(self) -> bool:
        """Whether the lumen is the prescribed one, and wider only where it was."""
        return not (self.is_narrow or self.is_wide) and self.wall.passed

    def missed(self) -> tuple[float, float, Place]:
        """Diameter that misses the prescribed one, the one it should be, and the place, mm."""
        if self.is_wide and not self.is_narrow:
            return self.widest, self.native, self.widest_at
        if self.is_narrow:
            return self.narrowest, self.prescribed, self.narrowest_at
        return self._narrowest_place()

    def fault(self, units: str = "mm") -> str:
        """The fault and its place as a part of a sentence; `units` are those of the file."""
        if not self.narrowest:
            return f"a stent outside of the lumen near {place_text(self.narrowest_at, units)}"
        if not (self.is_narrow or self.is_wide):
            return self.wall.fault(units)
        found, wanted, place = self.missed()
        return (
            f"a lumen of {found:.2f} mm instead of {wanted:.2f} mm near {place_text(place, units)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """The check as a part of a report."""
        return {
            "passed": self.passed,
            "prescribed_mm": self.prescribed,
            "narrowest_mm": self.narrowest,
            "narrowest_at_mm": list(self.narrowest_at),
            "narrower_tolerance": NARROWER,
            "widest_mm": self.widest,
            "widest_at_mm": list(self.widest_at),
            "wider_tolerance": WIDER,
            "wall": self.wall.as_dict(),
        }


def lumen_in_words(checks: Sequence[LumenCheck], units: str) -> str:
    """The width of the lumen of several stents that passed, as a part of a sentence."""
    worst = max(checks, key=lambda check: check.shortfall)
    return f"{worst.in_words(units)}, and wider only where it was"
