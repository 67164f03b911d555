"""Ostia: where a vessel opens into its branches, and how much of each a stent covers.

An ostium is the part of the vessel's expected wall at which there is none, because the lumen goes
on into another vessel. It is found on the surface alone: rays across the axis tell where the wall
leaves the expected one, and the surface there tells whether that leads into another vessel.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry import Surface, connected
from ..validation import Floats, Indices, Points, read_only
from .caps import flat_caps
from .expected_wall import Tube, expected_tube
from .extended_axis import ExtendedAxis
from .wall_map import RAYS, ray_angles

Mask = NDArray[np.bool_]

BEYOND = 1.3
"""Surface farther from the middle than so many expected radii is that of another vessel,"""

FAR = 2.0
"""if it leads farther away than so many, or to an end of the model."""

NEARLY = 0.01
"""Share of an ostium that does not count: it is free below, and covered above 1 less this."""


@dataclass(frozen=True)
class Ostium:
    """The opening of a side branch in the wall of the stented vessel. All mm.

    Positions along the stent count from its proximal end; negative: proximal of the stent.
    """

    name: str
    """From the ids of the faces that it leads to, else a number from proximal to distal."""
    center: Floats
    """(3,) the middle of the opening."""
    start: float
    """Where along the stent the opening begins,"""
    end: float
    """and where it ends."""
    area: float
    """Of the opening, on the expected wall, mm^2."""
    covered_share: float
    """Share of that area between the ends of the stent, 0 to 1."""
    face_ids: tuple[int, ...] = ()
    """Of the ends of the model that the branch leads to."""
    outlets: Points = ()  # type: ignore[assignment]
    """(k, 3) centers of the flat caps that the branch leads to."""
    outline: Points = ()  # type: ignore[assignment]
    """(j, 3) points of the expected wall along the border of the opening, in no order."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", read_only(self.center))
        for name in ("outlets", "outline"):
            object.__setattr__(self, name, read_only(np.reshape(getattr(self, name), (-1, 3))))

    @property
    def is_free(self) -> bool:
        """Whether no part that counts lies under the stent."""
        return self.covered_share < NEARLY

    @property
    def is_fully_covered(self) -> bool:
        """Whether no part that counts lies beside the stent."""
        return self.covered_share > 1 - NEARLY

    @property
    def is_covered(self) -> bool:
        """Whether the stent covers it, fully or partly."""
        return not self.is_free

    def sentence(self) -> str:
        """What the stent does to it, for the user."""
        place = f"from {self.start:.1f} to {self.end:.1f} mm of the proximal end of the stent."
        if self.is_free:
            return f"It leaves {self.name} free: the ostium lies {place}"
        share = "all" if self.is_fully_covered else f"{100 * self.covered_share:.0f} %"
        return f"It covers {share} of {self.name}: the ostium lies {place}"


def find_ostia(
    surface: Surface,
    axis: ExtendedAxis,
    *,
    face_ids: ArrayLike | None = None,
    tube: Tube | None = None,
) -> tuple[Ostium, ...]:
    """The ostia along an axis, from proximal to distal.

    Parameters
    ----------
    surface : Surface
        Native, open or closed, mm.
    axis : ExtendedAxis
        Of the stent; ostia beyond its ends are found as far as it reaches.
    face_ids : array_like of int, shape (m,), optional
        SimVascular's ids of the faces; they name the branches.
    tube : Tube, optional
        `expected_tube` of the same surface and axis where it is known.
    """
    tube = tube or expected_tube(surface, axis.points)
    found = [_ostium(tube, axis, opening) for opening in openings(surface, tube, face_ids=face_ids)]
    found.sort(key=lambda ostium: (ostium.start, ostium.end))
    return tuple(_named(ostium, number) for number, ostium in enumerate(found, start=1))


class Opening(NamedTuple):
    """A part of a tube's wall at which the lumen goes on into another vessel."""

    region: Mask
    """(n, RAYS) of the map of the wall."""
    outlets: Points
    """(k, 3) centers of the flat caps that it leads to."""
    face_ids: tuple[int, ...]
    """Theirs, where ids are known."""


def openings(surface: Surface, tube: Tube, *, face_ids: ArrayLike | None = None) -> list[Opening]:
    """Where the wall of a tube opens into other vessels, in no order; see `find_ostia`."""
    if not tube.is_open.any():
        return []
    parts = _parts_beyond(surface, tube)
    caps = _caps_beyond(surface, tube, parts.of_triangle)
    leads = parts.is_far.copy()
    leads[[cap.part for cap in caps]] = True
    regions = _regions(tube, np.where(leads[parts.of_triangle], parts.of_triangle, -1))
    ids = None if face_ids is None else np.asarray(face_ids)
    found = []
    for part, region in regions.items():
        if parts.is_onward[part] and not _leads_aside(tube, region):
            continue
        own = [cap for cap in caps if cap.part == part]
        centers = np.reshape([cap.center for cap in own], (-1, 3))
        names = () if ids is None else tuple(sorted({_most(ids[cap.faces]) for cap in own}))
        found.append(Opening(region, centers, names))
    return found


def _leads_aside(tube: Tube, region: Mask) -> bool:
    """Whether an opening leads far from a vessel that hangs together with what it leads to.

    Else it is the vessel itself beyond its end, or a branch of which only a part is in reach.
    """
    is_far = tube.wall.distance > FAR * tube.expected
    return bool(is_far[region].any() and not region[[0, -1]].any())


class _Parts(NamedTuple):
    """The connected parts of the surface beyond the wall of a tube."""

    of_triangle: Indices
    """(m,) number of the part that a triangle of the surface touches, 0 for none."""
    is_far: Mask
    """By number: whether the part leads far away,"""
    is_onward: Mask
    """and whether it is the vessel itself, beyond an end of the tube."""


def _parts_beyond(surface: Surface, tube: Tube) -> _Parts:
    """What is left of the surface without the wall of the tube between its ends."""
    place = _seen_from(surface.points[tube.near.point_ids], tube)
    relative, is_past = np.full(len(surface.points), np.inf), np.zeros(len(surface.points), bool)
    relative[tube.near.point_ids], is_past[tube.near.point_ids] = place
    is_beyond = (relative > BEYOND) | is_past
    corners = np.asfortranarray(surface.triangles).T
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
    """A cap in the way of the tube closes the tube itself; an edge of it may lie beyond."""
    own = np.flatnonzero(part_of_triangle > 0)
    found = []
    for cap in flat_caps(surface.points, surface.triangles[own]):
        faces = own[cap.faces]
        center = surface.points[surface.triangles[faces]].mean(axis=(0, 1))
        relative, _ = _seen_from(center[None], tube)
        if relative[0] > BEYOND:
            found.append(_Cap(_most(part_of_triangle[faces]), faces, center))
    return found


def _regions(tube: Tube, part_of_triangle: Indices) -> dict[int, Mask]:
    """The openings (n, RAYS) by the part of the surface to which they lead; -1: to none."""
    is_open = tube.is_open
    hit = np.where(tube.wall.triangle >= 0, part_of_triangle[tube.wall.triangle], -1)
    label = labels_round(is_open)
    regions: dict[int, Mask] = {}
    for number in np.unique(label[is_open & (hit >= 0)]):
        region = label == number
        parts = np.unique(hit[region & (hit >= 0)])
        for part, own in zip(parts, _shared(region, hit, parts), strict=True):
            regions[int(part)] = regions.get(int(part), np.zeros_like(region)) | own
    return regions


def _shared(region: Mask, hit: Indices, parts: Indices) -> list[Mask]:
    """A region that leads to several parts of the surface, each cell to the nearest one."""
    if len(parts) == 1:
        return [region]
    from scipy.ndimage import distance_transform_edt

    # Three turns side by side: the map is periodic.
    turns = [distance_transform_edt(~np.tile(region & (hit == part), 3)) for part in parts]
    nearest = np.argmin([turn[:, RAYS : 2 * RAYS] for turn in turns], axis=0)
    return [region & (nearest == number) for number in range(len(parts))]


def labels_round(mask: Mask) -> Indices:
    """Connected regions of a map that is periodic in its second direction; 0 outside."""
    from scipy.ndimage import label

    labels, count = label(mask, structure=np.ones((3, 3)))
    joined = [(labels[:, -1], np.roll(labels[:, 0], shift)) for shift in (-1, 0, 1)]
    pairs = np.unique(np.hstack(joined), axis=1)
    pairs = pairs[:, (pairs > 0).all(axis=0)]
    group = connected(count + 1, pairs[0], pairs[1])[1]
    return np.where(mask, group[labels] + 1, 0)


def _ostium(tube: Tube, axis: ExtendedAxis, opening: Opening) -> Ostium:
    region = opening.region
    half = tube.wall.spacing / 2
    low, high = (tube.wall.arc_length + shift - axis.before for shift in (-half, half))
    inside = np.clip(high, 0, axis.stent_length) - np.clip(low, 0, axis.stent_length)
    # A cell of the expected wall; infinite where the axis runs in the open.
    area = np.where(region & np.isfinite(tube.expected), tube.expected, 0.0)
    area *= 2 * np.pi / RAYS * 2 * half
    rows = np.flatnonzero(region.any(axis=1))
    total = float(area.sum())
    places = _places(tube)
    return Ostium(
        "",
        (places[region] * area[region][:, None]).sum(axis=0) / total,
        float(low[rows[0]]),
        float(high[rows[-1]]),
        total,
        float(area.sum(axis=1) @ (inside / (2 * half)) / total),
        opening.face_ids,
        opening.outlets,
        places[region & ~_inner(region)],
    )


def _places(tube: Tube) -> Floats:
    """(n, RAYS, 3) points of the expected wall."""
    angles = ray_angles()
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rays = np.einsum("rk,nkj->nrj", directions, tube.wall.frames[:, 1:])
    expected = np.where(np.isfinite(tube.expected), tube.expected, 0.0)
    return np.asarray(tube.wall.centers[:, None] + expected[..., None] * rays)


def _inner(region: Mask) -> Mask:
    """Cells whose four neighbors belong to the region as well."""
    padded = np.pad(region, ((1, 1), (0, 0)))
    along = padded[:-2] & padded[2:]
    return np.asarray(region & along & np.roll(region, 1, axis=1) & np.roll(region, -1, axis=1))


def _most(values: NDArray[np.int64]) -> int:
    kinds, counts = np.unique(values, return_counts=True)
    return int(kinds[np.argmax(counts)])


def _named(ostium: Ostium, number: int) -> Ostium:
    ids = ostium.face_ids
    if ids:
        name = f"branch to face{'s' if len(ids) > 1 else ''} {', '.join(map(str, ids))}"
    else:
        name = f"branch {number}"
    return replace(ostium, name=name)
