"""Ostia: where a vessel opens into its branches, and how much of each a stent covers.

An ostium is the part of the vessel's expected wall at which there is none, because the lumen goes
on into another vessel. It is found on the surface alone: rays across the axis tell where the wall
leaves the expected one, and the surface there tells whether that leads into another vessel.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ..centerline import Centerline
from ..geometry import NamedFaces, Surface, norm
from ..lumen import (
    ALIKE,
    RAYS,
    ExtendedAxis,
    Mask,
    Opening,
    Tube,
    caps_of,
    expected_tube,
    openings,
    pouch_width,
)
from ..validation import Flags, Floats, Indices, Points, read_only
from .caliber import ANEURYSM

LISTED = 10.0
"""Ostia so far beyond an end of the stent are found, mm."""

FREE = "free"
"""The word for an ostium that nothing covers."""

PARENT = "vessel that this one comes from"

POUCH = "pouch (aneurysm or stump)"
"""Name of what is short and closed: a flat sac and what is left of a branch look alike."""

SAC = "aneurysm"
"""A pouch `ANEURYSM` times as wide as its neck."""


@dataclass(frozen=True)
class Ostium:
    """The opening of a side branch, or pouch, in the wall of the stented vessel. All mm.

    Positions along the stent count from its proximal end; negative: proximal of the stent.
    """

    name: str
    """The name of the model's faces where they have one, else its size, place and outlets."""
    center: Floats
    """(3,) the middle of the opening."""
    start: float
    """Start of the opening along the stent,"""
    end: float
    """and its end."""
    area: float
    """The area of the opening, on the expected wall, mm^2."""
    covered_share: float
    """Share of that area between the ends of the stent, or of any stent, 0 to 1."""
    face_ids: tuple[int, ...] = ()
    """Face ids of the ends of the model that the branch leads to."""
    outlets: Points = ()  # type: ignore[assignment]
    """(k, 3) centers of the flat caps that the branch leads to."""
    outline: Points = ()  # type: ignore[assignment]
    """(j, 3) points of the expected wall along the border of the opening, in no order."""
    areas: Floats = ()  # type: ignore[assignment]
    """(r,) areas of the rows of that wall round the axis, mm^2, between"""
    edges: Floats = ()  # type: ignore[assignment]
    """(r + 1,) these positions along the stent."""
    pouch: str = ""
    """`POUCH` or `SAC` for one that leads into no vessel."""

    def __post_init__(self) -> None:
        for name in ("center", "areas", "edges"):
            object.__setattr__(self, name, read_only(np.asarray(getattr(self, name))))
        for name in ("outlets", "outline"):
            object.__setattr__(self, name, read_only(np.reshape(getattr(self, name), (-1, 3))))

    @property
    def is_free(self) -> bool:
        """Whether no part that counts lies under the stent."""
        return self.covered_share < ALIKE - 1

    @property
    def is_fully_covered(self) -> bool:
        """Whether no part that counts lies beside the stent."""
        return 1 - self.covered_share < ALIKE - 1

    @property
    def coverage(self) -> str:
        """Coverage by the stent, in two or three words."""
        if self.is_free:
            return FREE
        share = "fully" if self.is_fully_covered else f"{100 * self.covered_share:.0f} %"
        return f"{share} covered"

    def share_within(self, spans: Iterable[tuple[float, float]]) -> float:
        """Share of its area between any of some pairs of positions along the stent, 0 to 1."""
        below = np.concatenate([[0.0], np.cumsum(self.areas)])
        share, done = 0.0, -np.inf
        for start, end in sorted(spans):
            begun, done = max(start, done), max(end, done)
            share += float(np.ptp(np.interp([begun, done], self.edges, below)))
        return min(share / below[-1], 1.0)  # rounding

    def is_same(self, other: Ostium) -> bool:
        """Whether it is the same branch as one beside another stent, whatever each is called.

        Most of what both lead to is the same; where nothing is known of that, one has its middle
        in the other.
        """
        if not (len(self.outlets) and len(other.outlets)):
            away = np.linalg.norm(self.center - other.center)
            return bool(2 * away < max(_diameter(self), _diameter(other)))
        apart = np.linalg.norm(self.outlets[:, None] - other.outlets, axis=2)
        common = (2 * apart.min(axis=1) < min(_diameter(self), _diameter(other))).sum()
        return bool(2 * common > max(apart.shape))

    def sentence(self) -> str:
        """Coverage by the stent and place along it, as a sentence for the user."""
        return (
            f"{self.name[:1].upper()}{self.name[1:]}: {self.coverage}; its ostium lies from "
            f"{self.start:.1f} to {self.end:.1f} mm of the proximal end of the stent."
        )


def find_ostia(
    surface: Surface,
    axis: ExtendedAxis,
    faces: NamedFaces | None = None,
    centerline: Centerline | None = None,
) -> tuple[Ostium, ...]:
    """The ostia of a stent and up to `LISTED` mm beyond its ends, from proximal to distal.

    Parameters
    ----------
    surface : Surface
        Native, open or closed, mm.
    axis : ExtendedAxis
        Axis of the stent.
    faces : NamedFaces, optional
        Faces of the surface; those with names name the branches.
    centerline : Centerline, optional
        Tree: what leads to its root is no branch, but the vessel from which this one comes: this
        one itself where the way beyond the stent goes there. Where all of its ends lie in flat
        caps, what leads to no cap is no vessel. What a line leads into is no pouch.
    """
    tube = expected_tube(surface, axis.line)
    wall, places, ends = _faces_of_wall(tube, faces), tube.places, np.empty((0, 3))
    inlet, end_above = ends, np.empty(0, dtype=np.int64)
    if centerline is not None:
        ends = centerline.points[[centerline.roots[0], *centerline.leaves]]
        inlet = ends[:1]
        if _comes_from_root(axis, centerline):
            end_above = _nearest_cap(surface, inlet[0])
    found = []
    for opening in openings(surface, tube, ends):
        ostium = _ostium(tube, places, axis, opening)
        at_root = _are_at(inlet, ostium)
        # A wall that opens like a funnel shows the vessel itself above, and its end.
        at_root &= np.array([np.isin(own, end_above).any() for own in opening.caps], dtype=bool)
        if at_root.any() and at_root.all():
            continue
        caps = [own for own, is_root in zip(opening.caps, at_root, strict=True) if not is_root]
        ids = () if faces is None else {faces.most(own) for own in caps} - wall
        outlets = ostium.outlets[~at_root]
        ostium = replace(ostium, outlets=outlets, face_ids=tuple(sorted(ids)))
        if ostium.end > -LISTED and ostium.start < axis.stent_length + LISTED:
            if not opening.caps:
                pouch = _pouch(surface, tube, ostium, opening, centerline)
                ostium = replace(ostium, pouch=pouch)
            found.append(ostium)
    found.sort(key=lambda ostium: (ostium.start, ostium.end))
    at_end = int(np.searchsorted(tube.wall.arc_length, axis.before + axis.stent_length))
    caliber = 2 * float(np.median(tube.expected[min(at_end, len(tube.expected) - 1)]))
    return tuple(
        replace(ostium, name=_name(ostium, axis.stent_length, caliber, faces, inlet))
        for ostium in found
    )


def _comes_from_root(axis: ExtendedAxis, tree: Centerline) -> bool:
    """Whether the way beyond the proximal end of a stent leads to the root.

    One from a branch into another has the root aside.
    """
    ends = axis.points[0], axis.of_stent.points[0]
    above, start = (tree.project(place).arc_length for place in ends)
    return above < start


def _nearest_cap(surface: Surface, place: Floats) -> Indices:
    """The triangles of the flat cap whose middle is nearest to a place; none without a cap."""
    caps = caps_of(surface)
    if not caps:
        return np.empty(0, dtype=np.int64)
    return min(caps, key=lambda cap: float(np.linalg.norm(cap.middle - place))).faces


def _are_at(inlet: Points, ostium: Ostium) -> Flags:
    """Mask (k,) of an ostium's outlets at the inlet (1, 3), no farther from it than the ostium is
    wide; none where that is not known."""
    if not len(inlet):
        return np.zeros(len(ostium.outlets), dtype=bool)
    away = np.linalg.norm(ostium.outlets - inlet, axis=1)
    return np.asarray(away < _diameter(ostium))


def _diameter(ostium: Ostium) -> float:
    """The diameter of the circle as large, mm."""
    return 2 * float(np.sqrt(ostium.area / np.pi))


def _faces_of_wall(tube: Tube, faces: NamedFaces | None) -> set[int]:
    """Ids on the wall of the vessel itself: they distinguish no branches."""
    if faces is None:
        return set()
    own = tube.wall.triangle[~tube.is_open & (tube.wall.triangle >= 0)]
    return set(faces.ids[own].tolist())


def _ostium(tube: Tube, places: Floats, axis: ExtendedAxis, opening: Opening) -> Ostium:
    """An opening of a tube whose expected wall has these places (n, RAYS, 3)."""
    region, spacing = opening.region, tube.wall.spacing
    # A cell of the expected wall; infinite where the axis runs in the open.
    area = np.where(region & np.isfinite(tube.expected), tube.expected, 0.0)
    area *= 2 * np.pi / RAYS * spacing
    rows = np.flatnonzero(region.any(axis=1))
    own = slice(rows[0], rows[-1] + 1)
    middles = tube.wall.arc_length[own] - axis.before
    total = float(area.sum())
    ostium = Ostium(
        "",
        (places[region] * area[region][:, None]).sum(axis=0) / total,
        float(middles[0] - spacing / 2),
        float(middles[-1] + spacing / 2),
        total,
        0.0,
        outlets=opening.outlets,
        outline=places[region & ~_inner(region)],
        areas=area[own].sum(axis=1),
        edges=np.r_[middles - spacing / 2, middles[-1] + spacing / 2],
    )
    return replace(ostium, covered_share=ostium.share_within([(0.0, axis.stent_length)]))


def _pouch(
    surface: Surface, tube: Tube, ostium: Ostium, opening: Opening, tree: Centerline | None
) -> str:
    """Kind of pouch at an opening of a tube that leads to no cap; "" for a vessel."""
    centers = tube.wall.centers
    outward = ostium.center - centers[norm(centers - ostium.center).argmin()]
    neck = _diameter(ostium)
    width = pouch_width(surface, opening.beyond, ostium.center, neck, outward, tree)
    if width is None:
        return ""
    return SAC if width >= ANEURYSM * neck else POUCH


def _inner(region: Mask) -> Mask:
    """Cells whose four neighbors belong to the region as well."""
    padded = np.pad(region, ((1, 1), (0, 0)))
    along = padded[:-2] & padded[2:]
    return np.asarray(region & along & np.roll(region, 1, axis=1) & np.roll(region, -1, axis=1))


def _name(
    ostium: Ostium, stent_length: float, caliber: float, faces: NamedFaces | None, inlet: Points
) -> str:
    """Name of an ostium; one wider than the stented vessel is that of no side branch."""
    diameter = _diameter(ostium)
    if _are_at(inlet, ostium).any():
        return PARENT
    ids = set(ostium.face_ids)
    if faces is not None and ids and ids <= faces.names.keys():
        return faces.branch_name(ostium.face_ids)
    middle = (ostium.start + ostium.end) / 2
    if middle < 0:
        place = f"{-middle:.0f} mm before the stent"
    elif middle > stent_length:
        place = f"{middle - stent_length:.0f} mm beyond the stent"
    else:
        place = f"at {middle:.0f} mm"
    if ostium.pouch:
        neck = " with a neck" if ostium.pouch == SAC else ""
        return f"{ostium.pouch}{neck} of {diameter:.1f} mm {place}"
    kind = "side branch" if diameter < caliber else "branch"
    ends = f" with {len(ostium.outlets)} outlets" if len(ostium.outlets) > 1 else ""
    return f"{kind} of {diameter:.1f} mm{ends} {place}"
