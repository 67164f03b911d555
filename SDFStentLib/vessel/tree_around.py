"""The part of a centerline round an axis, and the ways from the axis into it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from ..centerline import Centerline, Location, distal_ends, points_between
from ..geometry import Line, norm
from ..lumen import FINEST
from ..validation import Floats, Indices


def ends_around(tree: Centerline, start: Location, reach: float) -> set[int]:
    """Points where ways from a start end: leaves, roots, and the first junctions beyond the reach.

    Parameters
    ----------
    tree : Centerline
    start : Location
        On it.
    reach : float
        Length along the tree, mm; what begins within it is followed to its end.
    """
    at, branches = tree.arc_length, tree.branches
    begins, stops = (np.array([branch[k] for branch in branches]) for k in (0, -1))
    # Of both ends of the start's own branch, then of every one that begins within the reach.
    own = next(k for k, branch in enumerate(branches) if start.index in branch[1:])
    up, down = start.arc_length - at[begins[own]], at[stops[own]] - start.arc_length
    front = [(own, int(begins[own]), float(up)), (own, int(stops[own]), float(down))]
    found: set[int] = set()
    # Ends: never back, and the tree has no circle.
    while front:
        came_from, node, traveled = front.pop()
        onward = np.flatnonzero((begins == node) | (stops == node))
        onward = onward[onward != came_from]
        if traveled >= reach or not len(onward):
            found.add(node)
            continue
        for branch in onward.tolist():
            other = stops[branch] if begins[branch] == node else begins[branch]
            size = float(at[stops[branch]] - at[begins[branch]])
            front.append((branch, int(other), traveled + size))
    return found


def outlets_of(tree: Centerline) -> Indices:
    """Number (n,) of the vessel's ends that a tree's points lead to; limbs where they meet it."""
    ways = [tree.ancestry(end) for end in distal_ends(tree.parent, tree.loops).tolist()]
    every = np.concatenate([*ways, np.zeros(0, np.int64)])  # a limb may be all there is
    found: Indices = np.bincount(every, minlength=len(tree.points))
    for leaf, meeting in tree.loops.tolist():
        way = tree.ancestry(leaf)
        found[way[found[way] == 0]] = max(int(found[meeting]), 1)
    return found


def limbs_of(tree: Centerline) -> frozenset[int]:
    """The branches of a tree that end where they meet the vessel again."""
    ends = set(tree.loops[:, 0].tolist())
    return frozenset(n for n, nodes in enumerate(tree.branches) if int(nodes[-1]) in ends)


def place_of(tree: Centerline, index: int) -> Location:
    """A point of the tree as a place on it."""
    at, radius = float(tree.arc_length[index]), float(tree.inscribed_radius[index])
    if tree.parent[index] >= 0:
        return Location(tree.points[index], 0.0, index, 1.0, at, radius)
    return Location(tree.points[index], 0.0, tree.neighbors.of(index)[0], 0.0, at, radius)


def branch_of(tree: Centerline, place: Location) -> int:
    """The index of the branch of the centerline at a place."""
    above = int(tree.parent[place.index])
    return next(
        number
        for number, branch in enumerate(tree.branches)
        if place.index in branch and above in branch
    )


class LinesFromAxis:
    """The ways from both ends of an axis into a tree. They share most of their points.

    Parameters
    ----------
    tree : Centerline
    axis : Line
    reach : float
        Least length beyond each end of the axis, mm.
    beside : float, optional
        No more is asked for as the distance up to which they do not leave the axis, mm.
    """

    def __init__(self, tree: Centerline, axis: Line, reach: float, beside: float = np.inf) -> None:
        # Late: scipy costs what a first frame should not pay.
        from scipy.spatial import cKDTree

        stops = [tree.project(stop) for stop in axis.points[[0, -1]]]
        ends = set().union(*(ends_around(tree, stop, reach) for stop in stops))
        self._outlets = np.r_[outlets_of(tree), np.zeros(len(stops), dtype=np.int64)]
        self._points = np.concatenate([tree.points, [stop.point for stop in stops]])
        # Distal ends first: of two that share a way the first one counts.
        order = sorted(ends, key=lambda node: (tree.parent[node] < 0, node))
        up = [tree.ancestry(stop.index) for stop in stops]
        down = {end: tree.ancestry(place_of(tree, end).index) for end in order}
        ways = []
        for end, number in product(order, range(len(stops))):
            between = points_between(up[number], down[end])
            if between is not None:
                ways.append(np.r_[len(tree.points) + number, between, end])
        counts = np.array([len(way) for way in ways])
        self._nodes, self._starts = np.concatenate(ways), np.cumsum(counts) - counts
        ahead = self._points.take(np.roll(self._nodes, -1), axis=0)
        step = norm(ahead - self._points.take(self._nodes, axis=0))
        step[self._starts - 1] = 0.0
        self._longest = float(step.max())
        along = cKDTree(axis.resampled(FINEST).points)
        self._from_axis = along.query(self._points, distance_upper_bound=beside)[0]

    def leaving(self, distance: float, place: Floats, near: float) -> Iterator[Line]:
        """The lines that may come near a place, each from where it leaves the axis for good, mm.

        Those to most outlets come first; of those along the same points there, one.
        """
        rows = np.arange(len(self._nodes))
        beside = (self._from_axis < distance).take(self._nodes)
        last = np.maximum.reduceat(np.where(beside, rows, -1), self._starts)
        first = np.maximum(last, self._starts)
        ends = np.r_[self._starts[1:], len(rows)]
        # Of a step that comes so near, both ends are no farther away.
        may = (norm(self._points - place) < near + self._longest).take(self._nodes)
        may &= rows >= np.repeat(first, ends - self._starts)
        known: dict[bytes, tuple[int, Indices]] = {}
        for line in np.flatnonzero(np.logical_or.reduceat(may, self._starts)):
            own = self._nodes[first[line] : ends[line]]
            there = own[may[first[line] : ends[line]]]
            known.setdefault(there.tobytes(), (-int(self._outlets[there[-1]]), own))
        for _, own in sorted(known.values(), key=lambda way: way[0]):
            way = Line(self._points[own]).without_repeats()
            if len(way) > 1:
                yield way
