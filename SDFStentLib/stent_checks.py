"""What a deployment promises of its stent, judged on the result: motion and lumen.

A deformation without any fold can still be wrong. Two statements, each with a number and a place:
no point moved farther than the method can move one, and the lumen along the stent is the
prescribed one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .caps import caps_across
from .capsule_chain import CapsuleChain
from .cross_section import equivalent_diameters, winding_numbers
from .inscribed import inscribed_spheres
from .local_surface import LocalSurface
from .polyline import resampled, tangents
from .surface import may_meet_box
from .validation import Floats, Points, Triangles

Place = tuple[float, float, float]

NARROWER = 0.03
"""Share of the prescribed diameter by which a lumen may be narrower and still be the prescribed.

Facets that were stretched across a flow divider or untangled lie inside by up to 2.2 % of it; the
lumen of other stents is mostly within 0.3 %, on coarse meshes within 1.4 %.
"""

WIDER = 0.05
"""Share by which a lumen may be wider than the prescribed one and than it was."""

COARSEST = np.sqrt(2.0)
"""Farthest that wall in contact can be from the axis, in radii: see `lumen.largest_push`."""

ROUGH = 0.01
"""Share of the radius up to which the wall's distance from the axis stands for a sphere that may be
too narrow, and the tolerance of spheres that may be too wide."""

NEAR = 2.0
"""Distance from the axis, in radii, of the triangles among which wide spheres are looked for."""

CAPS_WITHIN = 2.0
"""Distance from the stent's ends, in its radii, within which flat caps count as open."""

ROUNDING = 1e-6
"""mm."""

INSIDE = 0.3
"""Winding numbers are 1 inside, 0 outside and 1/2 in the middle of an open end."""


@dataclass(frozen=True)
class MotionCheck:
    """How far a stent moved the wall, at the point that comes nearest to what it can do.

    Attributes
    ----------
    distance, bound : float
        How far that point moved and how far the method can move it, mm.
    point : (x, y, z)
        Where it was, mm.
    """

    distance: float
    bound: float
    point: Place

    @property
    def passed(self) -> bool:
        """No point moved farther than the method can move it."""
        return self.distance <= self.bound + ROUNDING

    def fault(self) -> str:
        """What is wrong and where, as a part of a sentence."""
        return (
            f"a point that moved {self.distance:.1f} mm, where the method moves at most "
            f"{self.bound:.1f} mm, from {_in_words(self.point)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """As it stands in a report."""
        return {
            "passed": self.passed,
            "distance_mm": self.distance,
            "bound_mm": self.bound,
            "point_mm": list(self.point),
        }


@dataclass(frozen=True)
class LumenCheck:
    """How wide the lumen is along a stent.

    Attributes
    ----------
    prescribed : float
        Diameter, mm.
    narrowest, widest : float
        Diameter of the inscribed sphere where that misses the prescribed one most, mm; the
        prescribed one where no station misses it by more than the tolerance. 0 where the stent
        lies outside of the vessel.
    native : float
        What was as wide before at the widest station, mm: lumen or stent.
    narrowest_at, widest_at : (x, y, z)
        Stations of the axis, mm.
    """

    prescribed: float
    narrowest: float
    narrowest_at: Place
    widest: float
    widest_at: Place
    native: float

    @property
    def is_narrow(self) -> bool:
        """Narrower than prescribed by more than `NARROWER`."""
        return self.narrowest < (1 - NARROWER) * self.prescribed

    @property
    def is_wide(self) -> bool:
        """Wider than prescribed and than before by more than `WIDER`."""
        return self.widest > (1 + WIDER) * max(self.native, self.prescribed)

    @property
    def passed(self) -> bool:
        """The prescribed lumen, wider only where it was."""
        return not (self.is_narrow or self.is_wide)

    def fault(self) -> str:
        """What is wrong and where, as a part of a sentence."""
        if not self.narrowest:
            return f"a stent outside of the lumen near {_in_words(self.narrowest_at)}"
        if self.is_narrow:
            found, place = self.narrowest, self.narrowest_at
        else:
            found, place = self.widest, self.widest_at
        return (
            f"a lumen of {found:.2f} mm instead of {self.prescribed:.2f} mm near {_in_words(place)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """As it stands in a report."""
        return {
            "passed": self.passed,
            "prescribed_mm": self.prescribed,
            "narrowest_mm": self.narrowest,
            "narrowest_at_mm": list(self.narrowest_at),
            "narrower_tolerance": NARROWER,
            "widest_mm": self.widest,
            "widest_at_mm": list(self.widest_at),
            "wider_tolerance": WIDER,
        }


def motion_check(
    before: Points, after: Points, chain: CapsuleChain, radius: float, tissue: float
) -> MotionCheck:
    """Whether no point of the wall moved farther than the method can move one.

    Every point goes along its field line. In contact it ends where the stent does, `radius` from
    the axis and behind a thickness of tissue, and facet compensation pushes it out by `COARSEST` at
    most: from the distance d it moves up to sqrt(2) (radius + tissue) - d. Out of contact it is
    dragged along by no more than the stent grows, which is its radius.

    Parameters
    ----------
    before, after : (k, 3) arrays
        Points that moved, mm.
    chain : CapsuleChain
    radius, tissue : float
        Of the stent, and of the tissue gap, mm.
    """
    if not len(before):
        return MotionCheck(0.0, radius, _place(chain.nodes[0]))
    moved = np.linalg.norm(after - before, axis=1)
    # All others are below their bound by nature.
    where = np.union1d(np.flatnonzero(moved > radius), [moved.argmax()])
    reach = COARSEST * (radius + tissue) - chain.axis_distance(before[where])
    bound = np.maximum(reach, radius)
    worst = int((moved[where] - bound).argmax())
    at = where[worst]
    return MotionCheck(float(moved[at]), float(bound[worst]), _place(before[at]))


def lumen_check(
    before: Points,
    after: Points,
    triangles: Triangles,
    chain: CapsuleChain,
    radius: float,
    own: tuple[Points, Points] | None = None,
) -> LumenCheck:
    """Whether the lumen along a stent is the prescribed one.

    The wall's distance from the axis is a lower bound of the inscribed sphere; only where that is
    too little, the sphere itself is looked for. Flat caps of in- and outlets count as open.

    Parameters
    ----------
    before, after : (n, 3) arrays
        The surface without and with all stents, mm.
    triangles : (m, 3) array
    chain : CapsuleChain
    radius : float
        Of the stent, mm.
    own : pair of (n, 3) arrays, optional
        The surface just before and after this stent, where there are others: these may be wider.
    """
    narrowest, narrowest_at = _narrowest(before, after, triangles, chain, radius)
    widest, native, widest_at = _widest(*(own or (before, after)), triangles, chain, radius)
    return LumenCheck(2 * radius, 2 * narrowest, narrowest_at, 2 * widest, widest_at, 2 * native)


def _narrowest(
    before: Points, after: Points, triangles: Triangles, chain: CapsuleChain, radius: float
) -> tuple[float, Place]:
    stations, wanted = chain.nodes, (1 - NARROWER) * radius
    width = LocalSurface(after, triangles, stations).distances(stations)
    if width.min() < (1 - ROUGH) * radius:
        triangles = triangles[~caps_across(before, triangles, stations, CAPS_WITHIN * radius)]
        width = LocalSurface(after, triangles, stations).distances(stations)
    doubtful = np.flatnonzero(width < (1 - ROUGH) * radius)
    if len(doubtful):
        directions = tangents(stations)[doubtful]
        spheres = inscribed_spheres(after, triangles, stations[doubtful], directions)
        width[doubtful] = np.fmax(spheres.radii, width[doubtful])
    at = int(width.argmin())
    if width[at] < wanted:
        return float(width[at]), _place(stations[at])
    middle = len(stations) // 2
    if _is_outside(
        after, triangles, stations[[middle, 0, -1]], tangents(stations)[[middle, 0, -1]]
    ):
        return 0.0, _place(stations[middle])
    return float(min(width[at], radius)), _place(stations[at])


def _widest(
    before: Points, after: Points, triangles: Triangles, chain: CapsuleChain, radius: float
) -> tuple[float, float, Place]:
    """Largest sphere over what was as wide before, the latter, and the station; radii."""
    # A sphere reaches over its neighbors at this distance, and need not be exact.
    stations = resampled(chain.nodes, radius / 2)
    directions = tangents(stations)
    tolerance = ROUGH * radius
    low, high = stations.min(axis=0) - NEAR * radius, stations.max(axis=0) + NEAR * radius
    near = triangles[may_meet_box(after, triangles, low, high)]
    if not len(near):
        return radius, radius, _place(stations[0])
    found = inscribed_spheres(after, near, stations, directions, tolerance=tolerance).radii
    wide = np.flatnonzero(found > (1 + WIDER) * radius)
    if not len(wide):
        return radius, radius, _place(stations[0])
    # Fewer triangles are never nearer; where there is doubt all of them are looked at.
    found[wide] = inscribed_spheres(after, triangles, stations[wide], directions[wide]).radii
    native = inscribed_spheres(
        _united(before, chain, radius), triangles, stations[wide], directions[wide]
    ).radii
    native = np.fmax(native, radius)
    worst = int((found[wide] / native).argmax())
    return float(found[wide[worst]]), float(native[worst]), _place(stations[wide[worst]])


def _united(before: Points, chain: CapsuleChain, radius: float) -> Points:
    """The surface of the native lumen and the stent together, nothing dragged along."""
    united = before.copy()
    low, high = chain.nodes.min(axis=0) - radius, chain.nodes.max(axis=0) + radius
    inside = np.flatnonzero(((before > low) & (before < high)).all(axis=1))
    short = radius - chain.axis_distance(before[inside])
    inside, short = inside[short > 0], short[short > 0]
    united[inside] += short[:, None] * chain.field(before[inside]).direction
    return united


def _is_outside(points: Points, triangles: Triangles, stations: Points, directions: Points) -> bool:
    """Whether no station lies in a closed section of the lumen, nor otherwise inside."""
    for station, direction in zip(stations, directions, strict=True):
        section = equivalent_diameters(points, triangles, station[None], direction[None])
        is_inside = np.isfinite(section[0])
        if is_inside or winding_numbers(station[None], points, triangles)[0] >= INSIDE:
            return False
    return True


def _place(point: Floats) -> Place:
    x, y, z = np.asarray(point, dtype=np.float64).tolist()
    return x, y, z


def _in_words(place: Place) -> str:
    x, y, z = place
    return f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
