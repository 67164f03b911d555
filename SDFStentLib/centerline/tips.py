"""Round ends of a lumen, at which it has neither an opening nor a flat cap.

How far a lumen reaches is one function of its balls: the way of each from where all begin, and its
radius on top. That sum hardly changes on the way from the middle of a vessel into a bump of its
wall, and grows along a vessel. An end is a maximum by its persistence (Edelsbrunner, Letscher and
Zomorodian, 2002): it reaches farther, by more than it is wide, than the place where it hangs
together with what reaches farther still. A bulge does not.
"""

from __future__ import annotations

import numpy as np

from ..geometry import Surface, norm, search_tree, side_lengths
from ..validation import Floats, Indices, Points
from .inner_balls import InnerBalls
from .widest_ways import BACK, cheapest, limbs_met

FULL = 0.9
"""Share of the widest ball in a tip that the last one has at which its line ends."""


def round_ends(balls: InnerBalls, begin: int | None, known: Indices, wall: Surface) -> Indices:
    """The balls (k,) in the round ends of a lumen, the widest first.

    Parameters
    ----------
    balls : InnerBalls
    begin : int or None
        The ball at a known end, from which ways are measured; None where no end is known.
    known : (k,) array of int
        Balls at ends that are known: these are not found again.
    wall : Surface
        Round the balls. What is not as wide as its triangles is an accident of these.
    """
    tips: list[int] = []
    if begin is None:
        # What is farthest from anywhere is an end; there may be one at the widest place, too.
        tips = _Reach(balls, int(balls.radii.argmax())).tips(known, wall)[:1]
        if not tips:
            return known[:0]
        begin = tips[0]
    tips += _Reach(balls, begin).tips(np.append(known, begin), wall)
    return np.array(sorted(tips, key=lambda ball: -balls.radii[ball]), dtype=np.int64)


class _Reach:
    """Reach of every ball from one of them: the way to its center, and its radius."""

    def __init__(self, balls: InnerBalls, begin: int) -> None:
        self.balls = balls
        self.away, self.former = cheapest(balls.links, balls.link_lengths, len(balls.radii), begin)
        self.reach = self.away + balls.radii
        self.reach[~np.isfinite(self.away)] = -np.inf

    def tips(self, known: Indices, wall: Surface) -> list[int]:
        """Balls in round ends, the farthest first; not those already known."""
        centers, radii, links, _ = self.balls
        values = self.reach.copy()
        values[known] = np.inf  # nothing reaches farther
        found = []
        for peak, saddle in _persistent(values, links):
            if self.away[peak] <= saddle or values[peak] == np.inf:
                continue  # no longer than wide: most are
            way = self.beyond(peak, saddle)
            if self._length(way) > 2 * radii[way].max():
                found.append(way)
        if not found:
            return []
        found.sort(key=lambda way: -self.reach[way[0]])
        met = centers[limbs_met(self.balls, self.former)[:, 0]]
        sides = _sides_at(wall, centers[[way[0] for way in found]])
        tree, tips = search_tree(centers), []
        for way, side in zip(found, sides, strict=True):
            width, peak = float(radii[way].max()), centers[way[0]]
            if width >= side and norm(met - peak).min(initial=np.inf) > BACK * width:
                last = self._out_of_the_rim(way[0], float(side))
                # The way may go on to facets of the wall, within or beside a wider ball.
                width = max(width, float(radii[last]))
                near = np.array(tree.query_ball_point(centers[last], width + radii[last]))
                near = near[np.isfinite(self.away[near])]
                beside = near[norm(centers[near] - centers[last]) <= radii[near] + radii[last]]
                wide = beside[radii[beside] >= FULL * radii[beside].max()]
                tip = int(wide[self.away[wide].argmax()])
                # What is not as long as the end is wide in which it lies is a pocket of that.
                if self._length(way) > 2 * radii[tip]:
                    tips.append(tip)
        return tips

    def _length(self, way: Indices) -> float:
        """How far a way leads, mm, as the crow flies: from ball to ball ways go zigzag."""
        centers, radii, *_ = self.balls
        return float((norm(centers[way] - centers[way[-1]]) + radii[way]).max())

    def _out_of_the_rim(self, peak: int, side: float) -> int:
        """The ball at which the way back from one of them comes to the middle of an end.

        In a cap that is not quite flat, as that of a surface that was smoothed, the farthest ball
        lies in the rim: the root of two of its radii away from the ball in the middle, or less, by
        what the triangles' sides, mm, leave open.
        """
        centers, radii, *_ = self.balls
        rim, ball = [peak], int(self.former[peak])
        # Ends: ways lead back to where all begin.
        while ball >= 0:
            away = float(np.linalg.norm(centers[ball] - centers[peak]))
            if away > np.sqrt(2.0) * radii[ball] + side:
                break
            rim.append(ball)
            ball = int(self.former[ball])
        return int(rim[(radii[rim] >= FULL * radii[rim].max()).argmax()])

    def beyond(self, ball: int, level: float) -> Indices:
        """The balls of the way from one of them back to where ways are shorter than a level."""
        way = [ball]
        # Ends: ways lead back to where all begin.
        while self.former[way[-1]] >= 0 and self.away[way[-1]] > level:
            way.append(int(self.former[way[-1]]))
        return np.array(way)


def _sides_at(wall: Surface, places: Points) -> Floats:
    """Length (k,) of the sides of a wall's triangles at the points next to some places, mm."""
    corners = wall.triangles.ravel()
    sides = np.repeat(side_lengths(wall.points, wall.triangles).mean(axis=1), 3)
    number = np.bincount(corners, minlength=len(wall.points))
    mean = np.bincount(corners, sides, len(wall.points)) / np.maximum(number, 1)
    nearest = search_tree(wall.points).query(places.reshape(-1, 3))[1]
    return np.asarray(mean[nearest])


def _persistent(values: Floats, links: Indices) -> list[tuple[int, float]]:
    """The maxima of values on a graph, and the level at which each joins a higher one.

    That level is minus infinity for the highest of a part of the graph.
    """
    basin = _basins(values, links)
    levels = values[links].min(axis=1)
    ends = basin[links]
    between = np.flatnonzero((ends[:, 0] != ends[:, 1]) & (levels > -np.inf))
    between = between[np.argsort(-levels[between], kind="stable")]
    # Of the links between two basins the highest joins them.
    one, other = np.sort(ends[between], axis=1).T
    between = between[np.sort(np.unique(one * len(values) + other, return_index=True)[1])]
    peaks = np.unique(basin[values > -np.inf])
    top = {int(peak): int(peak) for peak in peaks}

    def highest(peak: int) -> int:
        # Ends: of two maxima the lower one leads to the higher one.
        while top[peak] != peak:
            top[peak] = peak = top[top[peak]]
        return peak

    joined = dict.fromkeys(top, -np.inf)
    for (one, other), level in zip(ends[between].tolist(), levels[between].tolist(), strict=True):
        low, high = sorted((highest(one), highest(other)), key=lambda peak: values[peak])
        if low != high:
            top[low], joined[low] = high, level
    return list(joined.items())


def _basins(values: Floats, links: Indices) -> Indices:
    """The maximum (n,) to which the steepest way up leads from every node."""
    rises = values[links[:, 1]] > values[links[:, 0]]
    low, high = np.where(rises[:, None], links, links[:, ::-1]).T
    # Of several entries the last one counts, which leads highest.
    order = np.argsort(values[high], kind="stable")
    found = np.arange(len(values))
    found[low[order]] = high[order]
    is_level = values[found] <= values
    found[is_level] = np.flatnonzero(is_level)
    # Ends: each time ways become twice as long, and they have no circles.
    while (found[found] != found).any():
        found = found[found]
    return found
