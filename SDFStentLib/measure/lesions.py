"""Lesions of a vessel tree: where it is narrower than the healthy vessel beside it.

A lesion is a property of the vessel. No stent takes part in what it measures, nor does the place
at which the centerline begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..centerline import Centerline
from ..geometry import Surface, arc_lengths, as_surface, closest_points, tangents
from ..validation import (
    InputError,
    Points,
    Triangles,
    as_point,
    as_points,
)
from .inscribed import inscribed_spheres
from .lesion_measuring import as_place, measured, median_area
from .lesion_value import HealthyPlace, Lesion
from .narrowings import Narrowing, narrowings
from .tree_lumen import branch_lumens
from .vessel_runs import VesselRun, vessel_runs

Floats = NDArray[np.float64]


def find_lesions(surface: Surface, centerline: Centerline) -> tuple[Lesion, ...]:
    """All lesions of a vessel tree, the tightest first.

    Parameters
    ----------
    surface : Surface
        Before any stent; open or closed.
    centerline : Centerline
        Its root does not matter, but for what is called proximal.

    Returns
    -------
    tuple of Lesion
        Each once. Narrowings of less than `narrowings.SMALLEST_DEGREE`, those beyond which the
        vessel is not wider again by `narrowings.SMALLEST_RECOVERY`, and those within a radius of
        an in- or outlet are none.

    Raises
    ------
    InputError
        No surface, or a centerline outside of it.
    """
    points, triangles = as_surface(surface).points, surface.triangles
    found = [
        _Found(_lesion(points, triangles, run, narrow), _junctions(run, narrow))
        for run in vessel_runs(branch_lumens(points, triangles, centerline))
        for narrow in narrowings(run)
    ]
    found.sort(key=lambda one: -one.lesion.percent_diameter)
    kept: list[_Found] = []
    for one in found:
        if not any(one.continues(other) for other in kept):
            kept.append(one)
    return tuple(one.lesion for one in kept)


def lesion_after(lesion: Lesion, surface: Surface) -> Lesion:
    """The same part of the vessel against the same reference on another surface.

    Parameters
    ----------
    lesion : Lesion
        As found before treatment.
    surface : Surface
        After it.

    Returns
    -------
    Lesion
        With the residual stenosis; negative percentages where it is wider than the reference.

    Raises
    ------
    InputError
        No surface.
    """
    return measured(lesion, as_surface(surface).points, surface.triangles)


def lesions_within(lesions: Sequence[Lesion], axis_points: ArrayLike) -> tuple[Lesion, ...]:
    """Those of the lesions whose narrowest place a stent along an axis would cover.

    Parameters
    ----------
    lesions : sequence of Lesion
    axis_points : array_like, shape (n, 3)
        The axis of the stent from end to end, mm.

    Raises
    ------
    InputError
        Fewer than two points.
    """
    axis = as_points(axis_points, "axis", minimum=2)
    if not lesions:
        return ()
    found = closest_points(axis, np.array([lesion.point for lesion in lesions]))
    radii = np.array([lesion.minimum_diameter / 2 for lesion in lesions])
    # Of a place beyond an end the nearest point is that end; the axis runs inside the sphere.
    total = float(arc_lengths(axis)[-1])
    is_on = (found.arc_lengths > 0) & (found.arc_lengths < total) & (found.distances <= radii)
    return tuple(lesion for lesion, chosen in zip(lesions, is_on, strict=True) if chosen)


def lesion_against(
    lesion: Lesion, places: Sequence[ArrayLike], surface: Surface, centerline: Centerline
) -> Lesion:
    """The same lesion against healthy vessel that the user marked.

    Parameters
    ----------
    lesion : Lesion
    places : sequence of one or two (3,) arrays
        Near the centerline where the vessel is healthy, mm. Two, one on each side: the reference
        tapers from one to the other. One: it is the reference everywhere.
    surface : Surface
        In which the lesion was found.
    centerline : Centerline

    Raises
    ------
    InputError
        No place or more than two, two on the same side, or a place beside the vessel.
    """
    points, triangles = as_surface(surface).points, surface.triangles
    if len(places) not in (1, 2):
        raise InputError(f"reference: expected one or two marked places, got {len(places)}.")
    marked = [_marked(lesion, place, points, triangles, centerline) for place in places]
    proximal = [place for place in marked if place.arc_length <= lesion.arc_length]
    distal = [place for place in marked if place.arc_length > lesion.arc_length]
    if max(len(proximal), len(distal)) == 2:
        raise InputError(
            "reference: expected a place on each side of the lesion, got two "
            f"{'proximal' if proximal else 'distal'} of it; mark one of them only."
        )
    sides = (proximal[0] if proximal else None, distal[0] if distal else None)
    changed = replace(
        lesion,
        proximal=sides[0],
        distal=sides[1],
        reference=_words(sides, by="the vessel marked", other=""),
    )
    return measured(changed, points, triangles)


class _Found(NamedTuple):
    """A lesion, and the junctions to which it reaches: with whether as part of the trunk."""

    lesion: Lesion
    junctions: dict[int, bool]

    def continues(self, other: _Found) -> bool:
        """Whether it is the part of another lesion that lies beyond a junction."""
        shared = self.junctions.keys() & other.junctions.keys()
        return any(self.junctions[node] != other.junctions[node] for node in shared)


def _junctions(run: VesselRun, narrow: Narrowing) -> dict[int, bool]:
    reached = (narrow.start <= run.along[0], narrow.end >= run.along[-1])
    return {
        end.node: end.is_trunk
        for end, is_reached in zip(run.ends, reached, strict=True)
        if end.is_junction and is_reached
    }


def _lesion(points: Points, triangles: Triangles, run: VesselRun, narrow: Narrowing) -> Lesion:
    """A narrowing with its areas, on finer stations, from the root's side on."""
    edges = np.interp([narrow.start, narrow.end], run.along, run.from_root)
    way = 1 if edges[0] <= edges[1] else -1
    inner = run.points[(run.along > narrow.start) & (run.along < narrow.end)]
    line = np.vstack([_at(run, narrow.start), inner, _at(run, narrow.end)])[::way]
    reference = narrow.reference
    origin = edges[0] - way * narrow.start
    sides = [
        _healthy(points, triangles, run, along, diameter, origin + way * along)
        for along, diameter in (
            (reference.before, reference.before_diameter),
            (reference.after, reference.after_diameter),
        )
    ][::way]
    unknown = float("nan")
    at = int(np.abs(run.along - narrow.narrowest).argmin())
    return measured(
        Lesion(
            branch=int(run.branch[at]),
            branch_arc_length=float(run.branch_along[at]),
            arc_length=unknown,
            start=float(min(edges)),
            end=float(min(edges) + narrow.end - narrow.start),
            point=(unknown, unknown, unknown),
            minimum_diameter=unknown,
            reference_diameter=unknown,
            percent_diameter=unknown,
            minimum_area=unknown,
            reference_area=unknown,
            percent_area=unknown,
            proximal=sides[0],
            distal=sides[1],
            reference=_words(sides),
            line=line,
        ),
        points,
        triangles,
    )


def _healthy(
    points: Points,
    triangles: Triangles,
    run: VesselRun,
    along: float,
    diameter: float,
    arc_length: float,
) -> HealthyPlace | None:
    """The place of a reference; its area is the median over half a diameter, as the diameter."""
    if np.isnan(along):
        return None
    distance = np.abs(run.along - along)
    near = np.flatnonzero(distance <= max(diameter / 4, float(distance.min())))
    line, directions = run.points[near], tangents(run.points)[near]
    area = median_area(points, triangles, line, directions)
    return HealthyPlace(as_place(_at(run, along)), float(arc_length), float(diameter), area)


def _marked(
    lesion: Lesion, place: ArrayLike, points: Points, triangles: Triangles, centerline: Centerline
) -> HealthyPlace:
    """Healthy vessel where the user says so, measured on the way from the lesion."""
    location = centerline.project(as_point(place, "reference"))
    path = centerline.path(lesion.line[len(lesion.line) // 2], location)
    along = arc_lengths(path.points)
    near = path.points[along >= along[-1] - 1.0]
    station = location.point[None]
    direction = tangents(near)[-1:]
    radius = float(inscribed_spheres(points, triangles, station, direction).radii[0])
    if not location.distance <= radius:
        raise InputError(
            f"reference: expected a place inside of the vessel, got one {location.distance:.1f} mm "
            "from the centerline; mark one in the lumen."
        )
    area = median_area(points, triangles, station, direction)
    return HealthyPlace(as_place(location.point), location.arc_length, 2 * radius, area)


def _words(
    sides: Sequence[HealthyPlace | None],
    by: str = "healthy vessel",
    other: str = "; on its other side is a junction",
) -> str:
    """The reference in words."""
    told = [
        f"{name} of it ({side.diameter:.1f} mm)"
        for name, side in zip(("proximal", "distal"), sides, strict=True)
        if side is not None
    ]
    if len(told) == 2:
        return f"{by} {told[0]} and {told[1]}, tapering from one to the other"
    return f"{by} {told[0]}{other}"


def _at(run: VesselRun, along: float) -> Floats:
    return np.array([np.interp(along, run.along, column) for column in run.points.T])
