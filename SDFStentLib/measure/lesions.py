"""Lesions of a vessel tree: where it is narrower than the healthy vessel beside it.

A lesion is a property of the vessel. No stent takes part in what it measures, nor does the place
at which the centerline begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..centerline import Centerline
from ..geometry import (
    NamedFaces,
    Surface,
    as_surface,
    checked_faces,
    closest_points,
    point_at,
    tangents,
)
from ..validation import Points, as_points
from .branch_names import branch_names
from .lesion_measuring import as_place, lesions_after, measured, median_area
from .lesion_value import HealthyPlace, Lesion, reference_words
from .narrowings import Narrowing, narrowings
from .tree_lumen import branch_lumens
from .vessel_runs import VesselRun, vessel_runs

Floats = NDArray[np.float64]

_ASLANT = 2.0
"""An axis that goes aslant meets the section within so many radii of its middle."""


def find_lesions(
    surface: Surface, centerline: Centerline, faces: NamedFaces | None = None
) -> tuple[Lesion, ...]:
    """All lesions of a vessel tree, the tightest first.

    Parameters
    ----------
    surface : Surface
        Before any stent; open or closed.
    centerline : Centerline
        Its root does not matter, but for what is called proximal.
    faces : NamedFaces, optional
        Of the surface; they name the branches.

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
    places = [
        (run, narrow)
        for run in vessel_runs(branch_lumens(as_surface(surface), centerline))
        for narrow in narrowings(run)
    ]
    names = branch_names(surface, centerline, checked_faces(faces, len(surface.triangles)))
    lesions = measured([_begun(surface, run, narrow, names) for run, narrow in places], surface)
    found = [
        _Found(lesion, _junctions(*place)) for lesion, place in zip(lesions, places, strict=True)
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
    return lesions_after([lesion], as_surface(surface))[0]


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
    return tuple(lesion for lesion in lesions if _passes(axis, lesion))


def _passes(axis: Points, lesion: Lesion) -> bool:
    """Whether an axis (n, 3) goes through a lesion's narrowest place, along its vessel.

    It runs inside the sphere there and crosses the section. At a junction an axis into another
    branch may run inside the sphere as well.
    """
    radius, at = lesion.minimum_diameter / 2, lesion.arc_length - lesion.start
    before, after = point_at(lesion.line, [at - radius, at + radius])
    heights = (axis - lesion.point) @ (after - before)
    crossed = np.flatnonzero((heights[1:] < 0) != (heights[:-1] < 0))
    share = heights[crossed] / (heights[crossed] - heights[crossed + 1])
    places = axis[crossed] + share[:, None] * (axis[crossed + 1] - axis[crossed])
    offsets = np.linalg.norm(places - lesion.point, axis=1)
    nearest = closest_points(axis, np.array([lesion.point])).distances[0]
    return bool(nearest <= radius and (offsets <= _ASLANT * radius).any())


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


def _begun(surface: Surface, run: VesselRun, narrow: Narrowing, names: Sequence[str]) -> Lesion:
    """A narrowing with its reference, and diameters along its line, from the root's side on."""
    edges = np.interp([narrow.start, narrow.end], run.along, run.from_root)
    way = 1 if edges[0] <= edges[1] else -1
    inner = (run.along > narrow.start) & (run.along < narrow.end)
    line = np.vstack([_at(run, narrow.start), run.points[inner], _at(run, narrow.end)])[::way]
    diameters = np.r_[np.nan, run.diameter[inner], np.nan][::way]
    reference = narrow.reference
    origin = edges[0] - way * narrow.start
    sides = [
        _healthy(surface, run, along, diameter, origin + way * along)
        for along, diameter in (
            (reference.before, reference.before_diameter),
            (reference.after, reference.after_diameter),
        )
    ][::way]
    unknown = float("nan")
    at = int(np.abs(run.along - narrow.narrowest).argmin())
    return Lesion(
        branch=int(run.branch[at]),
        branch_name=names[run.branch[at]],
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
        reference=reference_words(sides),
        line=line,
        diameters=diameters,
    )


def _healthy(
    surface: Surface, run: VesselRun, along: float, diameter: float, arc_length: float
) -> HealthyPlace | None:
    """The place of a reference; its area is the median over half a diameter, as the diameter."""
    if np.isnan(along):
        return None
    distance = np.abs(run.along - along)
    near = np.flatnonzero(distance <= max(diameter / 4, float(distance.min())))
    line, directions = run.points[near], tangents(run.points)[near]
    area = median_area(surface, line, directions)
    return HealthyPlace(as_place(_at(run, along)), float(arc_length), float(diameter), area)


def _at(run: VesselRun, along: float) -> Floats:
    return np.array([np.interp(along, run.along, column) for column in run.points.T])
