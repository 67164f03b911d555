"""Effect of half a voxel on the numbers of a vessel that was made of a scan.

The wall is moved in and out along its normals by half a voxel. Lesions are measured again on both
walls, and stents deployed in both: no formula gives the error of a number.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..flow import FlowAnswer
from ..geometry import oriented_triangles, vertex_normals
from ..lumen import inscribed_spheres
from ..plan import Case, CaseOutcome, TreatedCase, flow_answer, flow_model
from ..treatment import Vessel
from ..validation import Floats, InputError, Points
from ..vessel import Lesion, lesions_after

Span = tuple[float, float]
"""The smallest and the largest value; NaN where one of them is not known."""


class Ranged(NamedTuple):
    """A quantity of one thing, before treatment and after it."""

    name: str
    """Name of the thing, such as "lesion 1"."""
    before: Span
    after: Span | None = None


class VoxelRange(NamedTuple):
    """Ranges of numbers while the wall is anywhere within half a voxel of where it was found."""

    half: float
    """Half a voxel, mm."""
    minima: tuple[Ranged, ...]
    """Minimum inscribed diameters of lesions, mm,"""
    stenoses: tuple[Ranged, ...]
    """and their stenoses by diameter, percent."""
    lumens: tuple[Ranged, ...] = ()
    """Narrowest inscribed diameters of stents that lie in the vessel in the end, mm."""
    drops: tuple[Ranged, ...] = ()
    """Recovered pressure drops at the mean flow, mmHg; not known where half a voxel closes an
    outlet."""

    def of_lesions(self, numbers: Iterable[int]) -> VoxelRange:
        """What is told of some of the lesions, by number from 1, and all of the rest."""
        rows = [number - 1 for number in numbers]
        minima, stenoses = ([kind[row] for row in rows] for kind in (self.minima, self.stenoses))
        return self._replace(minima=tuple(minima), stenoses=tuple(stenoses))


def voxel_range(vessel: Vessel, half: float) -> VoxelRange:
    """The range of a vessel's lesions.

    Parameters
    ----------
    vessel : Vessel
    half : float
        Half a voxel, mm.
    """
    found = vessel.lesions or ()
    walls = [found, *(wall.lesions for wall in _moved(vessel, half))]
    return VoxelRange(
        half,
        _ranged(_named(found), [[one.minimum_diameter for one in wall] for wall in walls]),
        _ranged(_named(found), [[one.percent_diameter for one in wall] for wall in walls]),
    )


def treated_voxel_range(
    case: Case, treated: CaseOutcome, half: float, flow: FlowAnswer | None = None
) -> VoxelRange:
    """The range of a case that was treated: it is treated on both walls, too.

    Parameters
    ----------
    case : Case
    treated : CaseOutcome
    half : float
        Half a voxel, mm.
    flow : FlowAnswer, optional
        Pressures and flows before and after, where these are known.

    Raises
    ------
    InputError
        A lumen where a stent lies that is no wider than a voxel.
    InputError, DeploymentError
        As `Treatment`, for a wall that was moved.
    """
    walls = []
    for one in moved_cases(case, treated, half):
        treatment = one.case.treatment().result
        walls.append(TreatedCase(one.case.vessel, treatment, one.lesions))
    return range_of_walls(case, treated, walls, half, flow)


class MovedCase(NamedTuple):
    """A case in a vessel whose wall was moved along its normals, its lesions measured there."""

    case: Case
    lesions: tuple[Lesion, ...]


def moved_cases(case: Case, treated: CaseOutcome, half: float) -> tuple[MovedCase, ...]:
    """The case with the same stents at the same places and the wall moved in, and out.

    Parameters and errors as of `treated_voxel_range`.
    """
    narrowest = min(one.before.minimum for one in treated.told.final_stents)
    if narrowest <= 2 * half:
        raise InputError(
            f"voxel range: expected a lumen wider than a voxel, {2 * half:.2f} mm, where a stent "
            f"lies, got {narrowest:.2f} mm: half a voxel closes it; leave the range out."
        )
    settings = replace(case.plan.settings, certify=False)
    plan = replace(case.plan.in_frame(case.frame), stents=case.stents, settings=settings)
    return tuple(
        MovedCase(replace(case, vessel=wall.vessel, plan=plan), wall.lesions)
        for wall in _moved(case.vessel, half)
    )


def range_of_walls(
    case: Case,
    treated: CaseOutcome,
    moved: Sequence[TreatedCase],
    half: float,
    flow: FlowAnswer | None = None,
) -> VoxelRange:
    """The range of a treated case by what came of its `moved_cases`; parameters as of
    `treated_voxel_range`."""
    walls: list[CaseOutcome] = [treated, *moved]
    names = _named(treated.lesions or ())
    befores = [[one.before for one in wall.lesions or ()] for wall in walls]
    afters = [[one.after for one in wall.lesions or ()] for wall in walls]
    lumens = [wall.told.final_stents for wall in walls]
    drops = [] if flow is None else [_drops(case, flow, treated, wall) for wall in walls]
    return VoxelRange(
        half,
        _ranged(
            names,
            [[one.minimum_diameter for one in wall] for wall in befores],
            [[one.minimum_diameter for one in wall] for wall in afters],
        ),
        _ranged(
            names,
            [[one.percent_diameter for one in wall] for wall in befores],
            [[one.percent_diameter for one in wall] for wall in afters],
        ),
        _ranged(
            [f"stent {one.row}" for one in lumens[0]],
            [[one.before.minimum for one in wall] for wall in lumens],
            [[one.after.minimum for one in wall] for wall in lumens],
        ),
        _ranged(
            () if flow is None else flow.parts,
            [before for before, _ in drops],
            [after for _, after in drops],
        ),
    )


def _named(lesions: Sequence[object]) -> list[str]:
    return [f"lesion {number}" for number in range(1, len(lesions) + 1)]


class _Wall(NamedTuple):
    """A vessel with its wall moved along its normals, its lesions measured there."""

    vessel: Vessel
    lesions: tuple[Lesion, ...]


def _moved(vessel: Vessel, half: float) -> list[_Wall]:
    """The wall moved in, and out, by half a voxel, mm."""
    surface, native = vessel.surface, vessel.lesions or ()
    inside = None if vessel.centerline is None else vessel.centerline.points
    outward = oriented_triangles(surface.points, surface.triangles, inside)
    ways = half * vertex_normals(surface.points, outward)
    walls = []
    for side in (-1, 1):
        moved = replace(vessel, surface=surface.with_points(surface.points + side * ways))
        found = _moved_lesions(native, vessel, moved)
        if side < 0:
            found = tuple(map(_closed, found, native, [half] * len(found)))
        walls.append(_Wall(moved, found))
    return walls


def _closed(lesion: Lesion, native: Lesion, half: float) -> Lesion:
    """A lesion without lumen where walls that come nearer by half a voxel meet: beyond that they
    would have gone through each other."""
    if not native.minimum_diameter <= 2 * half:
        return lesion
    return replace(lesion, minimum_diameter=0.0, percent_diameter=100.0)


def _drops(
    case: Case, flow: FlowAnswer, treated: CaseOutcome, wall: CaseOutcome
) -> tuple[list[float], list[float]]:
    """Pressure drops over the parts of a flow, mmHg, before and after."""
    answer = flow
    if wall is not treated:
        try:
            model = flow_model(wall.vessel, flow.known, case.frame)
        except InputError:  # all else is known there, too
            unknown = [math.nan] * len(flow.parts)
            return unknown, unknown
        answer = flow_answer(model, wall.vessel, wall.treatment, case.vessel.lesions)
    assert answer.after is not None
    before, after = (
        [one.recovered.value for one in state["mean"].drops]
        for state in (answer.before, answer.after)
    )
    return before, after


def _moved_lesions(lesions: Sequence[Lesion], vessel: Vessel, moved: Vessel) -> tuple[Lesion, ...]:
    """Lesions on a wall that was moved, against healthy vessel at the same places."""
    places = [side for one in lesions for side in (one.proximal, one.distal) if side is not None]
    if not places:
        return tuple(lesions_after(lesions, moved.surface))
    centers = np.array([place.point for place in places])
    ways = _directions(vessel, centers)
    inner, outer = (
        2 * inscribed_spheres(one.surface.points, one.surface.triangles, centers, ways).radii
        for one in (vessel, moved)
    )
    wider = dict(zip(map(id, places), (outer - inner).tolist(), strict=True))
    return tuple(lesions_after([_with_reference(one, wider) for one in lesions], moved.surface))


def _directions(vessel: Vessel, places: Points) -> Points:
    """Directions (n, 3) of the vessel's lines at places (n, 3) on them."""
    lines = list(vessel.branches.values())
    nearest = [line.nearest(places) for line in lines]
    which = np.argmin([one.distances for one in nearest], axis=0)
    return np.array(
        [lines[k].directions[nearest[k].segments[n]] for n, k in enumerate(which.tolist())]
    )


def _with_reference(lesion: Lesion, wider: dict[int, float]) -> Lesion:
    """A lesion whose reference is wider by what the vessel is at its healthy places, mm."""
    sides = [side for side in (lesion.proximal, lesion.distal) if side is not None]
    if not sides:
        return lesion
    at, by = [side.arc_length for side in sides], [wider[id(side)] for side in sides]

    def more(along: Floats) -> Floats:
        return np.asarray(np.interp(along, at, by))

    healthy = lesion.healthy + more(lesion.start + lesion.line.arc_lengths)
    return replace(lesion, healthy=healthy)


def _ranged(
    names: Sequence[str],
    befores: Sequence[Sequence[float]],
    afters: Sequence[Sequence[float]] | None = None,
) -> tuple[Ranged, ...]:
    """The spans of every thing over all walls, each with a value for it."""
    first = [_span(one) for one in zip(*befores, strict=True)]
    if afters is None:
        return tuple(map(Ranged, names, first))
    return tuple(map(Ranged, names, first, (_span(one) for one in zip(*afters, strict=True))))


def _span(values: Iterable[float]) -> Span:
    found = np.array(list(values))
    return float(found.min()), float(found.max())
