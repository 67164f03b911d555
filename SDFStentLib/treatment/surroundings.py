"""What a stent does to its surroundings: branches, neighbors, contact with the wall."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..centerline import Centerline
from ..geometry import NamedFaces
from ..measure import (
    Apposition,
    BranchWays,
    ExtendedAxis,
    NeighborLumen,
    NeighborWay,
    Ostium,
    VesselStates,
    apposition,
    end_ways,
    find_ostia,
    neighbor_lumens,
)


class Surroundings(NamedTuple):
    """Of one stent."""

    branches: tuple[Ostium, ...]
    """Proximal to distal."""
    neighbors: tuple[NeighborLumen, ...]
    """Those whose wall has moved: beyond both ends, then branches by the names of their ostia."""
    apposition: Apposition
    """Contact with the wall after treatment."""


def surroundings(
    states: VesselStates,
    axis: ExtendedAxis,
    radius: float,
    centerline: Centerline | None,
    faces: NamedFaces | None,
) -> Surroundings:
    """What a stent of some radius, mm, did to its surroundings.

    Parameters
    ----------
    states : VesselStates
    axis : ExtendedAxis
        Of the stent, in the vessel as it found it.
    radius : float
        mm.
    centerline : Centerline or None
        As the stent found it. Without it branches are found, and followed through their lumen.
    faces : NamedFaces or None
        By which branches are named.
    """
    ostia = find_ostia(states.found, axis, faces)
    ways = BranchWays(states.found, axis, centerline)
    branches, into = _named_as_in_tree(ostia, ways)
    return Surroundings(
        branches,
        neighbor_lumens(states, [*end_ways(axis), *into]),
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
