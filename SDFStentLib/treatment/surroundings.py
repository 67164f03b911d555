"""What a stent does to its surroundings: branches, neighbors, contact with the wall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import NamedFaces
from ..measure import (
    Apposition,
    AxisStations,
    BranchWays,
    DiameterProfile,
    ExtendedAxis,
    NeighborLumen,
    NeighborStations,
    NeighborWay,
    Ostium,
    VesselStates,
    apposition,
    axis_stations,
    end_ways,
    find_ostia,
    measured_after,
    measured_once,
    moved_wall,
    open_at_ends,
    profile_around,
)
from ..validation import Floats

PROFILE_SPACING = 1.0
"""Distance of the stations at which diameters are measured, mm."""


class Surroundings(NamedTuple):
    """Of one stent."""

    stations: AxisStations
    """Along it and beyond its ends; measured"""
    before: DiameterProfile
    """before any stent,"""
    after: DiameterProfile
    """and after all of them."""
    branches: tuple[Ostium, ...]
    """Proximal to distal."""
    neighbors: tuple[NeighborLumen, ...]
    """Those whose wall has moved: beyond both ends, then branches by the names of their ostia."""
    apposition: Apposition
    """Contact with the wall after treatment."""


def surroundings(
    states: VesselStates,
    axis: ExtendedAxis,
    radius: Callable[[Floats], Floats],
    centerline: Centerline | None,
    faces: NamedFaces | None,
) -> Surroundings:
    """The lumen along a stent, and what it did to its surroundings.

    Parameters
    ----------
    states : VesselStates
    axis : ExtendedAxis
        Of the stent, in the vessel as it found it.
    radius : callable
        Gives its radius, mm, at arc lengths (n,) of its axis.
    centerline : Centerline or None
        As the stent found it. Without it branches are found, and followed through their lumen.
    faces : NamedFaces or None
        By which branches are named.
    """
    ostia = find_ostia(states.found, axis, faces)
    branches, into = _named_as_in_tree(ostia, BranchWays(states.found, axis, centerline))
    along, beside = (
        axis_stations(axis, PROFILE_SPACING),
        NeighborStations(states, [*end_ways(axis), *into]),
    )
    # Many stations together are measured in little more time than few.
    points = np.concatenate([along.points, beside.points])
    directions = np.concatenate([along.directions, beside.directions])
    # A cap that the stent has bulged is no wall either.
    wall = open_at_ends(states.native, along.points)
    before = measured_once(states.native, points, directions, wall)
    after = measured_after(before, moved_wall(states.native, states.final), states.final, wall)
    own, rest = slice(len(along.points)), slice(len(along.points), None)
    return Surroundings(
        along,
        profile_around(states.native, along, before.at(own)),
        profile_around(states.final, along, after.at(own)),
        branches,
        beside.lumens(before.at(rest), after.at(rest)),
        apposition(states.final, axis.of_stent, radius),
    )


def _named_as_in_tree(
    ostia: Sequence[Ostium], ways: BranchWays
) -> tuple[tuple[Ostium, ...], list[NeighborWay]]:
    """Branches without name by their number on the centerline, and the ways into all of them."""
    named, into = [], []
    for ostium in ostia:
        way = ways.into(ostium)
        if way is not None and ways.centerline is not None and not ostium.face_ids:
            ostium = replace(ostium, name=f"branch {ways.number(way)}")
        if way is not None:
            into.append(NeighborWay(ostium.name, way))
        named.append(ostium)
    return tuple(named), into
