"""Usual direction of blood through the channels of a vessel, from its inlets on.

Nodes are where channels end: 0 is the root of the centerline, `k + 1` the end of channel `k`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices
from .blocks import ADULT, outlet_diameter
from .channels import Channel, Widths, outlets_of
from .network import steady
from .outlets import firm_outlets
from .tree import Tree, tree_between

LEAST = 1e-6
"""Least share of the flow for profiles, which need some, as in limbs without any."""


def nodes_of(channels: Sequence[Channel]) -> Indices:
    """Nodes (n, 2) at which channels begin and end."""
    ends = [k if one.joins < 0 else one.joins for k, one in enumerate(channels)]
    return np.column_stack([[one.above for one in channels], ends]) + 1


def tips_of(channels: Sequence[Channel]) -> list[int]:
    """The nodes at which the vessel ends, the root first."""
    return [0, *(number + 1 for number in outlets_of(channels))]


def tip_diameters(channels: Sequence[Channel], widths: Sequence[Widths], tree: Tree) -> Floats:
    """Diameters of the outlets (k,) of a tree of channels, as of `outlet_diameter`, mm."""
    found = []
    for number, sign in zip(tree.outlets.tolist(), tree.signs[tree.outlets].tolist(), strict=True):
        one, size = channels[number], widths[number]
        found.append(outlet_diameter(*((one, size) if sign > 0 else (one.turned(), size.turned()))))
    return np.array(found)


class _Rough(NamedTuple):
    """Channels with Poiseuille's friction, undirected, as a network."""

    tree: Tree
    resistance: Floats
    stenosis: Floats


def rough_flow(
    channels: Sequence[Channel],
    widths: Sequence[Widths],
    inlets: Mapping[int, float],
    flow: float,
    shares: Floats,
) -> Floats:
    """Flows (n,), away from the root of the centerline, before profiles are known.

    Parameters
    ----------
    channels, widths : sequences
    inlets : mapping
        Fractions of the flow by nodes.
    flow : float
        m^3/s.
    shares : (k,) array
        Shares of the flow through the outlets.
    """
    tree = tree_between(nodes_of(channels), inlets)
    if not len(tree.chords):
        leaving = np.zeros(len(channels) + 1)
        leaving[tree.outlet_nodes] = shares / shares.sum()
        for node, fraction in inlets.items():
            leaving[node] = -fraction
        found = leaving[1:]
        # Those above come before those below.
        for number in reversed(range(len(channels))):
            if channels[number].above >= 0:
                found[channels[number].above] += found[number]
        return flow * found
    resistance = []
    for one, size in zip(channels, widths, strict=True):
        step, narrowed = 1e-3 * np.diff(one.along), (1e-6 * size.area) ** -2.0
        integral = float(step @ (narrowed[1:] + narrowed[:-1])) / 2
        resistance.append(8 * np.pi * ADULT.viscosity * integral)
    rough = _Rough(tree, np.array(resistance), np.zeros(len(channels)))
    return steady(rough, firm_outlets(rough, shares, flow, flow), flow).flow


class Course(NamedTuple):
    """Channels along the flow, every one after those that bring its blood."""

    order: tuple[int, ...]
    """Their numbers in the tree of the centerline."""
    is_turned: Flags
    """(n,) which of these flow toward the root."""
    feeders: tuple[tuple[int, ...], ...]
    """Feeders of each channel along the flow, that with most of its blood first."""
    tree: Tree
    """The tree of the channels."""

    @property
    def is_as_drawn(self) -> bool:
        """Whether all blood comes from the root of the centerline and no limbs meet again."""
        return self.tree.is_plain and not self.is_turned.any()

    def away(self, flow: Floats) -> Floats:
        """Flows (n,) along the flow as those away from the root, in the tree's order."""
        found = np.empty_like(flow)
        found[list(self.order)] = flow
        return np.where(self.is_turned, -found, found)

    def along(
        self, channels: Sequence[Channel], widths: Sequence[Widths]
    ) -> tuple[tuple[Channel, ...], tuple[Widths, ...]]:
        """Channels, and widths, in the order and in the directions of the flow."""
        if self.is_as_drawn:
            return tuple(channels), tuple(widths)
        found: list[Channel] = []
        sizes = []
        for number, feeders in zip(self.order, self.feeders, strict=True):
            one, size = channels[number], widths[number]
            if self.is_turned[number]:
                one, size = one.turned(), size.turned()
            above, *also = feeders or (-1,)
            start = found[above].along[-1] if feeders else 0.0
            one = one._replace(along=start + (one.along - one.along[0]))
            found.append(one._replace(above=above, also=tuple(also), joins=-1))
            sizes.append(size)
        return tuple(found), tuple(sizes)


def course_of(channels: Sequence[Channel], flow: Floats, inlets: Mapping[int, float]) -> Course:
    """The course by flows (n,) through channels, away from the root, and inflows by their nodes."""
    ends = nodes_of(channels)
    drawn = tree_between(ends, inlets)
    # Closed limbs lead from their ends, too.
    is_closed = (flow == 0) & ~drawn.leads_to.any(axis=1) & (drawn.signs > 0)
    is_closed[drawn.chords] = False
    is_turned = (flow < 0) | is_closed
    ends[is_turned] = ends[is_turned, ::-1]
    ending: dict[int, list[int]] = {}
    for number, node in enumerate(ends[:, 1].tolist()):
        ending.setdefault(node, []).append(number)
    before = [ending.get(node, []) for node in ends[:, 0].tolist()]
    order = _in_order(before)
    place = {number: k for k, number in enumerate(order)}
    feeders = []
    for number in order:
        # Where nothing flows there may be a circle, of which one piece has to be the first.
        known = [one for one in before[number] if place[one] < place[number]]
        known.sort(key=lambda one: -abs(flow[one]))
        feeders.append(tuple(place[one] for one in known))
    ends = ends[list(order)]
    return Course(order, is_turned, tuple(feeders), tree_between(ends, inlets))


def _in_order(before: Sequence[Sequence[int]]) -> tuple[int, ...]:
    """Numbers in an order in which each follows those before it, the lowest first."""
    waits = [len(one) for one in before]
    after: list[list[int]] = [[] for _ in before]
    for number, some in enumerate(before):
        for one in some:
            after[one].append(number)
    ready = [number for number, count in enumerate(waits) if not count]
    heapify(ready)
    left, order = set(range(len(before))), list[int]()
    # Ends: every number leaves once.
    while left:
        number = heappop(ready) if ready else min(left)
        if number not in left:
            continue
        left.remove(number)
        order.append(number)
        for one in after[number]:
            waits[one] -= 1
            if not waits[one]:
                heappush(ready, one)
    return tuple(order)
