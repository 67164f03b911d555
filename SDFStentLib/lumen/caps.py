"""Flat caps of in- and outlets, and whether a stent has bulged them.

A cap is where a simulation prescribes flow or pressure on a plane. A stent that ends in or near it
pushes it out of its plane; the user has to know.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..geometry import (
    Surface,
    boundary_edges,
    connected,
    dot,
    face_areas,
    face_normals,
    may_meet_box,
    paired_sides,
    product,
    used_points,
)
from ..validation import Flags, Floats, Place, Points, Triangles, as_place
from .ends import Spot, are_ends, spot
from .tolerances import ACROSS

FLAT = np.cos(np.deg2rad(5.0))
"""Cosine of the angle between normals below which faces lie in one plane.

Decimation tilts the faces of a cap: of the 93 ends of a patient's surface with a fifth of its
triangles left 45 were found with 1 degree, 91 with 5 to 20. The mean of a flat spot's unit normals
is at least so long, too: on a fine mesh the whole of a round wall hangs together by faces that
differ by less; its normals cancel.
"""

RIM = np.cos(np.deg2rad(45.0))
"""Cosine of the angle between the normals of a cap and of wall, at least; a flat spot of the wall
meets the rest at less."""

FEWEST_FACES = 2
"""Number of faces from which a spot counts as flat: one always is."""

NOTICEABLE = 0.05
"""Motion out of the plane, mm, from which on a cap is reported."""


_known: WeakKeyDictionary[Surface, list[FlatCap]] = WeakKeyDictionary()
"""Caps of each surface, kept: every stent that is tried asks for those of its vessel."""


class BulgedCap(NamedTuple):
    """A flat cap that a deployment has pushed out of its plane."""

    center: Place
    """Center of the cap, mm."""
    height: float
    """Largest motion out of the plane, mm."""

    def caution(self) -> Caution:
        """The caution for the user."""
        return Caution("cap-bulged", {"height_mm": self.height}, self.center)


class FlatCap(NamedTuple):
    """A flat spot with a steep rim."""

    faces: NDArray[np.int64]
    """Indices of its faces, ascending."""
    normal: NDArray[np.float64]
    """(3,) unit vector."""
    middle: NDArray[np.float64]
    """(3,) mean of the corners of its triangles, mm."""
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    """(3,) corners of the box round it, mm."""


def flat_caps(points: Points, faces: Triangles) -> list[FlatCap]:
    """Flat spots with a steep rim among some faces (m, 3), in the order of their first faces.

    Faces alone do not show which of these are ends of the vessel; `caps_of` finds that out.
    """
    return _flat_spots(points, faces, face_normals(points, faces))


def _flat_spots(points: Points, faces: Triangles, normals: Floats) -> list[FlatCap]:
    if len(faces) < FEWEST_FACES:
        return []
    pairs = paired_sides(faces) // 3
    cosine = dot(normals.take(pairs[:, 0], axis=0), normals.take(pairs[:, 1], axis=0))
    flat = pairs.compress(cosine > FLAT, axis=0)
    count, label = connected(len(faces), flat[:, 0], flat[:, 1])

    sides = label.take(pairs)
    border = np.flatnonzero(sides[:, 0] != sides[:, 1])
    sides, angles = sides.take(border, axis=0), np.repeat(cosine.take(border)[:, None], 2, axis=1)
    size = np.bincount(label, minlength=count)
    rim = np.bincount(sides.ravel(), minlength=count)
    steep = np.bincount(sides.ravel(), weights=(angles < RIM).ravel(), minlength=count)
    # Every triangle of a mesh that was subdivided is a flat spot: most are left out before the
    # faces of each are gathered.
    is_spot = (size >= FEWEST_FACES) & (steep > 0.8 * rim)
    chosen = np.flatnonzero(is_spot.take(label))
    chosen = chosen[np.argsort(label[chosen], kind="stable")]
    spots = label[chosen]
    parts = np.split(chosen, np.flatnonzero(np.diff(spots)) + 1) if len(chosen) else []
    means = [normals[own].mean(axis=0) for own in parts]
    caps = [
        FlatCap(own, mean / length, *_extent(points[faces[own]]))
        for own, mean in zip(parts, means, strict=True)
        if (length := np.linalg.norm(mean)) >= FLAT
    ]
    return sorted(caps, key=lambda cap: int(cap.faces[0]))


def _extent(corners: Points) -> tuple[Floats, Floats, Floats]:
    """Middle of triangles (k, 3, 3), and lowest and highest corner of the box round them."""
    return corners.mean(axis=(0, 1)), corners.min(axis=(0, 1)), corners.max(axis=(0, 1))


def caps_of(surface: Surface) -> list[FlatCap]:
    """The flat caps that are ends of a whole surface, in the order of their first faces.

    Looked for once for as long as it is in use; `are_ends` separates them from spots of the wall.
    """
    if (found := _known.get(surface)) is None:
        points, triangles = surface.points, surface.wound_triangles
        is_own = triangles is surface.triangles
        normals = surface.face_normals if is_own else face_normals(points, triangles)
        spots = _flat_spots(points, triangles, normals)
        is_end = are_ends(surface, [_as_spot(points, triangles, cap) for cap in spots])
        found = [cap for cap, is_known in zip(spots, is_end, strict=True) if is_known]
        _known[surface] = found
    return found


def _as_spot(points: Points, triangles: Triangles, cap: FlatCap) -> Spot:
    own = triangles[cap.faces]
    areas = face_areas(points, own)
    center = (areas[:, None] * points[own].mean(axis=1)).sum(axis=0) / areas.sum()
    return spot(points, boundary_edges(own), cap.normal, cap.faces, center)


def caps_near(surface: Surface, axis: Points, reach: float) -> NDArray[np.bool_]:
    """Mask (m,) of the faces in flat caps of which a part is near the ends of an axis.

    Parameters
    ----------
    surface : Surface
    axis : (k, 3) array
        mm.
    reach : float
        Distance from the ends, mm, within which caps are looked for; the whole of one counts.
    """
    points, triangles = surface.points, surface.triangles
    is_capped = np.zeros(len(triangles), dtype=bool)
    for end in axis[[0, -1]]:
        for cap in caps_of(surface):
            # A tree has hundreds of caps.
            if (cap.low <= end + reach).all() and (cap.high >= end - reach).all():
                corners = points[triangles[cap.faces]].reshape(-1, 3)
                faces = np.arange(len(corners)).reshape(-1, 3)
                if may_meet_box(corners, faces, end - reach, end + reach).any():
                    is_capped[cap.faces] = True
    return is_capped


def in_caps(surface: Surface) -> Flags:
    """Mask (m,) of the triangles that belong to a flat cap."""
    is_capped = np.zeros(len(surface.triangles), dtype=bool)
    for cap in caps_of(surface):
        is_capped[cap.faces] = True
    return is_capped


def wall_of(surface: Surface) -> Triangles:
    """The triangles (k, 3) that do not belong to a flat cap."""
    return surface.triangles.compress(~in_caps(surface), axis=0)


def off_caps(surface: Surface) -> Points:
    """The points (n, 3), mm, of the triangles that do not belong to a flat cap; all points if there
    is no such triangle."""
    used = used_points(wall_of(surface))
    return surface.points[used] if len(used) else surface.points


def looks_across(points: Points, normals: Points, axis: Points, reach: float) -> NDArray[np.bool_]:
    """Mask (n,) of wall points with normals as of caps across an axis, within reach of its ends.

    Unlike `caps_near` it knows no faces: the bottom of a round dead end looks like a cap, too.
    """
    looks = np.zeros(len(points), dtype=bool)
    for end, inner in (axis[:2], axis[:-3:-1]):
        direction = (end - inner) / np.linalg.norm(end - inner)
        offset = points - end
        near = dot(offset, offset) < reach**2
        looks |= near & (np.abs(product(normals, direction)) > ACROSS)
    return looks


def bulged_caps(before: Surface, after: Surface, moved: NDArray[np.int64]) -> tuple[BulgedCap, ...]:
    """Caps that were flat before and are not any more.

    Parameters
    ----------
    before, after : Surface
        Surfaces with the same triangles.
    moved : (k,) array
        Points that moved; only caps at them are looked at.
    """
    has_moved = np.zeros(len(before.points), dtype=bool)
    has_moved[moved] = True
    pushed = (_bulged(before, after, cap, has_moved) for cap in caps_of(before))
    return tuple(bulge for bulge in pushed if bulge is not None)


def _bulged(before: Surface, after: Surface, cap: FlatCap, has_moved: Flags) -> BulgedCap | None:
    """The present state of a cap after some points (n,) have moved; None if it is as flat as
    before."""
    corners = np.unique(before.triangles[cap.faces])
    if not has_moved[corners].any():
        return None
    start, end = before.points[corners], after.points[corners]
    height = float(np.abs((end - start) @ cap.normal).max())
    if height <= NOTICEABLE:
        return None
    return BulgedCap(as_place(start.mean(axis=0)), height)
