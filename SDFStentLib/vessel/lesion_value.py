"""A lesion of a vessel and the healthy places beside it, as values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..geometry import Line, Surface
from ..validation import Floats, Place, read_only
from .lesion_sections import LesionLine, Section, smallest_section


@dataclass(frozen=True)
class HealthyPlace:
    """Healthy vessel that a lesion is measured against."""

    point: Place
    """Place on the centerline, mm."""
    arc_length: float
    """Arc length from the root, mm."""
    diameter: float
    """Inscribed, the usual one about the point, mm."""
    cut: Callable[[], float] = field(repr=False)
    """Function that measures its area."""

    @cached_property
    def area(self) -> float:
        """The area of the cross-section, mm^2; NaN where no closed one lies round the place."""
        return self.cut()


@dataclass(frozen=True, eq=False)
class Lesion:
    """A narrowing of a vessel against the healthy vessel beside it.

    Percent by diameter compares inscribed diameters, percent by area cross-sections. Proximal is
    the side of the centerline's root. Arc lengths count from the root; all lengths are in mm.
    """

    branch: int
    """Index into `Centerline.branches` of the branch in which it is narrowest."""
    branch_name: str
    """Name of that branch, or of the one to which a limb leads, as of `branch_names`."""
    branch_arc_length: float
    """The arc length of the narrowest place, from the start of that branch."""
    arc_length: float
    """The arc length of the narrowest place."""
    start: float
    end: float
    """Arc lengths between which it is more than a tenth narrower than the reference."""
    point: Place
    """Center of the inscribed sphere at the narrowest place, mm."""
    minimum_diameter: float
    """Inscribed diameter there."""
    reference_diameter: float
    """The reference diameter at the narrowest place."""
    percent_diameter: float
    proximal: HealthyPlace | None
    distal: HealthyPlace | None
    """Healthy places it is measured against; None for a side without one, such as a junction."""
    reference: str
    """Reference in words, to follow "against"."""
    line: Line
    """The centerline from `start` to `end`, through k points."""
    healthy: Floats
    """(k,) diameters of the healthy vessel at these points, mm."""
    diameters: Floats
    """(k,) inscribed, at these points, mm; NaN where unknown."""
    surface: Surface = field(repr=False)
    """The surface on which it is measured."""
    vessel: int = 0
    """Index of its vessel among those of the tree, from the root on."""
    generation: int = 0
    """Number of vessels between that and the root."""
    limbs: tuple[Lesion, ...] = ()
    """Narrowings of other vessels in the same throat, as at a bifurcation."""

    def __post_init__(self) -> None:
        for name in ("healthy", "diameters"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @cached_property
    def section(self) -> Section:
        """The smallest cross-section; cut when first asked for.

        It may lie elsewhere than the smallest diameter. NaN where no closed section lies round the
        centerline.
        """
        sides = [side for side in (self.proximal, self.distal) if side is not None]
        ratios = [side.area / side.diameter**2 for side in sides if np.isfinite(side.area)]
        ratio = float(np.mean(ratios)) if ratios else float("nan")
        line = LesionLine(self.line, self.healthy, self.diameters, ratio)
        return smallest_section(self.surface, line, self.minimum_diameter)

    @property
    def minimum_area(self) -> float:
        """Area of the smallest cross-section, mm^2."""
        return self.section.area

    @property
    def reference_area(self) -> float:
        """Area of the healthy vessel at that section, mm^2."""
        return self.section.reference

    @property
    def percent_area(self) -> float:
        """Percent stenosis by area."""
        return self.section.percent

    @property
    def length(self) -> float:
        """The length from start to end, mm."""
        return self.end - self.start


def with_sections(lesions: tuple[Lesion, ...]) -> tuple[Lesion, ...]:
    """Lesions with their sections cut before somebody waits for them."""
    for lesion in lesions:
        _cut = lesion.section
    return lesions


def reference_words(
    sides: Sequence[HealthyPlace | None],
    widest: float = float("nan"),
    beyond: float = float("nan"),
    by: str = "healthy vessel",
    other: str = "; on its other side is a junction or an end",
) -> str:
    """The reference in words: healthy vessel, or how wide (mm) it should be without any.

    `beyond`, mm, is how wide the proximal vessel goes on beyond a junction; NaN where none is.
    """
    told = [
        f"{name} to it ({side.diameter:.1f} mm)"
        for name, side in zip(("proximal", "distal"), sides, strict=True)
        if side is not None
    ]
    if len(told) == 2:
        left = f"{beyond:.1f} mm"
        if np.isfinite(beyond) and left not in told[0]:
            told[0] = f"{told[0][:-1]}, {left} beyond its junction)"
        return f"{by} {told[0]} and {told[1]}, tapering from one to the other"
    if not told:
        return f"how wide this vessel should be ({widest:.1f} mm): no part of it is surely healthy"
    return f"{by} {told[0]}{other}"
