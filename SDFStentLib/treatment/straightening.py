"""Limits that the vessel sets to smoothing and straightening a stent's axis.

An axis that is moved leaves the middle of a bent lumen. Nearer to the wall than the facets are long
it pushes their corners apart to both sides, and outside of the lumen it pushes the wall inward: the
lumen would become narrower. So the axis goes where it shall only as long as it keeps away, from the
wall and, where its ends move apart as it becomes straight, from the ends of the vessel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np

from ..cautions import Caution
from ..centerline import Centerline
from ..deformation import DeploymentSettings
from ..geometry import Line, Surface, smoothed_line
from ..lumen import LocalSurface, VesselInside
from ..stent import (
    Placement,
    Stent,
    StentAxis,
    moved_axis,
    placement_points,
    stent_axis,
    straight_way,
    turned_way,
)
from ..validation import Floats, InputError, Points, as_place, place_words
from .profile import with_profile


def check_in_lumen(
    inside: VesselInside, placement: Placement | None, centerline: Centerline
) -> None:
    """Refuse points outside of a vessel; those within the inscribed sphere need no look.

    Raises
    ------
    InputError
        A point of the placement is outside, and not on the wall.
    """
    for name, point in placement_points(placement):
        place = centerline.project(point)
        if place.distance < place.inscribed_radius:  # False where it is unknown
            continue
        if beyond := inside.beyond(point):
            raise InputError(
                f"{name}: expected a point in the lumen, got {place_words(point)}",
                place=as_place(point),
                end=f", which is {place.distance:.1f} mm from the centerline and {beyond:.1f} mm "
                "outside of the wall; move it into the vessel.",
            )


KEPT = 0.5
"""Share of its distance from the wall that the axis keeps, or of the stent's radius if less."""

SPACING = 1.0
"""The distance of the places of the axis that are looked at, mm."""

ROUNDS = 64
"""Steps toward the goal. Each is proven to stay in the lumen, so that stopping early is safe."""

NOTICEABLE = 1e-3
"""Share, of a way or of a radius, below which a difference does not count."""


class AxisChange(NamedTuple):
    """Smoothing and straightening of a stent's axis."""

    straightening_fraction: float = 0.0
    """Share by which each piece turns to the direction of the chord: 0 as it is, 1 straight."""
    smoothing_length: float = 0.0
    """The length as for `smoothed_line`, mm; before it is straightened."""

    @classmethod
    def of(cls, straightening_fraction: float, settings: DeploymentSettings) -> AxisChange:
        """Change that a plan and its settings ask for."""
        return cls(straightening_fraction, settings.axis_smoothing)


NONE = AxisChange()


def axis_in_vessel(
    stent: Stent,
    centerline: Centerline | None,
    vessel: Surface | VesselInside,
    change: AxisChange = NONE,
    *,
    lies_on: StentAxis | None = None,
) -> StentAxis:
    """The axis of a stent, smoothed and straightened as asked for, as far as the vessel permits.

    Parameters and errors as for `stent_axis`; a warning says where less than asked for was used.
    The vessel is given as its lumen where many axes are asked for. `InputError` for points of the
    placement outside of it.
    """
    lumen = vessel if isinstance(vessel, VesselInside) else VesselInside(vessel)
    axis = stent_axis(stent, centerline, lies_on=lies_on)
    if centerline is not None:
        check_in_lumen(lumen, stent.placement, centerline)
    # An earlier stent's has been moved already.
    if change.smoothing_length and lies_on is None:
        axis = _smoothed(axis, stent, lumen, change.smoothing_length)
    if change.straightening_fraction and lies_on is None:
        axis = _straightened(axis, stent, lumen, change.straightening_fraction)
    return with_profile(axis, stent, lumen.surface)


class Way(Protocol):
    """Motion of the points of an axis; `TurnedWay` is one."""

    @property
    def line(self) -> Line:
        """The line before it moves."""

    @property
    def longest(self) -> Floats:
        """(n,) longest distance each point goes, mm; at a fraction of the way no more than that of
        it."""

    def at(self, fraction: float) -> Line:
        """The axis at a fraction of the way, 0 to 1."""


class StraightLines(NamedTuple):
    """The way of every point straight to its goal."""

    line: Line
    goal: Line

    @property
    def longest(self) -> Floats:
        """(n,) mm."""
        return np.asarray(np.linalg.norm(self.goal.points - self.line.points, axis=1))

    def at(self, fraction: float) -> Line:
        """The points there."""
        start, goal = self.line.points, self.goal.points
        points = (1 - fraction) * start + fraction * goal
        is_same = (start == goal).all(axis=1)
        points[is_same] = start[is_same]
        return Line(points)


class Permitted(NamedTuple):
    """The part of a way that keeps an axis off the wall."""

    fraction: float
    """Part of the way that is gone, at most the one asked for."""
    place: Floats
    """(3,) place of the axis then that is nearest to its limit, mm."""


class _Told(NamedTuple):
    kind: str
    """The kind of the warning where less of the way is gone."""
    fraction: float
    """Part of the way that is asked for."""
    stent_radius: float


def _smoothed(
    axis: StentAxis, stent: Stent, lumen: VesselInside, smoothing_length: float
) -> StentAxis:
    """An axis made smooth as far as possible.

    A stent that has a length keeps it, as one that is straightened. One that goes from end to end,
    of a curve or between two places, goes from end to end of the smooth line and is as long as it.
    """
    goal = smoothed_line(axis.line, smoothing_length)
    told = _Told("smoothed-less", 1.0, stent.radius)
    if stent.length is None:
        way = StraightLines(axis.line, goal)
        found = permitted(way, stent.radius, lumen.surface, 1.0)
        return _as_long_as_it_lies(_moved(axis, way, found, told))
    steps = np.diff(goal.points, axis=0)
    return _turned(axis, stent, lumen, told, lambda keeps: turned_way(axis.line, steps, keeps))


def _as_long_as_it_lies(axis: StentAxis) -> StentAxis:
    foreshortened = axis.prescribed_length / axis.nominal_length
    lies = axis.deployed_length
    return replace(axis, nominal_length=lies / foreshortened, prescribed_length=lies)


def _straightened(axis: StentAxis, stent: Stent, lumen: VesselInside, fraction: float) -> StentAxis:
    """An axis made straight as far as possible."""
    told = _Told("straightened-less", fraction, stent.radius)
    return _turned(axis, stent, lumen, told, lambda keeps: straight_way(axis.line, keeps))


def _turned(
    axis: StentAxis,
    stent: Stent,
    lumen: VesselInside,
    told: _Told,
    way_keeping: Callable[[str], Way],
) -> StentAxis:
    """An axis whose pieces have turned as far as possible.

    One that keeps its middle keeps an end instead where the other way round it would soon run into
    an end of the vessel.
    """
    kept = [stent.kept, *(("proximal", "distal") if stent.kept == "center" else ())]
    best: tuple[Way, Permitted] | None = None
    for keeps in kept:
        way = way_keeping(keeps)
        found = permitted(way, stent.radius, lumen.surface.closed, told.fraction)
        if best is None or found.fraction > best[1].fraction + NOTICEABLE:
            best = (way, found)
        if found.fraction > told.fraction - NOTICEABLE:
            break
    assert best is not None
    return _moved(axis, *best, told)


def _moved(native: StentAxis, way: Way, found: Permitted, told: _Told) -> StentAxis:
    axis = moved_axis(native, way.at(found.fraction), told.stent_radius)
    if found.fraction > told.fraction - NOTICEABLE:
        return axis
    fractions = {"fraction": found.fraction, "prescribed_fraction": told.fraction}
    limited = Caution(told.kind, fractions, as_place(found.place))
    return replace(axis, warnings=(*axis.warnings, limited))


def permitted(way: Way, radius: float, vessel: Surface, fraction: float) -> Permitted:
    """The part of a way that keeps the axis off the wall.

    The axis goes along by steps on which no place of it goes farther than the wall is away, less
    what the place has to keep; so it cannot pass through one.

    Parameters
    ----------
    way : Way
    radius : float
        Radius of the stent, mm.
    vessel : Surface
    fraction : float
        Share of the way that is asked for.
    """
    along = way.line.arc_lengths
    at = np.linspace(0, along[-1], len(way.line.resampled(SPACING)))
    longest = np.interp(at, along, way.longest)
    at = at[longest * fraction > NOTICEABLE * radius]
    longest = longest[longest * fraction > NOTICEABLE * radius]
    if not len(at):
        return Permitted(fraction, way.line.points[0])

    def places(done: float) -> Points:
        return np.stack([np.interp(at, along, one) for one in way.at(done).points.T], axis=1)

    surface = LocalSurface(vessel.points, vessel.triangles, places(0.0))
    distance = surface.distances(places(0.0))
    kept, used = KEPT * np.minimum(distance, radius), 0.0
    for _ in range(ROUNDS):
        room = np.maximum(distance - kept, 0)
        tightest = int((room / longest).argmin())
        used = min(used + float(room[tightest] / longest[tightest]), fraction)
        if used == fraction or room[tightest] < NOTICEABLE * radius:
            break
        distance = surface.distances(places(used))
    return Permitted(used, places(used)[tightest])
