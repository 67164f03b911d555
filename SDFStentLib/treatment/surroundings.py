"""Surroundings of a stent: branches, neighbors, contact with the wall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..centerline import Centerline
from ..geometry import Line, NamedFaces, Surface
from ..lumen import (
    AxisStations,
    DiameterProfile,
    ExtendedAxis,
    Stations,
    axis_stations,
    extended_axis,
    in_caps,
    measured_after,
    measured_once,
    moved_wall,
    profile_around,
)
from ..validation import Flags, Floats
from ..vessel import (
    Apposition,
    BranchWays,
    NeighborLumen,
    NeighborStations,
    NeighborWay,
    Ostium,
    VesselStates,
    apposition,
    branch_of,
    end_ways,
    find_ostia,
)

PROFILE_SPACING = 1.0
"""Distance of the stations at which diameters are measured, mm."""


class Survey(NamedTuple):
    """The surroundings of one stent as it finds them, and the lumen before any."""

    axis: ExtendedAxis
    """Its axis in the vessel as it finds that."""
    branches: tuple[Ostium, ...]
    """Ostia, proximal to distal."""
    ways: tuple[NeighborWay, ...]
    """Ways beyond both ends, then into branches."""
    stations: AxisStations
    """Stations along the stent and beyond its ends; measured"""
    measured: Stations
    """before any stent,"""
    before: DiameterProfile
    """with the diameters there."""
    caps: Flags
    """(m,) the triangles that are in flat caps."""


class TreeNames(NamedTuple):
    """The names by which side branches are found and called."""

    centerline: Centerline | None
    """The centerline as a stent finds it. Without it branches are found, and followed through their
    lumen."""
    faces: NamedFaces | None
    """Faces by which branches are named."""
    given: Sequence[str | None]
    """Names by the user, by branch of the centerline; they come first."""

    def is_same(self, other: TreeNames) -> bool:
        """Whether these are the very same things."""
        same = self.centerline is other.centerline and self.faces is other.faces
        return same and self.given == other.given


_known: WeakKeyDictionary[Surface, tuple[bytes, TreeNames, Survey]] = WeakKeyDictionary()
"""The last survey of a vessel without stents, with the axis and the names that it is of."""


class Surroundings(NamedTuple):
    """The surroundings of one stent, when all have been deployed."""

    after: DiameterProfile
    """The lumen after treatment at the stations of its survey."""
    neighbors: tuple[NeighborLumen, ...]
    """Neighbors whose wall has moved: beyond both ends, then branches by the names of their
    ostia."""
    apposition: Apposition
    """Contact with the wall after treatment."""


def surveyed_once(native: Surface, axis: Line, names: TreeNames) -> Survey:
    """`surveyed` of a first stent; not again where the last one of the vessel had the same axis.

    So it is where another diameter is tried: nothing about a stent but its axis matters.
    """
    last, rows = _known.get(native), axis.points.tobytes()
    if last is not None and last[0] == rows and last[1].is_same(names):
        return last[2]
    survey = surveyed(native, native, axis, names)
    _known[native] = rows, names, survey
    return survey


def surveyed(native: Surface, found: Surface, axis: Line, names: TreeNames) -> Survey:
    """Survey of a stent's surroundings before it is deployed.

    Parameters
    ----------
    native, found : Surface
        The vessel before any stent, and as this one finds it; the same triangles.
    axis : Line
        Axis of the stent.
    names : TreeNames
    """
    centerline, faces, given = names
    extended = extended_axis(found, axis, centerline)
    branches = find_ostia(found, extended, faces, centerline)
    ways = BranchWays(found, extended, centerline).into(branches)
    if given and centerline is not None:
        named = [_given_name(way, centerline, given) for way in ways]
        branches = tuple(
            replace(one, name=name or one.name) for one, name in zip(branches, named, strict=True)
        )
    into = [
        NeighborWay(ostium.name, way)
        for ostium, way in zip(branches, ways, strict=True)
        if way is not None
    ]
    along = axis_stations(extended, PROFILE_SPACING)
    caps = in_caps(native)
    measured = measured_once(native, along.points, along.directions)
    before = profile_around(native, along, measured, caps)
    return Survey(extended, branches, (*end_ways(extended), *into), along, measured, before, caps)


def _given_name(way: Line | None, tree: Centerline, given: Sequence[str | None]) -> str | None:
    """Name by the user of the vessel that a way leads into."""
    return None if way is None else given[branch_of(tree, tree.project(way.points[0]))]


def lumen_around(native: Surface, axis: Line, centerline: Centerline | None) -> DiameterProfile:
    """The lumen along a stent's axis and beyond its ends, before any stent."""
    along = axis_stations(extended_axis(native, axis, centerline), PROFILE_SPACING)
    caps = in_caps(native)
    measured = measured_once(native, along.points, along.directions)
    return profile_around(native, along, measured, caps)


def surroundings(
    survey: Survey, states: VesselStates, radius: Callable[[Floats], Floats]
) -> Surroundings:
    """The lumen along a stent, and what it did to its surroundings.

    Parameters
    ----------
    survey : Survey
        Survey of this stent.
    states : VesselStates
    radius : callable
        Gives its radius, mm, at arc lengths (n,) of its axis.
    """
    along, caps = survey.stations, survey.caps
    beside = NeighborStations(states, survey.ways)
    inside = np.flatnonzero(~beside.outside[0])
    places = beside.points[inside], beside.directions[inside]
    known = measured_once(states.native, *places).among(inside, beside.points, beside.directions)
    # Many stations together are measured in little more time than few.
    before = survey.measured.followed_by(known)
    # A cap that the stent has bulged is no wall either.
    moved = moved_wall(states.native, states.final)
    own, rest = slice(len(along.points)), slice(len(along.points), None)
    outside = np.r_[np.zeros(len(along.points), dtype=bool), beside.outside[1]]
    after = measured_after(before, moved, states.final, caps, outside)
    return Surroundings(
        profile_around(states.final, along, after.at(own), caps),
        beside.lumens(before.at(rest), after.at(rest)),
        apposition(states.final, survey.axis.of_stent, radius),
    )
