"""Width of a vessel where its lines end, and lines that begin at its wall put into its middle.

What a network extraction traces from one hole, or a hand draws from a rim, reaches the middle of
the vessel only farther on. Measured along itself it shows narrowings that are not there.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..cautions import Caution
from ..centerline import USUAL, WIDER, Centerline, distal_ends, station_spacing
from ..geometry import Line, Surface, SurfaceIndex, faces_at, norm
from ..validation import Flags, Floats, Points
from .caps import RIM, in_caps
from .spheres import InscribedSpheres, LocalSurface, StationSearch, Until
from .tolerances import AT_ONCE, CENTERED, END_REACH, FARTHEST, ROUNDING, TOLERANCE
from .wall_map import corner_tree

_STATIONS = 24
"""Number of stations along a line from its end on: some four to six diameters."""

IN_MIDDLE = 0.1
"""Radii from the middle of a vessel within which a line has come there, unless it keeps to it no
better farther on; one that ends less than `CENTERED` from the wall is moved so."""


class EndStations(NamedTuple):
    """Stations (n,) along a line from its end inward, and the largest spheres there."""

    points: Points
    along: Floats
    spheres: InscribedSpheres
    is_known: Flags
    """Whether the sphere is one of the lumen, and does not touch what closes the end."""

    @property
    def width(self) -> float:
        """The usual diameter, mm; NaN if none is known."""
        known = 2 * self.spheres.radii[self.is_known]
        return float(np.quantile(known, USUAL)) if len(known) else float("nan")

    def apart_from(self, cap: SurfaceIndex | None) -> EndStations:
        """Stations with spheres that touch a cap as not known: a line may leave the cap at a
        slant."""
        centers, radii = self.spheres
        is_known = self.is_known.copy()
        is_known[is_known] = END_REACH * radii[is_known] <= _away(cap, centers[is_known])
        return self._replace(is_known=is_known)


def _away(surface: SurfaceIndex | None, places: Points) -> Floats:
    """Distance of places (n, 3) from a surface, mm; infinite without a surface."""
    if surface is None:
        return np.full(len(places), np.inf)
    return surface.distances(places).distance


class LineEnds:
    """Measures a vessel along lines from their ends inward.

    Parameters
    ----------
    surface : Surface
    """

    def __init__(self, surface: Surface) -> None:
        self._surface = surface
        self._corners = corner_tree(surface)

    def widths(self, ways: Sequence[Points]) -> Floats:
        """Widths (k,) of the vessel at some ends, mm: `Widths` for `Centerline.from_lines`.

        Those that cannot be the widest are not measured: corners of the wall are no nearer to a
        place than the wall is.
        """
        lines = [self.line(way) for way in ways]
        bounds = np.array([2 * float(self._away(line.points).max()) for line in lines])
        found = np.full(len(lines), np.nan)
        order = np.argsort(-bounds, kind="stable")
        for first in range(0, len(lines), AT_ONCE):
            some = order[first : first + AT_ONCE]
            if WIDER * bounds[some[0]] < np.nanmax([0.0, *found]):
                break
            measured = self.stations([lines[number] for number in some.tolist()])
            found[some] = [one.width for one in measured]
        return found

    def may_begin_at_wall(self, line: Line) -> bool:
        """Whether corners of the wall, of no cap across a `line`, lie beside where it begins."""
        begin = line.points[0]
        radius = float(self._away(line.points).max())
        near = self._corners.query_ball_point(begin, CENTERED * radius)
        near.append(int(self._corners.query(begin)[1]))
        inward = line.at([min(2 * radius, line.length)])[0] - begin
        along = self._surface.vertex_normals[near] @ inward / np.linalg.norm(inward)
        return bool((np.abs(along) < RIM).any())

    def around(self, place: Points, radius: float) -> tuple[SurfaceIndex | None, ...]:
        """The wall near a place (3,) in a vessel of a radius, and its flat caps there."""
        points, triangles = self._surface.points, self._surface.triangles
        is_near = np.zeros(len(points), dtype=bool)
        is_near[self._corners.query_ball_point(place, FARTHEST * radius)] = True
        near = np.flatnonzero(faces_at(is_near, triangles))
        is_cap = self._is_cap.take(near)
        parts = (triangles.take(near.compress(own), axis=0) for own in (~is_cap, is_cap))
        return tuple(SurfaceIndex(points, part) if len(part) else None for part in parts)

    @cached_property
    def _is_cap(self) -> Flags:
        return in_caps(self._surface)

    def line(self, way: Points) -> Line:
        """Stations along a way (k, 3) from its end inward, but within the sphere of the junction to
        which it leads."""
        line = Line(way)
        spacing = min(station_spacing(self._away(way)), line.length)
        at = spacing * np.arange(1 + min(_STATIONS, int(line.length / spacing * (1 + ROUNDING))))
        places = line.at(at)
        own = norm(places - way[-1]) >= self._away(way[-1:])
        count = len(at) if own.all() else int(np.argmin(own))
        return Line(places[: count if count > 1 else len(at)])

    def stations(self, lines: Sequence[Line]) -> list[EndStations]:
        """The stations of some `line`, measured."""
        if not len(lines):
            return []
        places = np.concatenate([line.points for line in lines])
        directions = np.concatenate([line.directions for line in lines])
        wall = LocalSurface.of(self._surface, places)
        centers, radii = StationSearch(wall, places, directions, Until(TOLERANCE)).rough
        is_in = self._surface.contains(places)
        found, first = [], 0
        for line in lines:
            own = slice(first, first + len(line))
            first += len(line)
            to_end = norm(line.points - line.points[0])
            is_known = is_in[own] & (radii[own] > 0) & (END_REACH * radii[own] <= to_end)
            spheres = InscribedSpheres(centers[own], radii[own])
            found.append(EndStations(line.points, line.arc_lengths, spheres, is_known))
        return found

    def _away(self, places: Points) -> Floats:
        return np.asarray(self._corners.query(places)[0])


def with_ends_in_middle(
    surface: Surface, tree: Centerline
) -> tuple[Centerline, tuple[Caution, ...]]:
    """A centerline whose lines begin and end in the middle of the vessel, and what was moved.

    From an end that lies at the wall up to where its line reaches the middle, points are put on the
    straight way on which the middle goes on from there, at the same steps.
    """
    last = {int(branch[-1]): branch[::-1] for branch in tree.branches}
    ways = [last[end] for end in distal_ends(tree.parent, tree.loops).tolist()]
    ways += [branch for branch in tree.branches if tree.parent[branch[0]] < 0]
    known = LineEnds(surface)
    ways = [way for way in ways if np.ptp(tree.arc_length[way]) > 0]
    begun = [(way, known.line(tree.points[way])) for way in ways]
    begun = [(way, line) for way, line in begun if known.may_begin_at_wall(line)]
    measured = known.stations([line for _, line in begun])
    points, radius, moved = tree.points.copy(), tree.inscribed_radius.copy(), []
    for (way, _), stations in zip(begun, measured, strict=True):
        if not stations.is_known.any():
            continue
        begin = tree.points[way[0]]
        wall, cap = known.around(begin, stations.width / 2)
        reached = _where_in_middle(stations.apart_from(cap))
        if reached is None or _away(wall, begin[None])[0] > CENTERED * reached.radius:
            continue
        at = np.abs(tree.arc_length[way] - tree.arc_length[way[0]])
        which = way[at < reached.along]
        points[which] = _put(points[which], at[: len(which)], reached)
        radius[which] = reached.radius if np.isfinite(radius).any() else np.nan
        numbers = dict(zip("xyz", begin.tolist(), strict=True)) | {"length_mm": reached.along}
        moved.append(Caution("begins-at-wall", numbers))
    if not moved:
        return tree, ()
    return Centerline(points, radius, tree.parent, tree.loops), (_told(moved),)


def _told(moved: Sequence[Caution]) -> Caution:
    """One caution on all ends that were moved, with the place of the one moved farthest."""
    farthest = max(moved, key=lambda one: one.numbers["length_mm"])
    if len(moved) == 1:
        return farthest
    return Caution("begin-at-wall", {"count": len(moved), **farthest.numbers})


def loop_cautions(tree: Centerline) -> tuple[Caution, ...]:
    """The cautions that lines of a centerline meet again, with the places."""
    places = tree.points[tree.loops[:, 1]].tolist()
    return tuple(Caution("loop", dict(zip("xyz", place, strict=True))) for place in places)


class _Reached(NamedTuple):
    """Place where a line that began beside the middle of its vessel reaches it."""

    along: float
    """Arc length from the end of the line, mm,"""
    middle: Points
    """(3,) place of the middle there, mm."""
    inward: Points
    """(3,) unit direction of the vessel from there on."""
    radius: float


def _where_in_middle(stations: EndStations) -> _Reached | None:
    """The place where a line reaches the middle; None if it begins in the middle, or does not reach
    it."""
    centers, radii = stations.spheres
    known = np.flatnonzero(stations.is_known)
    if len(known) < 2:
        return None
    beside = norm(stations.points[known] - centers[known]) / radii[known]
    usual = min(max(IN_MIDDLE, float(np.median(beside))), CENTERED)
    first = int(known[np.argmax(beside <= usual)])
    beyond = known[stations.along[known] >= stations.along[first] + 2 * radii[first]]
    other = int(beyond[0]) if len(beyond) else int(known[-1])
    way = centers[other] - centers[first]
    if first == 0 or other <= first or not way.any():
        return None
    inward = way / np.linalg.norm(way)
    offset = stations.points[: first + 1] - centers[first]
    aside = norm(offset - (offset @ inward)[:, None] * inward)
    if aside.max() <= CENTERED * radii[first] or offset[0] @ inward >= 0:
        return None
    return _Reached(float(stations.along[first]), centers[first], inward, float(radii[first]))


def _put(points: Points, along: Floats, reached: _Reached) -> Points:
    """Points (n, 3) from an end on, at arc lengths (n,), on the way on which the middle goes on."""
    begin = float((points[0] - reached.middle) @ reached.inward)
    return reached.middle + begin * (1 - along / reached.along)[:, None] * reached.inward
