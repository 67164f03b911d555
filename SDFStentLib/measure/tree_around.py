"""The part of a centerline round an axis: where ways from the axis into the tree may end."""

from __future__ import annotations

import numpy as np

from ..centerline import Centerline, Location


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
        came_from, node, travelled = front.pop()
        onward = np.flatnonzero((begins == node) | (stops == node))
        onward = onward[onward != came_from]
        if travelled >= reach or not len(onward):
            found.add(node)
            continue
        for branch in onward.tolist():
            other = stops[branch] if begins[branch] == node else begins[branch]
            size = float(at[stops[branch]] - at[begins[branch]])
            front.append((branch, int(other), travelled + size))
    return found


def place_of(tree: Centerline, index: int) -> Location:
    """A point of the tree as a place on it."""
    at, radius = float(tree.arc_length[index]), float(tree.inscribed_radius[index])
    if tree.parent[index] >= 0:
        return Location(tree.points[index], 0.0, index, 1.0, at, radius)
    return Location(tree.points[index], 0.0, tree.neighbors.of(index)[0], 0.0, at, radius)
