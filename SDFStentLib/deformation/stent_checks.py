"""Checks on the result of what a deployment promises: the motion and the lumen of its stent.

A deformation without any fold can still be wrong. Two statements, each with a number and a place:
no point moved farther than the method can move one, and the lumen along the stent is the
prescribed one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..certificate import NARROWER, WIDER, LumenCheck, MotionCheck
from ..field import CapsuleChain, fractions_of
from ..geometry import Surface, may_meet_box
from ..lumen import (
    Until,
    caps_near,
    equivalent_diameters,
    inscribed_spheres,
)
from ..validation import Floats, Place, Points, as_place
from .wall_around import WallAround
from .wall_check import wall_check

COARSEST = np.sqrt(2.0)
"""Largest distance of wall in contact from the axis, in radii: see `lumen.largest_push`."""

ROUGH = 0.01
"""Share of the radius by which the wall's distance from the axis may be too short before the sphere
itself is searched for, and the tolerance of spheres that may be too wide."""

NEAR = 2.0
"""Distance from the axis, in radii, up to which triangles are looked at first."""

CAPS_WITHIN = 2.0
"""Distance from the stent's ends, in its radii, within which flat caps count as open."""


def motion_check(
    before: Points, after: Points, chain: CapsuleChain, radius: float, tissue: float
) -> MotionCheck:
    """Whether no point of the wall moved farther than the method can move one.

    Every point moves along its field line. A point in contact ends where the stent does, `radius`
    from the axis and behind a thickness of tissue, and facet compensation pushes it out by the
    factor `COARSEST` at most: from the distance d it moves up to sqrt(2) (radius + tissue) - d. A
    point out of contact is dragged by no more than the stent grows, which is its radius.

    Parameters
    ----------
    before, after : (k, 3) arrays
        Points that moved, mm.
    chain : CapsuleChain
    radius, tissue : float
        Radius of the stent and thickness of the tissue gap, mm.
    """
    if not len(before):
        return MotionCheck(0.0, radius, as_place(chain.nodes[0]))
    moved = np.linalg.norm(after - before, axis=1)
    # No bound is below the radius, so all others keep theirs.
    where = np.union1d(np.flatnonzero(moved > radius), [moved.argmax()])
    reach = COARSEST * (radius + tissue) - chain.axis_distance(before[where])
    bound = np.maximum(reach, radius)
    worst = int((moved[where] - bound).argmax())
    at = where[worst]
    return MotionCheck(float(moved[at]), float(bound[worst]), as_place(before[at]))


class Expected(NamedTuple):
    """The stent as prescribed."""

    chain: CapsuleChain
    radius: float
    """Largest radius, mm."""
    influence_distance: float
    """Distance from a contact within which wall is dragged along, mm."""


def lumen_check(
    before: Surface,
    after: Surface,
    stent: Expected,
    own: tuple[Surface, Surface] | None = None,
) -> LumenCheck:
    """Whether the lumen along a stent is the prescribed one.

    The wall's distance from the axis is a lower bound of the inscribed sphere, and wall on all
    sides gives an upper one; the sphere itself is searched for only where these do not decide. Flat
    caps of inlets and outlets count as open. A sphere climbs to where there is room, so the wall
    itself is checked, too.

    Parameters
    ----------
    before, after : Surface
        The surface without and with all stents.
    stent : Expected
    own : pair of Surface, optional
        The surface just before and after this stent, where there are other stents, which may be
        wider.
    """
    chain, radius, _ = stent
    reach = NEAR * radius
    around = own_around = WallAround(after.points, after.triangles, chain.nodes, reach)
    narrow = _narrowest(before, after, around, chain, radius)
    if own is not None:
        own_around = WallAround(own[1].points, own[1].triangles, chain.nodes, reach)
    widest, native, widest_at = _widest(*(own or (before, after)), own_around, stent)
    # Flat caps across its ends that were there before are no wall.
    is_cap = caps_near(before, chain.nodes, CAPS_WITHIN * radius)[around.faces]
    is_wall = around.within(radius) & ~is_cap
    wall = wall_check(around.points, around.triangles[is_wall], chain, radius)
    return LumenCheck(
        2 * narrow.wanted, 2 * narrow.width, narrow.at, 2 * widest, widest_at, 2 * native, wall
    )


class _Narrowest(NamedTuple):
    """The station that misses its prescribed radius most, mm."""

    width: float
    wanted: float
    at: Place


def _narrowest(
    before: Surface, after: Surface, around: WallAround, chain: CapsuleChain, radius: float
) -> _Narrowest:
    stations, wanted = chain.nodes, chain.inscribed_radii(radius, chain.nodes, in_caps=True)
    points, triangles = after.points, after.triangles
    width = around.distances(stations)
    if (width < (1 - ROUGH) * wanted).any():
        is_wall = ~caps_near(before, stations, CAPS_WITHIN * radius)
        triangles = triangles.compress(is_wall, axis=0)
        around = WallAround(points, triangles, stations, NEAR * radius)
        width = around.distances(stations)
    doubtful = np.flatnonzero(width < (1 - ROUGH) * wanted)
    if len(doubtful):
        directions = chain.line.directions[doubtful]
        spheres = inscribed_spheres(points, triangles, stations[doubtful], directions)
        width[doubtful] = np.fmax(spheres.radii, width[doubtful])
    at = int((width / wanted).argmin())
    if width[at] < (1 - NARROWER) * wanted[at]:
        return _Narrowest(float(width[at]), float(wanted[at]), as_place(stations[at]))
    middle = len(stations) // 2
    three = [middle, 0, -1]
    if _is_outside(around, after, stations[three], chain.line.directions[three]):
        return _Narrowest(0.0, float(wanted[middle]), as_place(stations[middle]))
    prescribed = float(wanted[at])
    return _Narrowest(min(float(width[at]), prescribed), prescribed, as_place(stations[at]))


def _widest(
    before: Surface, after: Surface, around: WallAround, stent: Expected
) -> tuple[float, float, Place]:
    """Radius of the sphere that exceeds its bound most, mm, the bound, and the station."""
    chain, radius, _ = stent
    # A sphere reaches over its neighbors at this distance, and need not be exact.
    line = chain.line.resampled(radius / 2)
    stations, directions = line.points, line.directions
    points, triangles = after.points, after.triangles
    prescribed = _beside_wider_parts(chain, radius, stations)
    least = float(prescribed[0])
    nothing = least, least, as_place(stations[0])
    if not len(around.faces):
        return nothing
    most = (1 + WIDER) * prescribed
    is_wide = around.room(stations, directions) > most
    if is_wide.any():
        # The result of a rough search depends on the stations beside, so all are searched.
        low, high = stations.min(axis=0) - NEAR * radius, stations.max(axis=0) + NEAR * radius
        near = triangles.compress(may_meet_box(points, triangles, low, high), axis=0)
        found = inscribed_spheres(points, near, stations, directions, Until(ROUGH * radius))
        is_wide &= found.radii > most
    wide = np.flatnonzero(is_wide)
    if not len(wide):
        return nothing
    # Fewer triangles are never nearer, so only doubtful stations need all of them but the caps.
    is_wall = ~caps_near(before, chain.nodes, CAPS_WITHIN * radius)
    triangles = triangles.compress(is_wall, axis=0)
    widths = inscribed_spheres(points, triangles, stations[wide], directions[wide]).radii
    native = inscribed_spheres(
        _united(before.points, chain, radius), triangles, stations[wide], directions[wide]
    ).radii
    native = np.fmax(native + _dragged(stent, stations[wide], native), prescribed[wide])
    worst = int((widths / native).argmax())
    return float(widths[worst]), float(native[worst]), as_place(stations[wide[worst]])


def _beside_wider_parts(chain: CapsuleChain, radius: float, stations: Points) -> Floats:
    """Radii (n,), mm, that the wall round stations may have because of the stent alone.

    Wall cannot fall from a wide part to a narrow one more steeply than its facets allow: 45
    degrees.
    """
    if chain.shares is None:
        return np.full(len(stations), radius)
    own, at = _profile(chain, radius, stations)
    corners, along = radius * chain.shares.shares, chain.length * chain.shares.fractions
    beside = (corners - np.abs(at[:, None] - along)).max(axis=1)
    return np.maximum(own, beside)


def _dragged(stent: Expected, stations: Points, native: Floats) -> Floats:
    """Distance (n,) that wall out of the stent's reach may be dragged along by wider parts, mm.

    It moves less the farther it is from them, by the blending of the method, and no farther out
    than it was away from the stent, by the drag bound.
    """
    chain, radius, influence = stent
    if chain.shares is None:
        return np.zeros(len(stations))
    own, at = _profile(chain, radius, stations)
    wider, along = radius * chain.shares.shares, chain.length * chain.shares.fractions
    blend = np.maximum(1 - np.abs(at[:, None] - along) / influence, 0)
    drag = ((wider - own[:, None]) * blend).max(axis=1)
    return np.clip(native - own, 0, np.maximum(drag, 0))


def _profile(chain: CapsuleChain, radius: float, stations: Points) -> tuple[Floats, Floats]:
    """Radii (n,) of a stent beside some places, mm, and the arc lengths of these along its axis,
    mm."""
    assert chain.shares is not None
    at = fractions_of(stations, chain.line)
    return radius * chain.shares.along(at), at * chain.length


def _united(before: Points, chain: CapsuleChain, radius: float) -> Points:
    """Points of the union of the native lumen and the stent, with nothing dragged along."""
    united = before.copy()
    low, high = chain.nodes.min(axis=0) - radius, chain.nodes.max(axis=0) + radius
    inside = np.flatnonzero(((before > low) & (before < high)).all(axis=1))
    own = radius - chain.shortfall(before[inside], radius)
    short = own - chain.axis_distance(before[inside])
    inside, short = inside[short > 0], short[short > 0]
    united[inside] += short[:, None] * chain.field(before[inside]).direction
    return united


def _is_outside(around: WallAround, after: Surface, stations: Points, directions: Points) -> bool:
    """Whether no station lies inside of a closed section of the lumen, or of the lumen at all.

    The wall nearby is asked first.
    """
    near = equivalent_diameters(around.points, around.triangles, stations, directions)
    return not (np.isfinite(near).any() or after.contains(stations).any())
