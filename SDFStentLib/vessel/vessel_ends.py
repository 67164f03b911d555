"""Ends of a vessel: the open ends of its wall and the flat caps of its in- and outlets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface, boundary_edges, compacted, component_labels, norm, places_in_plane
from ..lumen import are_ends, caps_of, spot
from ..validation import Indices, InputError, Points, as_point

BESIDE = 10.0
"""A place that names an end is so near to it or to the wall, mm: a click beside it, no other
unit."""

BESIDE_TIP = 2.0
"""Distance of a line's tip from an end, in the end's radii, within which it leads there; one that
begins well inside does not."""


class VesselEnd(NamedTuple):
    """An end of a vessel, open or closed by a flat cap."""

    center: Points
    """(3,) of its rim, mm."""
    radius: float
    """The radius of the circle with the area of the end, mm."""
    rim: Indices
    """Edges (k, 2) of the surface around it, in the direction of the wall's faces."""
    faces: Indices
    """Triangles of its cap; none of an open end."""
    across: Points
    """(3,) unit vector across its plane."""


class LineSeeds(NamedTuple):
    """The points of a surface between which centerlines are looked for."""

    surface: Surface
    """Closed surface, with a point in the middle of every end."""
    inlet: int
    """Its point at the proximal end,"""
    outlets: tuple[int, ...]
    """and the points at the other ends."""


def vessel_ends(surface: Surface) -> list[VesselEnd]:
    """Open ends and flat caps of a vessel, the largest first.

    A rounded end has no rim and is not found.

    Parameters
    ----------
    surface : Surface
        mm; closed, open, or both at different ends.
    """
    return _ends_and_holes(surface)[0]


def _ends_and_holes(surface: Surface) -> tuple[list[VesselEnd], list[VesselEnd]]:
    """The ends of a vessel, and where else its wall is open, the largest first."""
    triangles = surface.wound_triangles
    cap_of = np.full(len(triangles), -1)
    for number, cap in enumerate(caps_of(surface)):
        cap_of[cap.faces] = number
    capped, shape = np.flatnonzero(cap_of >= 0), surface.topology
    if not (shape.is_watertight and shape.is_orientable):
        rims = boundary_edges(triangles[cap_of < 0])
    elif not len(capped):
        return [], []
    else:
        # Where nothing else ends the faces beside a cap run along its rim the other way.
        rims = boundary_edges(triangles[capped])[:, ::-1]
    used, corners = np.unique(rims, return_inverse=True)
    corners = corners.reshape(-1, 2)
    loop = component_labels(len(used), corners[:, 0], corners[:, 1])[corners[:, 0]]
    loop_of = np.full(len(surface.points), -1)
    loop_of[rims[:, 0]] = loop
    loops, found = loop_of[triangles[capped]], []
    for number in np.unique(loop):
        is_at_rim = (loops == number).any(axis=1)
        faces = capped[np.isin(cap_of[capped], cap_of[capped[is_at_rim]])]
        found.append(_end(surface.points, rims[loop == number], faces))
    # A cap is known to be an end; a hole may be one in the wall.
    holes = [end for end in found if not len(end.faces)]
    spots = [spot(surface.points, end.rim, end.across, end.faces, end.center) for end in holes]
    is_end = are_ends(surface, spots).tolist()
    ends = [end for end in found if len(end.faces)]
    ends += [end for end, is_own in zip(holes, is_end, strict=True) if is_own]
    holes = [hole for hole, is_own in zip(holes, is_end, strict=True) if not is_own]
    apart: list[VesselEnd] = []
    for end in sorted(ends, key=lambda end: -end.radius):
        # A rough cap falls to pieces; those within another one are no ends of their own.
        if all(np.linalg.norm(end.center - other.center) > other.radius for other in apart):
            apart.append(end)
    return apart, sorted(holes, key=lambda hole: -hole.radius)


def ends_without_line(ends: Sequence[VesselEnd], tree: Centerline) -> int:
    """The number of a vessel's ends at which no line of its centerline ends or goes out."""
    tips = tree.points[[*tree.roots, *tree.leaves]]
    below = np.flatnonzero(tree.parent >= 0)
    lines = tree.points[tree.parent[below]], tree.points[below]
    return sum(
        norm(tips - end.center).min() > BESIDE_TIP * end.radius and not _is_crossed(end, *lines)
        for end in ends
    )


def _is_crossed(end: VesselEnd, starts: Points, stops: Points) -> bool:
    """Whether one of these pieces (k, 3) of lines goes through an end."""
    places = places_in_plane(starts, stops, end.center, end.across)
    return bool((norm(places - end.center) < end.radius).any())


class KnownEnds(NamedTuple):
    """The ends of a surface that are open, flat or named."""

    surface: Surface
    """Closed surface, with a point in the middle of every open and flat end."""
    inlet: int | None
    """Its point at the proximal end; None where that may only be a round one."""
    outlets: tuple[int, ...]
    """Indices of the points at the others."""
    end_count: int
    """Number of open or flat ends: their middles are its last points."""
    inlet_radius: float
    """The radius of the proximal end, mm; infinite for one that is named, which no wider one is."""
    radii: tuple[float, ...]
    """Radii of the proximal end, unless there is none, and of the others, mm; 0 for a place."""
    holes: tuple[VesselEnd, ...]
    """Where the wall is open besides, the widest first."""


def line_seeds(
    surface: Surface, inlet: Points | None = None, outlets: Sequence[Points] = ()
) -> LineSeeds:
    """Seeds of a vessel's centerlines; parameters as for `known_ends`.

    Raises
    ------
    InputError
        There is no end, only one, or as of `known_ends`.
    """
    found = known_ends(surface, inlet, outlets)
    if found.inlet is None or not (found.end_count or found.outlets):
        raise InputError(
            "surface: expected open ends or flat caps, found neither; cut the ends flat, "
            "or name the inlet and every outlet."
        )
    if not found.outlets:
        raise InputError(
            "surface: expected two open ends or flat caps or more, found one; name an outlet."
        )
    return LineSeeds(found.surface, found.inlet, found.outlets)


def known_ends(
    surface: Surface, inlet: Points | None = None, outlets: Sequence[Points] = ()
) -> KnownEnds:
    """Ends of a vessel, by its surface or by name.

    Parameters
    ----------
    surface : Surface
        mm.
    inlet : (3,) array, optional
        Names the proximal end, mm; by default it is the largest.
    outlets : sequence of (3,) arrays
        Name the other ends; all that are found by default. A place away from every open end and
        flat cap stands for the point of the wall beside it, such as the tip of a rounded end.
        A hole in the wall is an end where a place in it names it.

    Raises
    ------
    InputError
        An end is named that is not there or was named before.
    """
    ends, holes = _ends_and_holes(surface)
    first = None if inlet is None else as_point(inlet, "inlet")
    others = [as_point(outlet, f"outlet {number}") for number, outlet in enumerate(outlets, 1)]
    places = np.array([*([] if first is None else [first]), *others]).reshape(-1, 3)
    is_named = [bool((norm(places - hole.center) < hole.radius).any()) for hole in holes]
    ends += [hole for hole, is_own in zip(holes, is_named, strict=True) if is_own]
    holes = [hole for hole, is_own in zip(holes, is_named, strict=True) if not is_own]
    closed = _closed(surface, ends)
    centers = (len(closed.points) - len(ends) + np.arange(len(ends))).tolist()
    start, radius = (centers[0], ends[0].radius) if ends else (None, 0.0)
    if first is not None:
        start, radius = _named(closed, ends, first, "inlet"), float("inf")
    targets = [
        _named(closed, ends, outlet, f"outlet {number}") for number, outlet in enumerate(others, 1)
    ] or [center for center in centers if center != start]
    if len({start, *targets}) != 1 + len(targets):
        raise InputError("ends: expected each to be named once; two places name the same end.")
    radius_of = dict(zip(centers, (end.radius for end in ends), strict=True))
    known = [radius_of.get(one, 0.0) for one in (start, *targets) if one is not None]
    return KnownEnds(closed, start, tuple(targets), len(ends), radius, tuple(known), tuple(holes))


def _named(closed: Surface, ends: list[VesselEnd], place: Points, name: str) -> int:
    """Index of a closed surface's point for a place; ends have its last points."""
    away = [float(np.linalg.norm(end.center - place)) for end in ends]
    number = away.index(min(away)) if ends else 0
    if ends and away[number] < max(BESIDE, 2 * ends[number].radius):
        return len(closed.points) - len(ends) + number
    distances = norm(closed.points - place)
    if distances.min() > BESIDE:
        raise InputError(
            f"{name}: expected a place within {BESIDE:g} mm of the surface, got "
            f"one {distances.min():.1f} mm away; check its coordinates and unit."
        )
    return int(np.argmin(distances))


def _closed(surface: Surface, ends: list[VesselEnd]) -> Surface:
    """The surface with a fan of triangles over every end; their centers are its last points."""
    is_wall = np.ones(len(surface.triangles), dtype=bool)
    fans = []
    for number, end in enumerate(ends):
        is_wall[end.faces] = False
        center = np.full(len(end.rim), len(surface.points) + number)
        fans.append(np.column_stack([end.rim[:, 1], end.rim[:, 0], center]))
    points = np.vstack([surface.points, *(end.center for end in ends)])
    return Surface(*compacted(points, np.vstack([surface.wound_triangles[is_wall], *fans])))


def _end(points: Points, rim: Indices, faces: Indices) -> VesselEnd:
    start, stop = points[rim[:, 0]], points[rim[:, 1]]
    weights = norm(stop - start)[:, None]
    center = (weights * (start + stop)).sum(axis=0) / (2 * weights.sum())
    across = np.cross(start - center, stop - center).sum(axis=0)
    twice = float(np.linalg.norm(across))
    radius = float(np.sqrt(twice / (2 * np.pi)))
    return VesselEnd(center, radius, rim, faces, across / max(twice, np.finfo(float).tiny))
