"""Target of a view, and the lumen that may lie in its way, as spheres on the centerline."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..centerline import Centerline
from ..geometry import Line, norm
from ..validation import Floats, Indices, Points

STATIONS = 25
"""Number of places along a stretch to look at, and"""

STATIONS_OF_OSTIUM = 3
"""along the beginning of a branch."""

STEP = 0.5
"""Spheres of a tree follow each other by this share of their radius, and"""

FULL = float(np.sqrt(1 + (STEP / 2) ** 2))
"""are so many times as wide, 3 % more, for their union to hold the tube around them."""


class Spheres(NamedTuple):
    """Spheres whose union is a lumen, mm."""

    centers: Points
    """(n, 3)"""
    radii: Floats
    """(n,)"""
    branches: Indices
    """(n,) indices of the branches of the tree."""


class Target(NamedTuple):
    """Places of a vessel that a view has to show, mm."""

    centers: Points
    """(n, 3) on the centerline."""
    ways: Points
    """(n, 3) unit directions of the vessel."""
    radii: Floats
    """(n,)"""
    weights: Floats
    """(n,) how much each counts; they add up to 1, or are none."""
    area: float = 0.0
    """Area of the whole target in a picture from the side, mm^2."""


def spheres_of(tree: Centerline) -> Spheres:
    """Spheres along all branches of a tree, those of unknown radius left out."""
    parts = [_along(tree, number) for number in range(len(tree.branches))]
    return Spheres(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _along(tree: Centerline, number: int) -> Spheres:
    nodes = tree.branches[number]
    nodes = nodes[np.isfinite(tree.inscribed_radius[nodes])]
    points, radii = tree.points[nodes], tree.inscribed_radius[nodes]
    if len(nodes) < 2:
        return Spheres(points, FULL * radii, np.full(len(nodes), number))
    steps = norm(np.diff(points, axis=0)) / (STEP * np.minimum(radii[1:], radii[:-1]))
    passed = np.r_[0.0, np.cumsum(steps)]
    at = np.linspace(0.0, passed[-1], int(np.ceil(passed[-1])) + 1)
    centers = np.column_stack([np.interp(at, passed, column) for column in points.T])
    return Spheres(centers, FULL * np.interp(at, passed, radii), np.full(len(at), number))


def stretch_target(line: Line, radii: Floats) -> Target:
    """A stretch of vessel, such as a lesion or a stent; every part of its length counts alike.

    Parameters
    ----------
    line : Line
        Axis of the stretch.
    radii : (k,) array
        Inscribed, at the points of the line, mm; unknown ones are interpolated.
    """
    at = (np.arange(STATIONS) + 0.5) * line.length / STATIONS
    known = np.isfinite(radii)
    widths = np.interp(at, line.arc_lengths[known], radii[known])
    half = line.length / (2 * STATIONS)
    ways = line.at(at + half) - line.at(at - half)
    ways = ways / norm(ways)[:, None]
    area = float(2 * widths.mean() * line.length)
    return Target(line.at(at), ways, widths, np.full(STATIONS, 1 / STATIONS), area)


def ostia_target(tree: Centerline, line: Line) -> Target:
    """The beginnings of the branches that leave a stretch; each counts by its area in a picture.

    Branches of a junction whose sphere reaches the stretch, except the vessel itself. A beginning
    is one diameter of the branch long, from where its line leaves that sphere.
    """
    own = set(tree.ancestry(tree.project(line.points[-1]).index).tolist())
    parts = [
        part
        for branch in tree.branches
        if len(branch) > 1 and int(branch[1]) not in own and tree.parent[branch[0]] >= 0
        for part in _beginning(tree, branch, line)
    ]
    if not parts:
        none = np.empty(0)
        return Target(np.empty((0, 3)), np.empty((0, 3)), none, none)
    centers, ways, radii, areas = (
        np.concatenate(one) for one in zip(*(part[:4] for part in parts), strict=True)
    )
    return Target(centers, ways, radii, areas / areas.sum(), float(areas.sum()))


def _beginning(tree: Centerline, branch: Indices, line: Line) -> Iterator[Target]:
    """The beginning of a branch, weighted by its area, if it is beside the stretch."""
    place, reach = tree.points[branch[0]], tree.inscribed_radius[branch[0]]
    if not line.nearest(place[None]).distances[0] <= reach:
        return
    points, radii = tree.points[branch], tree.inscribed_radius[branch]
    beyond = np.flatnonzero((norm(points - place) > reach) & np.isfinite(radii))
    if not len(beyond):
        return
    first = int(beyond[0])
    width, way = radii[first], Line(points)
    start = way.arc_lengths[first]
    at = start + (np.arange(STATIONS_OF_OSTIUM) + 0.5) * 2 * width / STATIONS_OF_OSTIUM
    at = np.minimum(at, way.length)
    ahead = way.at(at) - place
    ways = ahead / norm(ahead)[:, None]
    count = STATIONS_OF_OSTIUM
    yield Target(way.at(at), ways, np.full(count, width), np.full(count, (2 * width) ** 2 / count))
