"""Places where two vessels whose walls touch have one lumen, through an opening between them.

Lines lead through such an opening as into a branch. It is a neck no longer than wide, and on both
of its sides a vessel goes straight on. Beyond an ostium one begins, and a stenosis has one alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..geometry import connected, norm, search_tree
from ..validation import Floats, Indices, Points
from .widest_ways import BACK, WidestWays

NARROW = 0.95
"""Share of the narrower vessel's radius below which an opening is one. Of 230 random pairs whose
walls overlap by up to half of that radius 184 are told at 0.9, 201 at 0.95, 206 at 0.99."""

STRAIGHT = 150.0
"""Angle between the arms of a vessel from which on it goes straight on, degrees. At 110 those 201
are told, too, and of 120 narrow ostia before a fork 11; at 130 three, from 140 on two."""

ARM = 2.0
"""Distance from the middle of a vessel, in radii, at which its arms begin; they reach `BACK`."""


class VesselsTouch(NamedTuple):
    """The place at which two vessels touch."""

    place: Points
    """(3,) mm."""
    diameter: float
    """Diameter of the largest ball that passes, mm."""


class _WayNeck(NamedTuple):
    """The narrowest ball of a part of a way that ends at wider ones."""

    ball: int
    sides: tuple[int, int]


def touching_vessels(ways: WidestWays, tree: Sequence[Indices]) -> list[VesselsTouch]:
    """The openings between vessels that touch, on ways (`WidestWays.tree`); the narrowest first."""
    centers, radii, links, _ = ways.balls
    partings = centers[[int(way[0]) for way in tree[1:]]]
    usual = np.array([np.median(radii[way]) for way in tree[1:]])
    necks = sorted(_necks(ways, tree), key=lambda neck: float(radii[neck.ball]))
    search, graph = search_tree(centers), _graph(links, radii)
    found: list[VesselsTouch] = []
    for neck in necks:
        place, sides = centers[neck.ball], list(neck.sides)
        reach = BACK * float(radii[sides].max()) + float(norm(centers[sides] - place).max())
        # Ways part twice where one arm comes in and three go on, each wider than the neck.
        is_near = (norm(partings - place) < reach) & (usual > radii[neck.ball])
        if np.count_nonzero(is_near) < 2:
            continue
        if any(np.linalg.norm(one.place - place) < reach for one in found):
            continue
        near = np.sort(search.query_ball_point(place, reach))
        near = near[radii[near] >= radii[neck.ball]]
        around = _Around(centers[near], radii[near], graph[near][:, near])
        one, other = np.searchsorted(near, sides).tolist()
        width = around.passage(one, other)
        if 0 < width < NARROW * radii[sides].min() and all(
            around.goes_straight_on(side, width) for side in (one, other)
        ):
            found.append(VesselsTouch(place, 2 * width))
    return found


def _graph(links: Indices, radii: Floats) -> Any:
    """Sparse matrix of the widths of links, mm."""
    from scipy.sparse import coo_array

    widths = radii[links].min(axis=1)
    return coo_array((widths, tuple(links.T)), (len(radii), len(radii))).tocsr()


def _necks(ways: WidestWays, tree: Sequence[Indices]) -> Iterator[_WayNeck]:
    """The necks of ways: their sides are the widest balls that touch one between them."""
    centers, radii, *_ = ways.balls
    for part in tree:
        way = ways.to(int(part[-1]))
        own = radii[way]
        is_dip = (own[1:-1] <= own[:-2]) & (own[1:-1] <= own[2:])
        dips = 1 + np.flatnonzero(is_dip)
        # Those before are of a way that is wider than this one.
        for number in dips[dips > len(way) - len(part)].tolist():
            touches = norm(centers[way] - centers[way[number]]) <= own + own[number]
            before, behind = np.split(np.where(touches, own, 0.0), [number])
            one, other = int(before.argmax()), number + int(behind.argmax())
            width = own[one : other + 1].min()
            if own[number] == width < NARROW * min(own[one], own[other]):
                yield _WayNeck(int(way[number]), (int(way[one]), int(way[other])))


class _Around:
    """The balls round a place, and the widths of their links."""

    def __init__(self, centers: Points, radii: Floats, graph: Any) -> None:
        self.centers, self.radii = centers, radii
        made = graph.tocoo()
        self.links, self.widths = np.column_stack([made.row, made.col]), made.data

    def passage(self, one: int, other: int) -> float:
        """Radius of the largest ball that passes from one to another, mm; 0 where none does."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

        count = len(self.radii)
        graph = coo_array((1 / self.widths, tuple(self.links.T)), (count, count))
        # The tree of the widest links has the widest way between any two.
        spanning = minimum_spanning_tree(graph.tocsr())
        former = breadth_first_order(spanning, one, directed=False)[1]
        width = float(self.radii[other])
        # Ends: the way back leads to the one, or begins nowhere.
        while other != one:
            if (other := int(former[other])) < 0:
                return 0.0
            width = min(width, float(self.radii[other]))
        return width

    def goes_straight_on(self, middle: int, width: float) -> bool:
        """Whether a vessel has two arms on opposite sides of a ball, of links above a width."""
        is_wide = self.widths > width
        away = norm(self.centers - self.centers[middle]) / self.radii[middle]
        whole = connected(len(away), *self.links[is_wide].T)[1]
        is_beyond = (whole == whole[middle]) & (away > ARM)
        kept = is_wide & is_beyond[self.links].all(axis=1)
        labels = connected(len(away), *self.links[kept].T)[1]
        ways = []
        for label in np.unique(labels[is_beyond & (away >= BACK)]).tolist():
            arm = (labels == label) & (away < BACK)
            if arm.any():
                way = self.centers[arm].mean(axis=0) - self.centers[middle]
                ways.append(way / np.linalg.norm(way))
        both = np.array(ways).reshape(-1, 3)
        cosines = both @ both.T
        return bool(cosines.min(initial=1.0) <= np.cos(np.deg2rad(STRAIGHT)))
