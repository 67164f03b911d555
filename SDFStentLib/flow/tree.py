"""Topology of the blocks of a network: a tree from the first inlet on, and chords."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices


class Level(NamedTuple):
    """Blocks of a tree equally many junctions away from its root."""

    rows: Indices
    """(r,) blocks in groups that begin at one junction."""
    starts: Indices
    """(j,) first row of each group,"""
    counts: Indices
    """number of blocks in it,"""
    parents: Indices
    """and block that ends at its junction."""


class Tree(NamedTuple):
    """Topology of n blocks, most of them a tree whose root is the first inlet.

    What flows in at the other i - 1 inlets, and through the m chords that close loops, comes into
    the tree as flows of s = i - 1 + m sources.
    """

    ends: Indices
    """(n, 2) the nodes at which blocks begin and end."""
    inlets: Indices
    """(i,) the blocks at the inlets."""
    fractions: Floats
    """(i,) shares of the usual flow that come in there."""
    outlets: Indices
    """(k,) the blocks at the outlets."""
    above: Indices
    """(n,) next block on the way to the root; -1 at the root, and for chords."""
    order: tuple[int, ...]
    """The blocks of the tree, every one after that above it."""
    signs: Floats
    """(n,) 1 for blocks that lead away from the root, -1 for those that lead there."""
    leads_to: Flags
    """(n, k) mask of the outlets to which each leads in the tree."""
    levels: tuple[Level, ...]
    """Levels of the blocks that lead to outlets, from the first junctions on."""
    chords: Indices
    """(m,) the blocks that close loops."""
    enters: Floats
    """(s, n) shares of sources that come in at the far ends of blocks that lead to outlets,"""
    comes_by: Floats
    """(s, n) shares that come there through other blocks, against the way from the root,"""
    beyond: Floats
    """(s, n) and shares that come in beyond each block; -1 where a chord begins."""

    @property
    def outlet_nodes(self) -> Indices:
        """(k,) where the vessel ends at the outlets: far from the root."""
        far = (self.signs[self.outlets] > 0).astype(np.int64)
        return np.asarray(self.ends[self.outlets, far])

    @property
    def limbs(self) -> list[int]:
        """Blocks of loops that meet where their chords begin, the chords among them."""
        found: list[int] = []
        loops = self.beyond[len(self.inlets) - 1 :]
        for chord, around in zip(self.chords.tolist(), loops, strict=True):
            start = self.ends[chord, 0]
            beside = [k for k in np.flatnonzero(around).tolist() if start in self.ends[k]]
            found += [k for k in (*beside, chord) if k not in found]
        return found

    @property
    def signs_of_inlets(self) -> Floats:
        """(i,) 1 for those whose block leads away from the end of the vessel."""
        first = self.order[0] == self.inlets
        return np.asarray(np.where(first, 1.0, -1.0) * self.signs[self.inlets])

    @property
    def is_plain(self) -> bool:
        """Whether there is but one inlet and no loop."""
        return not len(self.enters)

    def summed(self, values: Floats) -> Floats:
        """Values of blocks (n,) and of all beyond them in the tree."""
        found = values.copy()
        for number in reversed(self.order[1:]):
            found[self.above[number]] += found[number]
        return found

    def carried(self, flow: float, shares: Floats) -> Floats:
        """Flows (n,), along the blocks, of a usual flow of which outlets take shares (k,).

        Nothing flows through chords.
        """
        away = flow * (self.leads_to @ shares)
        if not self.is_plain:
            others = flow * self.fractions[1:]
            away = away - others @ self.beyond[: len(others)]
        return np.asarray(self.signs * away)


def tree_between(ends: Indices, inlets: Mapping[int, float]) -> Tree:
    """The tree of blocks between nodes (n, 2), by the fractions of flow that come in at some.

    The tree begins at the first of them. Other nodes at which only one block ends are outlets.
    """
    entries = list(inlets)
    count = len(ends)
    degree: Indices = np.bincount(ends.ravel())
    degree[entries] = 0
    outlets = np.flatnonzero((degree[ends] == 1).any(axis=1))
    pairs = ends.tolist()
    at_inlets = [next(k for k, pair in enumerate(pairs) if node in pair) for node in entries]
    above, signs, order, block_at = _spanned(ends, entries[0])
    chords = np.setdiff1d(np.arange(count), order)
    leads_to = np.zeros((count, len(outlets)), dtype=bool)
    leads_to[outlets, np.arange(len(outlets))] = True
    for number in reversed(order[1:]):
        leads_to[above[number]] |= leads_to[number]
    is_live: Flags = np.asarray(leads_to.any(axis=1))

    def path(node: int) -> list[int]:
        way = [block_at[node]]
        # Ends: at the root.
        while above[way[-1]] >= 0:
            way.append(int(above[way[-1]]))
        return way

    # A chord takes blood at its begin and gives it at its end.
    sources = [[(int(node), 1.0)] for node in entries[1:]]
    sources += [[(int(ends[k, 0]), -1.0), (int(ends[k, 1]), 1.0)] for k in chords.tolist()]
    enters: Floats = np.zeros((len(sources), count))
    comes_by, beyond = enters.copy(), enters.copy()
    for row, source in enumerate(sources):
        for node, share in source:
            way = path(node)
            live = next(k for k, number in enumerate(way) if is_live[number])
            beyond[row, way] += share
            comes_by[row, way[:live]] += share
            enters[row, way[live]] += share
    levels = _levels(above, [number for number in order if is_live[number]])
    return Tree(
        ends,
        np.array(at_inlets, dtype=np.int64),
        np.array(list(inlets.values())),
        outlets,
        above,
        tuple(order),
        signs,
        leads_to,
        levels,
        chords,
        enters,
        comes_by,
        beyond,
    )


def _spanned(ends: Indices, root: int) -> tuple[Indices, Floats, list[int], dict[int, int]]:
    """Above, signs and order of a tree, as of `Tree`, and the block that leads to each node."""
    at: dict[int, list[int]] = {}
    for number, pair in enumerate(ends.tolist()):
        for node in pair:
            at.setdefault(node, []).append(number)
    above, signs = np.full(len(ends), -1), np.ones(len(ends))
    order: list[int] = []
    block_at: dict[int, int] = {}
    waiting, reached, taken = [root], {root}, set[int]()
    # Ends: every node is reached once.
    while waiting:
        node = waiting.pop(0)
        for number in at[node]:
            start, end = ends[number].tolist()
            other = end if start == node else start
            if number in taken or other in reached:
                continue
            taken.add(number)
            reached.add(other)
            above[number] = block_at.get(node, -1)
            signs[number] = 1.0 if start == node else -1.0
            block_at[other] = number
            order.append(number)
            waiting.append(other)
    return above, signs, order, block_at


def _levels(above: Indices, order: Sequence[int]) -> tuple[Level, ...]:
    depth = {-1: -1}
    for number in order:
        depth[number] = depth[int(above[number])] + 1
    levels = []
    for one in range(1, max(depth.values()) + 1):
        rows = np.array([number for number in sorted(order) if depth[number] == one])
        rows = rows[np.argsort(above[rows], kind="stable")]
        parents, starts, counts = np.unique(above[rows], return_index=True, return_counts=True)
        levels.append(Level(rows, starts, counts, parents))
    return tuple(levels)
