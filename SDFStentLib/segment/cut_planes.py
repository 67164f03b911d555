"""Planes across a vessel that meet only this vessel, however oblique its parent vessel is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..centerline import Location
from ..geometry import Line, SectionAround, across, norm, product, section_around, used_points
from ..validation import Floats, InputError, Points, read_only
from ..vessel import VesselParts

SPACING = 0.5
"""Spacing of the points that stand for the centerline, mm."""

OFF = 1.5
"""Largest distance of a place in a vessel from its centerline, in radii."""

ALONG = 1.5
"""Distance along the tree, in distances from the axis to the wall, within which a section belongs
to its place: where its border lies nearer to the centerline elsewhere, it runs into another
vessel."""

TANGENT = 1.5
"""Length, in distances to the wall, of the parabola whose direction is that of a vessel."""

STEP = 0.25
"""Spacing of the places that are tried for a plane, in the same unit."""

SAME = 1e-6
"""Distance, mm, up to which a point lies on a path."""


@dataclass(frozen=True)
class CutPlane:
    """Plane across a vessel that cuts off a segment."""

    name: str
    """Name of the branch that it cuts."""
    origin: Floats
    """(3,) place on the centerline, mm."""
    normal: Floats
    """(3,) unit vector into the segment."""
    is_closed: bool = False
    """Whether it cuts off a side branch, so that the opening becomes wall."""

    def __post_init__(self) -> None:
        for name in ("origin", "normal"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


class TriedPlace(NamedTuple):
    """A place on a line along which a plane is searched."""

    along: float
    """Distance from the beginning of the line, mm."""
    place: Points
    direction: Floats


class PlaneFinder:
    """A vessel, prepared for being asked for its sections again and again."""

    def __init__(self, vessel: VesselParts, treated: VesselParts | None = None) -> None:
        """`treated` is the same vessel after treatment, which planes have to meet as well."""
        from scipy.spatial import cKDTree

        self.vessel = vessel
        self.treated = None if treated is None else PlaneFinder(treated)
        self.points, self.triangles = vessel.surface.points, vessel.surface.triangles
        self.is_cap = np.isin(vessel.ids, list(vessel.caps))
        self.axis = vessel.tree.resampled(SPACING)
        self.wall = cKDTree(self.points[used_points(self.triangles[~self.is_cap])])
        self.reach = self.wall.query(self.axis.points)[0]

    def check_inside(self, way: Line, place: Location, word: str) -> None:
        """Raise `InputError` where a way starts from a place outside of the vessel."""
        start = way.points[0]
        section = section_around(self.points, self.triangles, start, self.direction(way))
        # The tip of a centerline may lie beyond its vessel.
        wall = float(self.wall.query(start)[0])
        radius = wall if section is None else float(np.sqrt(section.area / np.pi))
        if place.distance > OFF * radius:
            raise InputError(
                f"segment {word}: expected a place in the vessel, got one {place.distance:.1f} mm "
                f"from its centerline at {self.vessel.said(start)}, where it has a radius of "
                f"{radius:.1f} mm; check the place, its unit (mm, cm) and its frame (RAS, LPS)."
            )

    def has_parted(self, place: Points, way: Line) -> bool:
        """Whether a branch, at a place, lies beside the vessel through which a way runs."""
        return bool(way.nearest(place[None]).distances[0] > self.wall.query(place)[0])

    def direction(self, way: Line) -> Floats:
        """Unit direction (3,) of a line at its first point."""
        span = min(TANGENT * float(self.wall.query(way.points[0])[0]), way.length)
        at = np.linspace(0.0, max(span, SAME), 9)
        parabola = np.polyfit(at, way.at(at), 2)
        return np.asarray(parabola[1] / np.linalg.norm(parabola[1]))

    def fault(self, origin: Points, normal: Floats) -> str:
        """The reason why a plane does not meet one vessel alone; empty where it does."""
        found = self.section(origin, normal)
        return found if isinstance(found, str) else ""

    def section(self, origin: Points, normal: Floats) -> SectionAround | str:
        """The section of a plane with one vessel alone, or the reason why there is none."""
        section = section_around(self.points, self.triangles, origin, normal)
        if section is None:
            return "does not go round its centerline"
        if not section.is_closed:
            return "runs through an open end"
        if self.is_cap[section.triangles].any():
            return "runs through an end of the vessel"
        if self._is_crossed_elsewhere(section, origin, normal):
            return "cuts a branch of it, too"
        if self._is_elsewhere(section, origin):
            return "runs into another vessel"
        fault = "" if self.treated is None else self.treated.fault(origin, normal)
        return f"{fault} after treatment" if fault else section

    def steps(self, line: Line) -> Iterator[TriedPlace]:
        """Places along a line, with the direction of the line there."""
        along, at = 0.0, line.arc_lengths
        # Ends: goes on by a tenth of the spacing at least.
        while along < at[-1] - SAME:
            place = line.at([along])[0]
            rest = np.vstack([place, line.points[at > along]])
            yield TriedPlace(along, place, self.direction(Line(rest)))
            along += max(STEP * float(self.wall.query(place)[0]), SPACING / 10)

    def _is_crossed_elsewhere(self, section: SectionAround, origin: Points, normal: Floats) -> bool:
        """Whether the centerline passes through the section at a place other than the origin."""
        ends = np.flatnonzero(self.axis.parent >= 0)
        heights = product(self.axis.points - origin, normal)
        ends = ends[(heights[self.axis.parent[ends]] < 0) != (heights[ends] < 0)]
        starts = self.axis.parent[ends]
        share = (heights[starts] / (heights[starts] - heights[ends]))[:, None]
        low, high = self.axis.points[starts], self.axis.points[ends]
        places = low + share * (high - low)
        away = places[norm(places - origin) > self.wall.query(origin)[0]]
        return _is_round(section, away, normal)

    def _is_elsewhere(self, section: SectionAround, origin: Points) -> bool:
        """Whether a part of the border lies nearer to the centerline far along the tree."""
        here = int(np.argmin(norm(self.axis.points - origin)))
        near = self._nearby(here, ALONG * float(self.wall.query(origin)[0]) + SPACING)
        rim = section.start
        own, other = np.full(len(rim), np.inf), np.full(len(rim), np.inf)
        width = float(norm(rim - origin).max())
        for index in np.flatnonzero(norm(self.axis.points - origin) < 3 * width):
            beside = norm(rim - self.axis.points[index]) - self.reach[index]
            best = own if near[index] else other
            np.minimum(best, beside, out=best)
        return bool((other < own - SPACING / 2).any())

    def _nearby(self, start: int, limit: float) -> Floats:
        """Whether each point of the axis is within a distance along the tree."""
        distance = np.full(len(self.axis.points), np.inf)
        distance[start], waiting = 0.0, [start]
        # Ends: in a tree a point is reached once.
        while waiting:
            point = waiting.pop()
            for other in self.axis.neighbors.of(point):
                step = float(np.linalg.norm(self.axis.points[other] - self.axis.points[point]))
                if np.isinf(distance[other]) and distance[point] + step <= limit:
                    distance[other] = distance[point] + step
                    waiting.append(int(other))
        return np.isfinite(distance)


def _is_round(section: SectionAround, places: Points, normal: Floats) -> bool:
    """Whether a section goes round one of some points (k, 3) of its plane."""
    plane = across(normal[None])[0].T
    starts, ends = ((rim - places[:, None]) @ plane for rim in (section.start, section.end))
    (x, y), (end_x, end_y) = np.moveaxis(starts, 2, 0), np.moveaxis(ends, 2, 0)
    angles = np.arctan2(x * end_y - y * end_x, x * end_x + y * end_y).sum(axis=1)
    return bool((np.abs(angles) > np.pi).any())
