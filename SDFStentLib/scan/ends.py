"""The ends of a vessel from a scan, cut flat: across its line, or where the image ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline, distal_ends
from ..certificate import SurfaceCheck, check_surface
from ..geometry import Line, Surface, norm
from ..segment import (
    CutPlane,
    OpenSegment,
    PlaneFinder,
    Segment,
    bounded,
    closed_segment,
    with_inlets,
)
from ..threads import side_by_side
from ..validation import Floats, Indices, InputError, Points
from ..vessel import VesselParts, vessel_parts

WITHIN = 0.5
"""An end is cut within this part of the way to the next junction, so that each vessel stays."""

INSIDE = 0.5
"""Radii from a round end inward at which the vessel has its whole width: lines end in a ball of 0.9
of it, which lies half a radius farther out in a hemisphere."""

NAMED = 10.0
"""A place that names an end is so near to it or within two of its radii, mm."""


class Border(NamedTuple):
    """A side of the image that cuts the label off."""

    axis: int
    at: float
    """Position of the outer faces of its last voxels, mm along the axis."""
    inward: float
    """1 where the image is beyond that, -1 where it is before."""

    def beyond(self, place: Points) -> float:
        """Distance of a place (3,) beyond the border, mm; negative inside."""
        return float(self.inward * (self.at - place[self.axis]))

    @property
    def normal(self) -> Floats:
        found = np.zeros(3)
        found[self.axis] = self.inward
        return found


class RoundEnd(NamedTuple):
    """An end of a vessel as it was segmented."""

    line: Line
    """The line from the end inward, to the next junction."""
    numbers: Indices
    """(n,) its points in the tree."""
    radius: float
    border: Border | None
    """The border that cuts it off."""


class FlatEnds(NamedTuple):
    """A vessel with flat ends."""

    segment: Segment
    """Segment, of whose faces the inlet comes first."""
    planes: tuple[CutPlane | None, ...]
    """The plane of each end; where none cuts one vessel alone the end stays as it is."""
    is_sound: bool
    """Whether the surface is closed and none of its triangles fails."""


def round_ends_of(tree: Centerline, borders: Sequence[Border]) -> list[RoundEnd]:
    """The ends of a tree, its root first."""
    tips = [*tree.roots.tolist(), *distal_ends(tree.parent, tree.loops).tolist()]
    branches = {int(branch[k]): (branch, k) for branch in tree.branches for k in (0, -1)}
    found = []
    for tip in tips:
        branch, side = branches[tip]
        numbers = branch if side == 0 else branch[::-1]
        points = tree.points[numbers]
        radius = float(tree.inscribed_radius[tip])
        cuts = [one for one in borders if one.beyond(points[0]) > -radius]
        found.append(RoundEnd(Line(points), numbers, radius, cuts[0] if cuts else None))
    return found


class _FoundPlane(NamedTuple):
    """A plane that meets one vessel alone."""

    plane: CutPlane
    area: float
    """Area of the lumen in it, mm^2."""


def flat_ends(
    surface: Surface, tree: Centerline, ends: Sequence[RoundEnd], inlet: Points | None
) -> FlatEnds:
    """A vessel with its ends cut flat and closed, faces named, the inlet first.

    Parameters
    ----------
    surface : Surface
    tree : Centerline
        Centerlines of the surface.
    ends : sequence of RoundEnd
    inlet : (3,) array or None
        Names the inlet, mm; the widest end by default.

    Raises
    ------
    InputError
        Fewer than two ends can be cut, or not the inlet; a place that names no end.
    """
    parts = vessel_parts(surface, tree)
    finder = PlaneFinder(parts)
    ways = [_planes(finder, end) for end in ends]
    found = side_by_side(_next, ways)
    # Ends: each way has an end, and with one plane less each time.
    while True:
        cut, opened = _bounding(parts, ends, found, ways)
        planes = tuple(None if one is None else one.plane for one in found)
        if opened is None or len(cut) < 2:
            raise InputError(
                "segmentation: expected a vessel with two ends or more that a plane cuts off "
                f"across, found {len(cut)}; trim the segment, or label one vessel alone."
            )
        if inlet is None:
            first = max(sorted(cut), key=lambda number: one.area if (one := found[number]) else 0.0)
        else:
            first = _named(ends, planes, inlet)
        ordered = sorted(cut, key=lambda number: (number != first, number))
        places = [cut.index(number) for number in ordered]
        numbered = {
            place: replace(opened.planes[place], name=str(number))
            for number, place in enumerate(places)
        }
        segment = closed_segment(opened.with_planes(numbered))
        check = check_surface(segment.surface)
        faulty = [] if check.passed else [ordered[number] for number in _faulty(segment, check)]
        if not faulty:
            break
        for number in faulty:
            found[number] = _next(ways[number])
    name = next(face.name for face in segment.faces if face.said == "0")
    faces = with_inlets(segment.faces, [name])
    is_sound = check.passed and check.is_watertight
    return FlatEnds(replace(segment, faces=faces), planes, is_sound)


def _faulty(segment: Segment, check: SurfaceCheck) -> list[int]:
    """Numbers of the planes at whose caps triangles fail: they graze the wall there."""
    faults = (
        check.inverted_triangles, check.degenerate_triangles, check.self_intersecting_triangles,
    )  # fmt: skip
    triangles = segment.surface.triangles
    beside = np.isin(triangles, triangles[np.concatenate(faults)]).any(axis=1)
    touched = set(segment.face_ids[beside].tolist())
    caps = (face for face in segment.faces if face.said.isdecimal())
    return [int(face.said) for face in caps if face.number in touched]


def _bounding(
    parts: VesselParts,
    ends: Sequence[RoundEnd],
    found: list[_FoundPlane | None],
    ways: Sequence[Iterator[_FoundPlane]],
) -> tuple[list[int], OpenSegment | None]:
    """Numbers of the planes that bound a segment together, and that.

    Where less than two are left, a plane that parts nothing, as where a tunnel in the wall leads
    round it, makes place for the next one of its way. The others become None: those beyond another
    one, which lies close to a junction and has cut off their vessel, too; of two that meet that of
    the shorter end.
    """
    lengths = [end.line.length / end.radius for end in ends]
    order = sorted(range(len(found)), key=lambda n: -lengths[n])
    # Ends: each way has an end, and with one plane less each time.
    while True:
        own = [n for n in order if found[n]]
        planes = [one.plane for n in own if (one := found[n])]
        made = bounded(parts, planes)
        if not made.apart:
            return own, made.segment
        # In a tree with many ends that is not worth its time.
        is_needed = len(own) - len(made.apart) < 2
        for number in made.apart:
            parts_nothing = is_needed and bool(bounded(parts, [planes[number]]).apart)
            found[own[number]] = _next(ways[own[number]]) if parts_nothing else None


def _named(ends: Sequence[RoundEnd], planes: Sequence[CutPlane | None], inlet: Points) -> int:
    """The end that a place (3,) names; `InputError` where that has no plane."""
    tips = np.array([end.line.points[0] for end in ends])
    away = norm(tips - inlet)
    number = int(np.argmin(away))
    if away[number] > max(NAMED, 2 * ends[number].radius):
        raise InputError(
            f"inlet: expected a place at an end of the vessel, the nearest end is "
            f"{away[number]:.1f} mm away; give one in mm and LPS."
        )
    if planes[number] is None:
        raise InputError(
            "inlet: expected an end that a plane cuts off across, no plane there meets this vessel "
            "alone; choose another one, or trim the segment."
        )
    return number


def _planes(finder: PlaneFinder, end: RoundEnd) -> Iterator[_FoundPlane]:
    """The planes from an end inward that meet its vessel alone, at its whole width.

    Where lines part at once, as in a wide trunk, the last ones before that.
    """
    if end.border is not None:
        at = _crossing(end.line.points, end.border)
        if (found := _found(finder, at, end.border.normal)) is not None:
            yield found
        if end.border.beyond(end.line.points[-1]) > 0:
            return
    line, early = end.line, []
    for tried in finder.steps(line):
        if tried.along > WITHIN * line.length:
            break
        if end.border is not None and end.border.beyond(tried.place) > 0:
            continue
        if end.border is None and tried.along < INSIDE * end.radius:
            early.append(tried)
            continue
        if (found := _found(finder, tried.place, tried.direction)) is not None:
            yield found
    for tried in reversed(early):
        if (found := _found(finder, tried.place, tried.direction)) is not None:
            yield found


def _next(way: Iterator[_FoundPlane]) -> _FoundPlane | None:
    return next(way, None)


def _found(finder: PlaneFinder, origin: Points, normal: Floats) -> _FoundPlane | None:
    section = finder.section(origin, normal)
    if isinstance(section, str):
        return None
    return _FoundPlane(CutPlane("", origin, normal), section.area)


def _crossing(points: Points, border: Border) -> Points:
    """Place (3,) where a line (n, 3) from the outside crosses a border, or beside its end."""
    out = np.array([border.beyond(point) for point in points])
    if out[0] <= 0 or (out > 0).all():
        found = points[0].copy()
    else:
        last = int((out <= 0).argmax())
        share = out[last - 1] / (out[last - 1] - out[last])
        found = points[last - 1] + share * (points[last] - points[last - 1])
    found[border.axis] = border.at
    return np.asarray(found)
