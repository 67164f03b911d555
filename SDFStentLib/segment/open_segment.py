"""A part of a vessel between planes, still open where they cut it, from which more can be cut."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..geometry import CutSurface, component_labels, cut_along, paired_sides, section_around
from ..validation import Indices, InputError
from ..vessel import VesselParts
from .cut_planes import CutPlane


@dataclass(frozen=True, eq=False)
class OpenSegment:
    """A part of a vessel between planes, open in each of them.

    Attributes
    ----------
    vessel : VesselParts
        The vessel from which it was cut.
    mesh : CutSurface
        Triangles of the segment; their sources are triangles of the vessel.
    planes : tuple of CutPlane
    rims : tuple of (r,) arrays of int
        The curve of each plane, in the direction of the triangles beside it.
    areas : tuple of float
        Area of the lumen in each plane, mm^2.
    """

    vessel: VesselParts
    mesh: CutSurface
    planes: tuple[CutPlane, ...] = ()
    rims: tuple[Indices, ...] = ()
    areas: tuple[float, ...] = ()

    def with_planes(self, planes: Mapping[int, CutPlane]) -> OpenSegment:
        """The segment with its planes, by their places so far, in another order or renamed."""
        order = list(planes)
        return replace(
            self,
            planes=tuple(planes.values()),
            rims=tuple(self.rims[place] for place in order),
            areas=tuple(self.areas[place] for place in order),
        )

    def cut_off(self, plane: CutPlane) -> OpenSegment | None:
        """The segment without the part beyond a plane; None where that part is not one branch
        alone."""
        cut = _divided(self, plane)
        if isinstance(cut, str):
            return None
        sides = _SidesOfCuts(cut.mesh, cut.rims[-1:])
        kept = cut.mesh.triangles[sides.kept]
        is_whole = np.isin(np.concatenate(self.rims), kept).all()
        return _only(cut, sides.kept) if sides.are_apart and is_whole else None


def segment_between(vessel: VesselParts, planes: Sequence[CutPlane]) -> OpenSegment:
    """The part of a vessel that two planes or more bound together.

    Raises
    ------
    InputError
        A plane that meets the vessel in no closed curve, or planes that bound no segment together.
    """
    found = _between(vessel, planes)
    if isinstance(found, str):
        said = " and ".join(vessel.said(plane.origin) for plane in planes)
        raise InputError(
            f"segment: expected planes at {said}, that bound one segment, {found}; choose other "
            "places."
        )
    return found


class Bounded(NamedTuple):
    """The part of a vessel that planes bound together, or which of them do not."""

    segment: OpenSegment | None
    """None where some of the planes are apart, or there is none."""
    apart: list[int]
    """Indices of the planes that do not bound the part that most of them bound. Of two that meet
    within the vessel it is the latter one."""


def bounded(vessel: VesselParts, planes: Sequence[CutPlane]) -> Bounded:
    """The part of a vessel that some planes bound together."""
    cut, apart, kept = _whole(vessel), list[int](), list[int]()
    for number, plane in enumerate(planes):
        divided = _divided(cut, plane)
        if isinstance(divided, str):
            apart.append(number)
        else:
            cut = divided
            kept.append(number)
    if not kept:
        return Bounded(None, apart)
    sides = _SidesOfCuts(cut.mesh, cut.rims)
    ends = np.cumsum([len(rim) for rim in cut.rims])[:-1]
    above, below = (np.split(labels, ends) for labels in (sides.above, sides.below))
    most = np.bincount([labels[0] for labels in above]).argmax()
    for number, one, other in zip(kept, above, below, strict=True):
        if (one != most).any() or (other == most).any():
            apart.append(number)
    return Bounded(None if apart else _only(cut, sides.kept), apart)


def _between(vessel: VesselParts, planes: Sequence[CutPlane]) -> OpenSegment | str:
    """The part of a vessel between two planes, or the reason why there is none."""
    cut = _whole(vessel)
    for number, plane in enumerate(planes, start=1):
        divided = _divided(cut, plane)
        if isinstance(divided, str):
            word = {1: "first", 2: "second"}.get(number, f"{number}th")
            return f"the {word} {divided}"
        cut = divided
    sides = _SidesOfCuts(cut.mesh, cut.rims)
    return _only(cut, sides.kept) if sides.are_apart else "the vessel goes on beside them"


def _whole(vessel: VesselParts) -> OpenSegment:
    """All of a vessel, bounded by no plane."""
    surface, none = vessel.surface, np.zeros(0, np.int64)
    every = np.arange(len(surface.triangles))
    return OpenSegment(vessel, CutSurface(surface.points, surface.triangles, every, none))


class _SidesOfCuts:
    """The part of a surface above curves, and whether none of it lies below one, too."""

    def __init__(self, mesh: CutSurface, rims: Sequence[Indices]) -> None:
        start = np.concatenate(rims)
        end = np.concatenate([np.roll(rim, -1) for rim in rims])
        sides = np.stack([mesh.triangles.ravel(), mesh.triangles[:, [1, 2, 0]].ravel()], axis=1)
        count = len(mesh.points)
        keys, rim_keys = sides[:, 0] * count + sides[:, 1], start * count + end
        is_cut = np.isin(keys, rim_keys) | np.isin(sides[:, 1] * count + sides[:, 0], rim_keys)
        pairs = paired_sides(mesh.triangles)
        pairs = pairs[~is_cut[pairs[:, 0]]] // 3
        label = component_labels(len(mesh.triangles), pairs[:, 0], pairs[:, 1])
        order = np.argsort(keys)
        self.above = above = label[order[np.searchsorted(keys, rim_keys, sorter=order)] // 3]
        self.below = label[order[np.searchsorted(keys, end * count + start, sorter=order)] // 3]
        self.are_apart = not ((above != above[0]).any() or (self.below == above[0]).any())
        self.kept = np.flatnonzero(label == above[0])


def _divided(segment: OpenSegment, plane: CutPlane) -> OpenSegment | str:
    """The whole segment, divided along a plane, or the reason why it cannot be."""
    mesh, none = segment.mesh, np.zeros(0, np.int64)
    section = section_around(mesh.points, mesh.triangles, plane.origin, plane.normal)
    if section is None or not section.is_closed:
        return "meets the vessel in no closed curve"
    if np.isin(mesh.triangles[section.triangles], np.concatenate([none, *segment.rims])).any():
        return "meets the other one within the vessel"
    cut = cut_along(mesh.points, mesh.triangles, section, plane.origin, plane.normal)
    if not len(cut.rim):
        return "meets the vessel in a curve that touches itself"
    return OpenSegment(
        segment.vessel,
        cut._replace(sources=mesh.sources[cut.sources]),
        (*segment.planes, plane),
        (*segment.rims, cut.rim),
        (*segment.areas, section.area),
    )


def _only(segment: OpenSegment, kept: Indices) -> OpenSegment:
    mesh = segment.mesh
    part = mesh._replace(triangles=mesh.triangles[kept], sources=mesh.sources[kept])
    return OpenSegment(segment.vessel, part, segment.planes, segment.rims, segment.areas)
