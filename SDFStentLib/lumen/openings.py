"""The openings in the wall of a vessel, and the vessels to which they lead."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import Surface, connected, norm
from ..validation import Floats, Indices, Points
from .caps import caps_of
from .expected_wall import Tube
from .tolerances import WITHIN
from .wall_map import RAYS

Mask = NDArray[np.bool_]

BEYOND = 1.3
"""Surface farther from the middle than so many expected radii is that of another vessel,"""

FAR = 2.0
"""if it leads farther away than so many, or to an end of the model."""

NO_ENDS: Points = np.empty((0, 3))

_STRAY = 0.05
"""Share of all rays to another vessel, and of all through an opening, up to which the fewer than
half that meet that vessel through this opening do so by chance: a funnel far above looks down into
it, and the end of a tube aside."""


class Opening(NamedTuple):
    """Part of a tube's wall at which the lumen goes on into another vessel."""

    region: Mask
    """(n, RAYS) its cells in the map of the wall."""
    outlets: Points
    """(k, 3) centers of the flat caps that it leads to,"""
    caps: tuple[Indices, ...]
    """and the triangles of each."""
    beyond: Indices
    """(t,) the triangles of the surface to which it leads."""


def openings(surface: Surface, tube: Tube, ends: Points = NO_ENDS) -> list[Opening]:
    """The openings of a tube's wall into other vessels, in no order; see `find_ostia`.

    Where all ends (k, 3) of the centerline lie in flat caps, so do those of every vessel.
    """
    if not tube.is_open.any():
        return []
    parts = _parts_beyond(surface, tube)
    caps = _caps_beyond(surface, tube, parts.of_triangle)
    leads = parts.is_far & (not _are_flat(surface, ends))
    leads[[cap.part for cap in caps]] = True
    places = tube.places
    regions = _regions(tube, np.where(leads[parts.of_triangle], parts.of_triangle, -1))
    found = []
    for part, region in regions.items():
        if parts.is_onward[part] and not _leads_aside(tube, region, places[region]):
            continue
        own = [cap for cap in caps if cap.part == part]
        centers = np.reshape([cap.center for cap in own], (-1, 3))
        beyond = np.flatnonzero(parts.of_triangle == part)
        found.append(Opening(region, centers, tuple(cap.faces for cap in own), beyond))
    return found


def _are_flat(surface: Surface, ends: Points) -> bool:
    """Whether ends (k, 3) of vessels exist and all lie in flat caps."""
    caps = caps_of(surface)
    if not len(ends) or not caps:
        return False
    corners = [surface.points[surface.triangles[cap.faces]].reshape(-1, 3) for cap in caps]
    radii = [norm(own - cap.middle).max() for own, cap in zip(corners, caps, strict=True)]
    away = np.linalg.norm(ends[:, None] - [cap.middle for cap in caps], axis=2)
    return bool((away < radii).any(axis=1).all())


def _leads_aside(tube: Tube, region: Mask, places: Points) -> bool:
    """Whether an opening leads far from a vessel that hangs together with what it leads to.

    Else it is the vessel itself beyond its end, or a branch of which only a part is in reach. The
    opening's places (k, 3) are those on the expected wall; nearer it is within the lumen, seen from
    a part of the vessel that is bent round.
    """
    is_far = tube.wall.distance > FAR * tube.expected
    is_in_wall = np.median(_seen_from(places, tube)[0]) > WITHIN
    return bool(is_in_wall and is_far[region].any() and not region[[0, -1]].any())


class _Parts(NamedTuple):
    """The connected parts of the surface beyond the wall of a tube."""

    of_triangle: Indices
    """(m,) number of the part that a triangle of the surface touches, 0 for none."""
    is_far: Mask
    """Whether, by number, the part leads far away,"""
    is_onward: Mask
    """and whether it is the vessel itself, beyond an end of the tube."""


def _parts_beyond(surface: Surface, tube: Tube) -> _Parts:
    """The parts of the surface that remain without the wall of the tube between its ends."""
    place = _seen_from(surface.points[tube.near.point_ids], tube)
    relative, is_past = np.full(len(surface.points), np.inf), np.zeros(len(surface.points), bool)
    relative[tube.near.point_ids], is_past[tube.near.point_ids] = place
    is_beyond = (relative > BEYOND) | is_past
    corners = surface.corners
    sides = np.hstack([corners[[0, 1]], corners[[1, 2]]])
    first, second = sides[:, is_beyond[sides[0]] & is_beyond[sides[1]]]
    count, label = connected(len(surface.points), first, second)
    label = np.where(is_beyond, label + 1, 0).astype(np.int64)
    is_far, is_onward = np.zeros(count + 1, dtype=bool), np.zeros(count + 1, dtype=bool)
    is_far[label[relative > FAR]] = True
    is_onward[label[is_past & (relative < BEYOND)]] = True
    is_far[0] = is_onward[0] = False
    of_triangle = np.maximum(np.maximum(label[corners[0]], label[corners[1]]), label[corners[2]])
    return _Parts(of_triangle, is_far, is_onward)


def _seen_from(points: Points, tube: Tube) -> tuple[Floats, Mask]:
    """Distance of points (k, 3) from the middle of the vessel, in expected radii there.

    And whether they lie past an end of the axis, within one radius along it.
    """
    from scipy.spatial import KDTree

    wall = tube.wall
    station = KDTree(wall.centers).query(points)[1]
    local = np.einsum("ij,ikj->ik", points - wall.centers[station], wall.frames[station])
    angle = np.arctan2(local[:, 2], local[:, 1])
    ray = np.rint(angle / (2 * np.pi / RAYS)).astype(np.int64) % RAYS
    expected = tube.expected[station, ray]
    across = np.hypot(local[:, 1], local[:, 2])
    distance = np.hypot(across, local[:, 0])
    outward = np.where(station == 0, -local[:, 0], local[:, 0])
    is_end = (station == 0) | (station == len(wall.centers) - 1)
    is_past = is_end & (outward > 0) & (outward < expected)
    return np.where(is_past, across, distance) / expected, np.asarray(is_past)


class _Cap(NamedTuple):
    """A flat end of the model to which a branch leads."""

    part: int
    faces: Indices
    center: Floats


def _caps_beyond(surface: Surface, tube: Tube, part_of_triangle: Indices) -> list[_Cap]:
    """The flat ends beyond the tube's wall. A cap in the way of the tube closes the tube itself;
    its edge may lie beyond."""
    beyond = (cap.faces[part_of_triangle[cap.faces] > 0] for cap in caps_of(surface))
    caps = [faces for faces in beyond if len(faces)]
    middles = [surface.points[surface.triangles[faces]].mean(axis=(0, 1)) for faces in caps]
    relative, _ = _seen_from(np.reshape(middles, (-1, 3)), tube)
    return [
        _Cap(int(np.bincount(part_of_triangle[faces]).argmax()), faces, center)
        for faces, center, away in zip(caps, middles, relative, strict=True)
        if away > BEYOND
    ]


def _regions(tube: Tube, part_of_triangle: Indices) -> dict[int, Mask]:
    """The openings (n, RAYS) by the part of the surface to which they lead; -1: to none."""
    is_open = tube.is_open
    hit = np.where(tube.wall.triangle >= 0, part_of_triangle[tube.wall.triangle], -1)
    label = labels_round(is_open)
    regions: dict[int, Mask] = {}
    known = is_open & (hit >= 0)
    rays = np.bincount(hit[known], minlength=1)
    for number in np.unique(label[known]):
        region = label == number
        own_rays = np.bincount(hit[region & known], minlength=len(rays))
        is_main = own_rays > rays / 2
        no_stray = own_rays > _STRAY * np.maximum(rays, own_rays.sum())
        parts = np.flatnonzero(is_main | no_stray)
        if not len(parts):
            continue
        for part, own in zip(parts, _shared(region, hit, parts), strict=True):
            regions[int(part)] = regions.get(int(part), np.zeros_like(region)) | own
    return regions


def _shared(region: Mask, hit: Indices, parts: Indices) -> list[Mask]:
    """A region that leads to several parts of the surface, each cell to the nearest one."""
    if len(parts) == 1:
        return [region]
    from scipy.spatial import cKDTree

    cells, away = np.argwhere(region), []
    for part in parts:
        row, ray = np.nonzero(region & (hit == part))
        # Three turns are put side by side, since the map is periodic.
        turns = np.column_stack([np.tile(row, 3), np.r_[ray - RAYS, ray, ray + RAYS]])
        away.append(cKDTree(turns).query(cells)[0])
    nearest = np.full(region.shape, -1)
    nearest[region] = np.argmin(away, axis=0)
    return [nearest == number for number in range(len(parts))]


def labels_round(mask: Mask) -> Indices:
    """Numbers of the connected regions of a map (n, RAYS), periodic in its rays; 0 outside.

    Cells that meet at a corner are connected.
    """
    cell = np.arange(mask.size).reshape(mask.shape)
    pairs = [np.empty((2, 0), dtype=np.int64)]
    for down, aside in ((0, 1), (1, -1), (1, 0), (1, 1)):
        one, other = cell[: len(cell) - down], np.roll(cell, aside, axis=1)[down:]
        joined = mask.ravel()[one] & mask.ravel()[other]
        pairs.append(np.stack([one[joined], other[joined]]))
    label = connected(mask.size, *np.hstack(pairs))[1].reshape(mask.shape)
    return np.where(mask, label + 1, 0)
