"""Segments of a vessel before and after its treatment, cut by the same planes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..cautions import Caution
from ..certificate import check_surface
from ..geometry import ClosedSurface, Surface
from ..measure import (
    HOLE,
    CutPlane,
    Segment,
    VesselParts,
    cut_segment,
    segment_planes,
    vessel_parts,
)
from ..validation import DeploymentError, InputError, Points
from .vessel import Vessel
from .warnings import WIDEST

_SAME_VESSEL = "give the same vessel after its treatment, in the same unit"


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
    *,
    close_branches: bool = False,
    after: Vessel | None = None,
    units: str = "mm",
) -> ExtractedSegment:
    """Cut a segment between two places of a vessel out of it.

    Parameters
    ----------
    vessel : Vessel
        With a centerline.
    start, end : (3,) arrays
        Places in it, mm.
    close_branches : bool
        Whether side branches are cut off and closed; else they are kept as long as they are.
    after : Vessel, optional
        The same vessel treated, which is cut by the planes of the untreated one.
    units : str
        Of the vessel's file, in which sentences tell places, too.

    Raises
    ------
    InputError
        No centerline, places at which no plane meets only this vessel, or another vessel as the
        treated one.
    DeploymentError
        The segment would not be watertight or would cross itself.
    """
    if vessel.centerline is None:
        raise InputError("segment: expected a vessel with a centerline, got none; give one.")
    parts = vessel_parts(vessel.surface, vessel.centerline, vessel.faces, units)
    planes = segment_planes(parts, start, end, close_branches=close_branches)
    before = _sound(cut_segment(parts, planes), "segment")
    treated = None
    if after is not None:
        treated = _treated(before, planes, _state_of(parts, vessel, after))
    warnings = (*_holes(before), *_dead_ends(before, parts))
    return ExtractedSegment(planes, before, treated, warnings)


def _treated(before: Segment, planes: tuple[CutPlane, ...], parts: VesselParts) -> Segment:
    """The segment of the treated vessel; `InputError` where that seems to be another vessel."""
    try:
        segment = cut_segment(parts, planes)
    except InputError as error:
        raise InputError(f"treated {str(error).removesuffix('.')}, or {_SAME_VESSEL}.") from error
    native, treated = (
        next(face.area for face in one.faces if face.kind == "inlet") for one in (before, segment)
    )
    if not 1 / WIDEST**2 <= treated / native <= WIDEST**2:
        raise InputError(
            f"treated segment: expected an inlet that is at most {WIDEST:g} times as "
            f"wide or narrow as before ({native:.3g} mm2), got {treated:.3g} mm2; {_SAME_VESSEL}."
        )
    return _sound(segment, "treated segment")


def _state_of(parts: VesselParts, vessel: Vessel, after: Vessel) -> VesselParts:
    """The parts after treatment: the same where the triangles are, so that a bulged cap is one."""
    if np.array_equal(vessel.surface.triangles, after.surface.triangles):
        return parts._replace(surface=Surface(after.surface.points, parts.surface.triangles))
    return vessel_parts(after.surface, parts.tree, after.faces, parts.units)


def _holes(segment: Segment) -> Iterator[Caution]:
    """Openings of the wall that were closed."""
    for face in segment.faces:
        if face.name.split("_")[0] == HOLE:
            x, y, z = face.center.tolist()
            width = 2 * float(np.sqrt(face.area / np.pi))
            yield Caution("hole", {"diameter_mm": width, "name": face.name}, (x, y, z))


def _dead_ends(segment: Segment, parts: VesselParts) -> Iterator[Caution]:
    """Branches that are kept and have no outlet, because the surface ends round there."""
    tree = parts.tree
    lumen = ClosedSurface(segment.surface.points, segment.surface.triangles)
    caps = [face for face in segment.faces if face.kind != "wall"]
    for tip in (*tree.leaves, *tree.roots):
        beside = tree.points[tree.neighbors.of(tip)[0]]
        inward = tree.points[tip] + 0.5 * (beside - tree.points[tip])
        x, y, z = tree.points[tip].tolist()
        is_open = any(
            np.linalg.norm(face.center - tree.points[tip]) < 2 * np.sqrt(face.area / np.pi)
            for face in caps
        )
        if not is_open and lumen.contains(inward[None])[0]:
            yield Caution("dead-end", {}, (x, y, z))


def _sound(segment: Segment, name: str) -> Segment:
    found = check_surface(segment.surface)
    if found.passed and found.is_watertight:
        return segment
    raise DeploymentError(
        f"{name}: expected one that is watertight and sound. {found.sentence()} Move its ends, or "
        "look at the vessel with sdfstent check."
    )
