"""Ways through a lumen from its inlet to its ends, each as far from the wall as it can be.

A way costs its length over the radius of the balls that it leads through, so the cheapest one stays
in the middle (Antiga and Steinman, 2004). All of them come from one search: they form a tree, for
two ways that meet are the same from there to the inlet.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..geometry import component_labels, norm, search_tree
from ..validation import Flags, Floats, Indices, Points
from .inner_balls import InnerBalls

NEAR = 32
"""Number of balls nearest to a place that may be the one at which it is entered: some few beside a
wall have no neighbors."""

BACK = 3.0
"""Distance in radii, back along two ways and between them, by which these come from two limbs;
across one vessel they are at most two apart."""


class ExtractedLines(NamedTuple):
    """Lines from the inlet to every outlet, which overlap upstream."""

    points: Points
    """(n, 3) points, mm."""
    lines: tuple[Indices, ...]
    """Point indices of each line from the inlet on, in the order of the outlets."""
    inscribed_radius: Floats
    """(n,) radius of the largest inscribed sphere, mm."""


def with_places(balls: InnerBalls, places: Points) -> InnerBalls:
    """The balls, and behind them one for each place (k, 3), linked to the ball beside it."""
    labels = component_labels(len(balls.radii), balls.links[:, 0], balls.links[:, 1])
    sizes = np.bincount(labels)
    near = search_tree(balls.centers).query(places, k=min(NEAR, len(balls.radii)))[1]
    near = near.reshape(len(places), min(NEAR, len(balls.radii)))
    beside = near[np.arange(len(places)), sizes[labels[near]].argmax(axis=1)]
    own = len(balls.radii) + np.arange(len(places))
    return InnerBalls(
        np.vstack([balls.centers, places]),
        np.concatenate([balls.radii, balls.radii[beside]]),
        np.vstack([balls.links, np.column_stack([beside, own])]),
        balls.at_wall,
    )


class WidestWays:
    """The ways from one ball to all others.

    Parameters
    ----------
    balls : InnerBalls
        Inner balls of a closed surface.
    inlet : int
        The ball at which ways begin.
    """

    def __init__(self, balls: InnerBalls, inlet: int) -> None:
        self.balls, self.inlet = balls, inlet

    @cached_property
    def _cheapest(self) -> tuple[Floats, Indices]:
        one, other = self.balls.links.T
        radii = self.balls.radii
        costs = self.balls.link_lengths * (1 / radii[one] + 1 / radii[other]) / 2
        return cheapest(self.balls.links, costs, len(radii), self.inlet)

    @property
    def _former(self) -> Indices:
        """The ball (n,) before each, negative at the inlet."""
        return self._cheapest[1]

    @cached_property
    def is_reached(self) -> Flags:
        """Mask (n,) of the balls to which a way leads."""
        return np.isfinite(self._cheapest[0])

    def parts_apart(self, ends: Sequence[int]) -> list[int]:
        """The widest ball of each part of the lumen to which no way leads, the widest first.

        A part has one of some `ends`, or is longer than it is wide, as a round end is: by less,
        balls beside a wall stand alone.
        """
        centers, radii, links, _ = self.balls
        lone = np.flatnonzero(~self.is_reached)
        own = np.searchsorted(lone, links[~self.is_reached[links[:, 0]]])
        label = component_labels(len(lone), own[:, 0], own[:, 1])
        order = np.lexsort((-radii[lone], label))
        begins = np.flatnonzero(np.diff(label[order], prepend=-1))
        lone = lone[order]
        extent = [reduce.reduceat(centers[lone], begins) for reduce in (np.maximum, np.minimum)]
        is_long = norm(np.subtract(*extent)) > 2 * radii[lone[begins]]
        is_long |= np.add.reduceat(np.isin(lone, ends), begins) > 0
        found = lone[begins[is_long]]
        return found[np.argsort(-radii[found], kind="stable")].tolist()

    def tree(self, ends: Sequence[int]) -> list[Indices]:
        """Ways to some balls as a tree: where they part, the widest goes on and others begin.

        Each has its balls from the side of the inlet on, the first one of them a ball of the way
        that it leaves. It comes after that way.
        """
        children: dict[int, list[int]] = {}
        known: set[int] = set()
        for end in ends:
            ball = end
            # Ends: ways lead back to the inlet.
            while ball not in known and (above := int(self._former[ball])) >= 0:
                known.add(ball)
                children.setdefault(above, []).append(ball)
                ball = above
        return list(_parted(self.inlet, children, self._widths(children)))

    def to(self, end: int) -> Indices:
        """The balls of the way to one of them, from the inlet on."""
        way = [end]
        # Ends: ways lead back to the inlet.
        while (above := int(self._former[way[-1]])) >= 0:
            way.append(above)
        return np.array(way[::-1])

    @cached_property
    def meetings(self) -> Indices:
        """Pairs (j, 2) of balls, `limbs_met` of these ways."""
        return limbs_met(self.balls, self._former)

    def _widths(self, children: dict[int, list[int]]) -> dict[int, float]:
        """Largest mean radius, weighted by length, of the ways on from each ball of a tree."""
        order = [self.inlet]
        for ball in order:
            order.extend(children.get(ball, ()))
        below = np.array(order[1:], dtype=np.int64)
        lengths = norm(self.balls.centers[below] - self.balls.centers[self._former[below]])
        areas = dict(zip(order[1:], (lengths * self.balls.radii[below]).tolist(), strict=True))
        steps = dict(zip(order[1:], lengths.tolist(), strict=True))
        beyond: dict[int, tuple[float, float]] = {}
        for ball in reversed(order):
            ways = [
                (beyond[under][0] + areas[under], beyond[under][1] + steps[under])
                for under in children.get(ball, ())
            ]
            beyond[ball] = max(ways, key=_mean, default=(0.0, 0.0))
        return {ball: _mean(value) for ball, value in beyond.items()}


def limbs_met(balls: InnerBalls, former: Indices) -> Indices:
    """Meetings of limbs of a lumen that have parted, as pairs of neighboring balls.

    Parameters
    ----------
    balls : InnerBalls
    former : (n,) array of int
        The ball before each on its way from where all ways begin, negative there.

    Returns
    -------
    (j, 2) array
        At every place where they do two neighbors whose ways come from different limbs, the wider
        one first. Of all that do there, these have the widest ball on their ways, then the widest
        neck between them. What is equal goes by position, as numbers of balls say nothing.
    """
    centers, radii, links, _ = balls
    own = np.arange(len(radii))
    onward = np.where(former >= 0, former, own)
    # `take` is quicker than an index in brackets.
    strides = [(onward, norm(centers.take(onward, axis=0) - centers), radii.take(onward))]
    # Ends: strides double until they are long enough, or lead to where all begin.
    while (is_short := strides[-1][1] < BACK * strides[-1][2]).any():
        after, length, width = strides[-1]
        if not is_short[after != after.take(after)].any():
            break
        width = np.maximum(width, width.take(after))
        strides.append((after.take(after), length + length.take(after), width))
    before, walked, widest = own, np.zeros(len(radii)), radii
    for after, length, width in reversed(strides):
        far, wide = walked + length.take(before), np.maximum(widest, width.take(before))
        is_short = far < BACK * wide
        before = np.where(is_short, after.take(before), before)
        walked, widest = np.where(is_short, far, walked), np.where(is_short, wide, widest)
    before = onward.take(before)
    one, other = before.take(links).T
    away = norm(centers.take(one, axis=0) - centers.take(other, axis=0))
    # What no way leads to has no limbs.
    is_led_to = (former.take(links) >= 0).any(axis=1)
    met = links[is_led_to & (away > BACK * widest.take(links).max(axis=1))]
    some = np.unique(met)
    some = some[np.lexsort((*centers[some].T, radii[some]))[::-1]]
    rank = np.empty_like(own)
    rank[some] = np.arange(len(some))
    met = some[np.sort(rank[met], axis=1)]
    first, second = rank[met].T
    found: list[Indices] = []
    for pair in met[np.lexsort((first, second, -widest[met].max(axis=1)))]:
        reach = BACK * widest[pair].max()
        if all(norm(centers[one] - centers[pair]).max() > reach for one in found):
            found.append(pair)
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def cheapest(links: Indices, costs: Floats, count: int, source: int) -> tuple[Floats, Indices]:
    """Least costs (count,) of the balls from one of them, infinite where none leads there, and the
    ball before each; negative where there is none."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    costs = np.maximum(costs, np.finfo(np.float64).tiny)  # zeros would be no links
    graph = coo_array((costs, (links[:, 0], links[:, 1])), (count, count)).tocsr()
    cost, former = dijkstra(graph, directed=False, indices=source, return_predecessors=True)
    return cost, former


def _mean(area_and_length: tuple[float, float]) -> float:
    area, length = area_and_length
    return area / length if length else 0.0


def _parted(
    inlet: int, children: dict[int, list[int]], widths: dict[int, float]
) -> Iterator[Indices]:
    waiting = [[inlet]]
    for way in waiting:
        # Ends with a tip of the tree.
        while way[-1] in children:
            above = way[-1]
            first, *others = sorted(children[above], key=lambda ball: -widths[ball])
            waiting.extend([above, other] for other in others)
            way.append(first)
        yield np.array(way)
