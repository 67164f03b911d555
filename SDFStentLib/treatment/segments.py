"""Segments of a vessel before and after its treatment, cut by the same planes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..centerline import distal_ends
from ..certificate import check_surface
from ..geometry import Surface
from ..segment import (
    HOLE,
    CutPlane,
    OpenBranch,
    OpenSegment,
    Segment,
    SegmentEnds,
    close_side_branches,
    closed_segment,
    segment_between,
    segment_ends,
)
from ..validation import DeploymentError, InputError, Points, as_place, plain
from ..vessel import VesselParts, vessel_parts
from .vessel import Vessel
from .warnings import WIDEST

_SAME_VESSEL = "give the same vessel after its treatment, in the same unit"


class SegmentWishes(NamedTuple):
    """Options of cutting a segment."""

    close_branches: bool = False
    """Whether side branches are cut off and closed; else they are kept as long as they are."""
    cut_branches: bool = False
    """Whether they are cut off likewise and become outlets."""
    nearest: bool = False
    """Whether an end where no plane meets only this vessel moves into the segment, as far as it
    takes; a warning says so."""
    units: str = "mm"
    """Unit of the vessel's file, in which sentences give places, too."""


@dataclass(frozen=True)
class ExtractedSegment:
    """A segment of a vessel, and of the same vessel after treatment."""

    planes: tuple[CutPlane, ...]
    before: Segment
    after: Segment | None = None
    warnings: tuple[Caution, ...] = ()


def extract_segment(
    vessel: Vessel,
    start: Points,
    end: Points,
    wishes: SegmentWishes = SegmentWishes(),  # noqa: B008
    *,
    after: Vessel | None = None,
) -> ExtractedSegment:
    """Cut a segment between two places of a vessel out of it.

    Parameters
    ----------
    vessel : Vessel
        Vessel with a centerline.
    start, end : (3,) arrays
        Places in it, mm.
    wishes : SegmentWishes, optional
    after : Vessel, optional
        Vessel after treatment, which is cut by the planes of the untreated one.

    Raises
    ------
    InputError
        No centerline, places at which no plane meets only this vessel, or another vessel as the
        treated one. A side branch that cannot be closed is a warning.
    DeploymentError
        The segment would not be watertight or would cross itself.
    """
    if vessel.centerline is None:
        raise InputError("segment: expected a vessel with a centerline, got none; give one.")
    parts = vessel_parts(
        vessel.surface, vessel.centerline, vessel.faces, wishes.units, vessel.given_names
    )
    state = None if after is None else _state_of(parts, vessel, after)
    try:
        ends = segment_ends(parts, start, end, nearest=wishes.nearest, treated=state)
    except InputError:
        if state is not None:
            native = segment_ends(parts, start, end, nearest=wishes.nearest)
            _treated(native.opened, state)  # another vessel is told as that
        raise
    states: tuple[OpenSegment, ...] = (ends.opened,)
    if state is not None:
        states = (*states, _treated(ends.opened, state))
    left: tuple[OpenBranch, ...] = ()
    if wishes.close_branches or wishes.cut_branches:
        outlets = not wishes.close_branches
        states, left = close_side_branches(ends, states, as_outlets=outlets)
    if not wishes.close_branches:
        left = ()  # what no plane cuts is an outlet at its own end
    before = _sound(closed_segment(states[0]), "segment")
    treated = [_sound(closed_segment(state), "treated segment") for state in states[1:]]
    made = (*_moved_ends(ends), *_open_branches(left))
    if wishes.close_branches and not left:
        made = (*made, *_without_line(before, states[0].planes))
    warnings = (*made, *_holes(before), *_dead_ends(before, parts))
    return ExtractedSegment(states[0].planes, before, treated[0] if treated else None, warnings)


def _treated(native: OpenSegment, parts: VesselParts) -> OpenSegment:
    """The segment of the treated vessel; `InputError` where that seems to be another vessel."""
    try:
        treated = segment_between(parts, native.planes)
    except InputError as error:
        raise InputError(f"treated {str(error).removesuffix('.')}, or {_SAME_VESSEL}.") from error
    if not any(
        1 / WIDEST**2 <= after / before <= WIDEST**2
        for before, after in zip(native.areas, treated.areas, strict=True)
    ):
        raise InputError(
            f"treated segment: expected an end that is at most {WIDEST:g} times as "
            f"wide or narrow as before ({plain(native.areas[0], '.3g')} mm2), "
            f"got {plain(treated.areas[0], '.3g')} mm2; {_SAME_VESSEL}."
        )
    return treated


def _state_of(parts: VesselParts, vessel: Vessel, after: Vessel) -> VesselParts:
    """The parts after treatment: the same where the triangles are, so that a bulged cap is one."""
    if np.array_equal(vessel.surface.triangles, after.surface.triangles):
        return parts._replace(surface=Surface(after.surface.points, parts.surface.triangles))
    return vessel_parts(after.surface, parts.tree, after.faces, parts.units)._replace(
        branch_names=parts.branch_names
    )


def _open_branches(left: Sequence[OpenBranch]) -> Iterator[Caution]:
    """The side branches that could not be closed."""
    for branch in left:
        yield Caution("open-branch", {"name": branch.name}, as_place(branch.place))


def _without_line(segment: Segment, planes: Sequence[CutPlane]) -> Iterator[Caution]:
    """Outlets beside the ends of the segment, of branches that the centerline does not know."""
    caps = [face for face in segment.faces if face.kind != "wall"]
    centers = np.array([face.center for face in caps])
    ends = [
        int(np.linalg.norm(centers - plane.origin, axis=1).argmin())
        for plane in planes
        if not plane.is_closed
    ]
    for number in np.setdiff1d(np.arange(len(caps)), ends):
        yield Caution("branch-without-line", {"name": caps[number].name}, as_place(centers[number]))


def _moved_ends(ends: SegmentEnds) -> Iterator[Caution]:
    """Cautions on ends that lie elsewhere than wanted."""
    for word, by, plane in zip(("start", "end"), ends.moved, ends.opened.planes, strict=False):
        if by > 0:
            yield Caution("end-moved", {"end": word, "distance_mm": by}, as_place(plane.origin))


def _holes(segment: Segment) -> Iterator[Caution]:
    """Cautions on openings of the wall that were closed."""
    for face in segment.faces:
        if face.name.split("_")[0] == HOLE:
            width = 2 * float(np.sqrt(face.area / np.pi))
            yield Caution("hole", {"diameter_mm": width, "name": face.name}, as_place(face.center))


def _dead_ends(segment: Segment, parts: VesselParts) -> Iterator[Caution]:
    """Branches that are kept and have no outlet, because the surface ends round there.

    An opening is that of the branch whose centerline ends nearest to it, which may be before it.
    """
    tree = parts.tree
    tips = np.r_[distal_ends(tree.parent, tree.loops), tree.roots]
    away = np.linalg.norm(parts.openings[:, None] - tree.points[tips], axis=2)
    for tip in np.setdiff1d(tips, tips[np.argmin(away, axis=1)]):
        beside = tree.points[tree.neighbors.of(tip)[0]]
        inward = tree.points[tip] + 0.5 * (beside - tree.points[tip])
        if segment.surface.contains(inward[None])[0]:
            yield Caution("dead-end", {}, as_place(tree.points[tip]))


def _sound(segment: Segment, name: str) -> Segment:
    found = check_surface(segment.surface)
    if found.passed and found.is_watertight:
        return segment
    raise DeploymentError(
        f"{name}: expected one that is watertight and sound. {found.sentence()} Move its ends, or "
        "look at the vessel with sdfstent check."
    )
