"""Apposition of an expanded stent: where it touches the wall and where it hangs free."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Line, Surface, as_line
from ..lumen import RAYS, RAYS_APART, Mask, near_wall, wall_map
from ..validation import Floats, as_number, read_only

GAP = 0.3
"""Distance from stent to wall up to which they touch, mm: a strut is 0.1 to 0.3 mm thick."""

NOTICED = 0.1
"""Share of the circumference from which a piece of the stent belongs to a free stretch."""

MOST = 0.5
"""Share of the circumference above which a piece of the stent hangs free."""


@dataclass(frozen=True)
class FreeStretch:
    """A part of the stent in which some of its circumference touches no wall."""

    start: float
    """Its start from the proximal end of the stent, mm."""
    end: float
    share: float
    """Mean share of the circumference without contact, above 0 and up to 1."""
    largest_gap: float
    """The largest gap from stent to wall, mm; infinite over an open end."""


@dataclass(frozen=True)
class Apposition:
    """Contact of a stent with the wall along its axis."""

    arc_length: Floats
    """(n,) middles of equal pieces of the stent from its proximal end, mm."""
    free_share: Floats
    """(n,) share of the circumference without contact, 0 to 1."""
    stretches: tuple[FreeStretch, ...]
    """Stretches where the share is above `NOTICED`, proximal to distal."""
    length: float
    """The length of the stent, mm."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "arc_length", read_only(self.arc_length))
        object.__setattr__(self, "free_share", read_only(self.free_share))

    @property
    def free_length(self) -> float:
        """Length of all stretches together, mm."""
        return float(sum(stretch.end - stretch.start for stretch in self.stretches))

    @property
    def hanging_length(self) -> float:
        """Length over which most of the circumference touches no wall, mm.

        Across an ostium a part of it never does, though the stent is held there.
        """
        return float((self.free_share > MOST).mean() * self.length)

    @property
    def is_loose(self) -> bool:
        """Whether it touches the wall nowhere."""
        return bool((self.free_share >= 1).all())

    def sentence(self) -> str:
        """Free stretches in a sentence for the user; empty when the stent touches all along."""
        if not self.stretches:
            return ""
        if self.is_loose:
            return f"The stent touches no wall: it hangs free over all of its {self.length:.1f} mm."
        where = ", ".join(
            f"{stretch.start:.1f} to {stretch.end:.1f} mm ({100 * stretch.share:.0f} % of the "
            "circumference free)"
            for stretch in self.stretches
        )
        return (
            f"The stent does not touch the wall all round over {self.free_length:.1f} of its "
            f"{self.length:.1f} mm; from its proximal end: {where}. Across an ostium there is no "
            "wall to touch."
        )


def apposition(
    surface: Surface, axis: Line | ArrayLike, radius: float | Callable[[Floats], Floats]
) -> Apposition:
    """Contact of an expanded stent with the deployed surface.

    Rays go from the stent's axis, across it; the wall is in contact where it is nearer than
    radius and `GAP`.

    Parameters
    ----------
    surface : Surface
        Surface after deployment, mm.
    axis : Line or array_like, shape (n, 3)
        The stent's, proximal to distal, mm.
    radius : float or callable
        Radius of the stent, mm, or that at arc lengths (n,) of the axis from its proximal end.

    Raises
    ------
    InputError
        An axis that is no polyline, or a radius that is none.
    """
    line = as_line(axis, "stent axis").without_repeats()
    total = line.length
    if callable(radius):
        radius_at, widest = radius, float(radius(np.linspace(0, total, 200)).max())
    else:
        widest = as_number(radius, "stent radius", unit="mm", above=0)
        radius_at = partial(np.full_like, fill_value=widest)
    near = near_wall(surface, line.points, max(total, 2 * (widest + GAP)))
    if not len(near.triangles):
        # Short and thin in a wide lumen: all of the wall is farther away than that.
        near = near_wall(surface, line.points, np.inf)
    wall = wall_map(near, line, spacing=RAYS_APART, window=widest)
    edges = wall.arc_length
    # A piece between two stations has the mean of both.
    own = radius_at(edges)[:, None]
    share = (wall.distance > own + GAP).sum(axis=1) / RAYS
    share = (share[1:] + share[:-1]) / 2
    apart = wall.distance - own
    gaps = np.maximum(apart[1:], apart[:-1]).max(axis=1)
    stretches = _stretches(share > NOTICED, edges, share, gaps)
    return Apposition((edges[1:] + edges[:-1]) / 2, share, stretches, float(edges[-1]))


def _stretches(
    is_free: Mask, edges: Floats, share: Floats, gaps: Floats
) -> tuple[FreeStretch, ...]:
    """Runs of free pieces (n,) between edges (n + 1,)."""
    bounded = np.r_[False, is_free, False]
    runs = np.flatnonzero(bounded[1:] != bounded[:-1]).reshape(-1, 2)
    return tuple(
        FreeStretch(
            float(edges[first]),
            float(edges[after]),
            float(share[first:after].mean()),
            float(gaps[first:after].max()),
        )
        for first, after in runs
    )
