"""Areas of many cross-sections at once, from the part of the surface round their centers.

The plain way cuts the surface plane by plane and follows every loop. Here all planes are cut
together, and a loop is a connected part of the graph of the cut edges: its area is a sum over its
pieces in whatever order. Where the edges do not join two by two, the plain way has to decide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import (
    across,
    bits,
    compacted,
    connected,
    dot,
    may_meet_box,
    product,
    used_points,
)
from ..validation import Flags, Floats, Indices, Points, Triangles
from .spheres import AROUND, some_corners
from .tolerances import AT_ONCE, PAIRS


class SectionAreas(NamedTuple):
    """Areas (n,), mm^2, infinite if no closed loop was found, and whether each of them is uncertain
    (n,)."""

    area: Floats
    is_doubtful: Flags


class SectionLoops(NamedTuple):
    """Sections as loops of crossed edges of a surface, to be followed while its points move.

    Attributes
    ----------
    station : (k,) array of int
        The section to which each crossing belongs, ascending.
    ends : (k, 2) array of int
        The points that the crossed edge joins.
    fraction : (k,) array
        Position of the crossing on the edge, from its first point to its second.
    following : (k,) array of int
        The next crossing on the loop.
    """

    station: Indices
    ends: Indices
    fraction: Floats
    following: Indices

    def areas(self, points: Points, centers: Points, normals: Points) -> Floats:
        """Areas (n,), mm^2, across their normals (n, 3), of the n loops where the points are now.

        A loop that is no longer flat counts as it is seen along its normal; 0 where there is none.
        """
        low, high = (points.take(column, axis=0) for column in self.ends.T)
        place = low + self.fraction[:, None] * (high - low) - centers.take(self.station, axis=0)
        x, y = np.einsum("nij,nj->in", across(normals).take(self.station, axis=0), place)
        swept = x * y.take(self.following) - x.take(self.following) * y
        return np.abs(np.bincount(self.station, swept, len(centers))) / 2


class _Cuts(NamedTuple):
    """The pieces of all sections: from node to node, each node a cut edge of one station.

    Attributes
    ----------
    flat : (k, 2) array
        Coordinates of the nodes in the planes of their stations, from there, mm.
    station : (k,) array
        Stations of the nodes, ascending.
    start, end : (s,) arrays
        Nodes of the pieces.
    ends : (k, 2) array
        Points of the edge at which each node is,
    fraction : (k,) array
        and where on it.
    """

    flat: Floats
    station: Indices
    start: Indices
    end: Indices
    ends: Indices
    fraction: Floats


def section_areas(
    points: Points, triangles: Triangles, centers: Points, normals: Points
) -> SectionAreas:
    """Area of the smallest closed loop round every center, without islands in it.

    It is looked for in the part of the surface near a few, then near all, then in the whole: a loop
    inside of another one is never farther away.

    Parameters
    ----------
    points, triangles : (k, 3) and (m, 3) arrays
    centers, normals : (n, 3) arrays
        Centers of the planes, and their normals of unit length.

    Returns
    -------
    SectionAreas
        Doubtful where edges of more than two triangles or unlike windings are cut.
    """
    found = SectionAreas(np.full(len(centers), np.inf), np.zeros(len(centers), dtype=bool))
    if not len(centers):
        return found
    near = _near(points, triangles, centers)
    for first in range(0, len(centers), AT_ONCE):
        few = slice(first, first + AT_ONCE)
        wall = _near(*near, centers[few])
        found.area[few], found.is_doubtful[few] = _in_blocks(*wall, centers[few], normals[few])
    for wall in (near, (points, triangles)):
        left = np.flatnonzero(np.isinf(found.area))
        found.area[left], found.is_doubtful[left] = _in_blocks(*wall, centers[left], normals[left])
    return found


def section_loops(
    points: Points, triangles: Triangles, centers: Points, normals: Points
) -> SectionLoops:
    """The loops of `section_areas` as far as they lie near their centers.

    No loop for a section that reaches far into other vessels, or that is doubtful.
    """
    found, nodes = [], 0
    for first in range(0, len(centers), AT_ONCE):
        few = slice(first, first + AT_ONCE)
        wall = _near_triangles(points, triangles, centers[few])
        kept = used_points(wall)
        near = points.take(kept, axis=0), np.searchsorted(kept, wall)
        cuts = _cuts(*near, centers[few], normals[few])
        loops = _loops(cuts, min(AT_ONCE, len(centers) - first))
        own = np.flatnonzero(np.isin(loops.label, loops.smallest[~loops.is_doubtful]))
        following = np.empty(len(cuts.station), dtype=np.int64)
        following[cuts.start] = cuts.end
        number = np.searchsorted(own, following[own])
        found.append(
            SectionLoops(
                first + cuts.station[own], kept[cuts.ends[own]], cuts.fraction[own], nodes + number
            )
        )
        nodes += len(own)
    return SectionLoops(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _in_blocks(
    points: Points, triangles: Triangles, centers: Points, normals: Points
) -> SectionAreas:
    result = SectionAreas(np.full(len(centers), np.inf), np.zeros(len(centers), dtype=bool))
    size = max(1, PAIRS // max(1, len(points) + len(triangles)))
    for first in range(0, len(centers) if len(triangles) else 0, size):
        block = slice(first, first + size)
        found = _areas(points, triangles, centers[block], normals[block])
        result.area[block], result.is_doubtful[block] = found
    return result


def _near(points: Points, triangles: Triangles, centers: Points) -> tuple[Points, Triangles]:
    """The part of the surface in the box round the centers that holds their sections, mostly."""
    return compacted(points, _near_triangles(points, triangles, centers))


def _near_triangles(points: Points, triangles: Triangles, centers: Points) -> Triangles:
    some = some_corners(points, triangles) if len(triangles) else points
    squared = dot(centers, centers)[:, None] - 2 * product(centers, some.T) + dot(some, some)
    margin = AROUND * np.sqrt(max(float(squared.min(axis=1, initial=np.inf).max()), 0.0))
    low, high = centers.min(axis=0) - margin, centers.max(axis=0) + margin
    return triangles.compress(may_meet_box(points, triangles, low, high), axis=0)


class _Loops(NamedTuple):
    """Connected parts of the pieces, by node (k,), and the smallest by station (n,)."""

    label: Indices
    smallest: Indices
    """Smallest closed part that holds the station; -1 for none."""
    area: Floats
    """Area of that part, mm^2; infinite for none."""
    is_doubtful: Flags


def _areas(points: Points, triangles: Triangles, centers: Points, normals: Points) -> SectionAreas:
    loops = _loops(_cuts(points, triangles, centers, normals), len(centers))
    return SectionAreas(loops.area, loops.is_doubtful)


def _loops(cuts: _Cuts, count: int) -> _Loops:
    nodes = len(cuts.station)
    starts, ends = np.bincount(cuts.start, minlength=nodes), np.bincount(cuts.end, minlength=nodes)
    is_doubtful = np.zeros(count, dtype=bool)
    is_doubtful[cuts.station[(starts > 1) | (ends > 1)]] = True

    loops, label = connected(nodes, cuts.start, cuts.end)
    is_closed = np.ones(loops, dtype=bool)
    is_closed[label[starts != ends]] = False
    (x, y), (next_x, next_y) = (cuts.flat.take(ends, axis=0).T for ends in cuts[2:4])
    of_loop = label[cuts.start]
    area = np.abs(np.bincount(of_loop, x * next_y - y * next_x, loops)) / 2
    crosses = np.flatnonzero((y > 0) != (next_y > 0))
    along = x[crosses] - y[crosses] * (next_x - x)[crosses] / (next_y - y)[crosses]
    rays = np.bincount(of_loop[crosses[along > 0]], minlength=loops)

    station = np.zeros(loops, dtype=np.int64)
    station[label] = cuts.station
    holds = np.flatnonzero(is_closed & (rays % 2 == 1))
    # What is written last stays: the smallest.
    holds = holds[np.argsort(-area[holds], kind="stable")]
    smallest, least = np.full(count, -1), np.full(count, np.inf)
    smallest[station[holds]], least[station[holds]] = holds, area[holds]
    others = is_closed & (area > 0) & (area < least[station]) & np.isfinite(least[station])
    others[holds] = False
    if others.any():
        least -= _islands(cuts, label, np.flatnonzero(others), smallest, station, area)
    return _Loops(label, smallest, least, is_doubtful)


def _islands(
    cuts: _Cuts, label: Indices, loops: Indices, around: Indices, station: Indices, area: Floats
) -> Floats:
    """Area (n,), mm^2, that closed loops take from the one `around` (n,) each station."""
    taken = np.zeros(len(around))
    first = np.full(int(label.max()) + 1, -1)
    first[label[::-1]] = np.arange(len(label))[::-1]
    pieces = np.argsort(label[cuts.start], kind="stable")
    bounds = np.searchsorted(label[cuts.start][pieces], np.arange(len(first) + 1))
    inside: dict[int, list[int]] = {}
    for loop in loops:
        place, outer = cuts.flat[first[loop]], around[station[loop]]
        if _holds(cuts, pieces[bounds[outer] : bounds[outer + 1]], place):
            inside.setdefault(int(station[loop]), []).append(int(loop))
    for at, found in inside.items():
        # What is hollow counts once, by its outside.
        found.sort(key=lambda loop: -area[loop])
        kept: list[int] = []
        for loop in found:
            place = cuts.flat[first[loop]]
            if not any(_holds(cuts, pieces[bounds[k] : bounds[k + 1]], place) for k in kept):
                kept.append(loop)
        taken[at] = area[kept].sum()
    return taken


def _holds(cuts: _Cuts, pieces: Indices, place: Floats) -> bool:
    """Whether a loop of some pieces contains a place (2,) of its plane: a ray crosses it an odd
    number of times."""
    (x, y), (next_x, next_y) = (
        cuts.flat.take(ends[pieces], axis=0).T - place[:, None] for ends in (cuts.start, cuts.end)
    )
    crosses = (y > 0) != (next_y > 0)
    along = x[crosses] - y[crosses] * (next_x - x)[crosses] / (next_y - y)[crosses]
    return bool(np.count_nonzero(along > 0) % 2)


def _cuts(points: Points, triangles: Triangles, centers: Points, normals: Points) -> _Cuts:
    """Cuts as of `plane_section`: a point in a plane is above it, so that nothing is cut twice."""
    heights = product(normals, points.T) - dot(normals, centers)[:, None]
    is_above = heights >= 0
    # A bit for each station: eight are compared at once.
    above = bits(is_above)
    one, other, third = (above.take(corner, axis=1) for corner in triangles.T)
    is_cut = (one ^ other) | (other ^ third)
    cut = np.flatnonzero(is_cut.any(axis=0))
    each = np.unpackbits(is_cut.take(cut, axis=1), axis=0, count=len(centers)).view(bool)
    station, row = np.divmod(np.flatnonzero(each), len(cut))
    rows = triangles.take(cut.take(row), axis=0)
    # Every cut triangle has one side that goes down through its plane and one that goes up.
    over = is_above[station[:, None], rows]
    following = over[:, [1, 2, 0]]
    down, up = np.argmax(over > following, axis=1), np.argmax(over < following, axis=1)
    sides = np.r_[_sides(rows, down)[:, ::-1], _sides(rows, up)]
    crossing = (np.r_[station, station] * len(points) + sides[:, 0]) * len(points) + sides[:, 1]
    crossed, node = np.unique(crossing, return_inverse=True)
    crossed, high = np.divmod(crossed, len(points))
    at, low = np.divmod(crossed, len(points))
    below = heights[at, low]
    fraction = below / (below - heights[at, high])
    from_low = points.take(low, axis=0)
    offset = from_low + fraction[:, None] * (points.take(high, axis=0) - from_low)
    offset -= centers.take(at, axis=0)
    flat = np.einsum("nij,nj->ni", across(normals).take(at, axis=0), offset)
    start, end = node.reshape(2, -1)
    return _Cuts(flat, at, start, end, np.column_stack([low, high]), fraction)


def _sides(triangles: Triangles, first: Indices) -> Triangles:
    """The side (m, 2) of every triangle that starts at this corner."""
    rows = np.arange(len(triangles))
    return np.stack([triangles[rows, first], triangles[rows, (first + 1) % 3]], axis=1)
