"""Merging of lines of one vessel that run along each other, up to where they part."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist

import numpy as np

from ..validation import Floats, Indices
from .chains import Chains, ranked_chains
from .line_graph import LineGraph, near_pairs, pairs_within, reach_of, split_edges

OVERLAP_FRACTION = 0.1
"""Distance of lines, over the inscribed radius, below which they are one line."""

OVERLAP_EXTENT = 1e-3
"""The same as a fraction of the bounding box's diagonal where no radius is known."""

LEAVING_RATIO = 0.5
"""Distance of two lines from a common end, over the way from there, below which they overlap."""

MOST_PAIRS = 1 << 16
"""Number of near pairs of node and segment, about, that are looked at together."""

_SOME = 500
"""Number of segments from which the number of pairs is estimated."""


def merged_overlaps(graph: LineGraph, line_ends: Indices) -> LineGraph:
    """Graph with every line that runs along a longer one merged into it.

    A node within `OVERLAP_FRACTION` of the radius of a longer line's segment lies on that line.
    Where a line leaves the longer one, its last such node is moved onto it and inserted there.

    Parameters
    ----------
    graph : LineGraph
        Welded lines.
    line_ends : array of nodes
        Nodes at which lines of the file start or end: lines that touch there are compared as well.
    """
    graph = _without_chords(graph)
    stops = np.zeros(len(graph.points), dtype=bool)
    stops[line_ends] = True
    found = ranked_chains(graph, stops)
    first_chain = np.zeros(len(graph.points), dtype=np.int64)
    for number in reversed(range(len(found.paths))):
        first_chain[found.paths[number]] = number
    merge = _Merge(graph, found)
    for chains_together in _together(graph, first_chain):
        merge.look_round(first_chain, chains_together)
        for number in chains_together:
            merge.put_on_earlier_chains(number)
    return _with_feet(graph, merge)


def _reach(graph: LineGraph) -> Floats:
    return reach_of(graph, OVERLAP_FRACTION, OVERLAP_EXTENT)


def _together(graph: LineGraph, first_chain: Indices) -> Iterator[range]:
    """Ranges of chains whose surroundings are searched together: about `MOST_PAIRS` pairs each.

    Only the longest of many lines that run along each other keeps its edges: the others are not
    searched again for the chains that come after them.
    """
    some = np.arange(0, len(graph.edges), max(1, len(graph.edges) // _SOME))
    share = len(graph.edges) / len(some)
    pairs = max(1.0, share * pairs_within(graph, _reach(graph), some))
    # The number of pairs grows with the square of that of the nodes.
    count = max(1, int(len(graph.points) * min(1.0, np.sqrt(MOST_PAIRS / pairs))))
    last = np.cumsum(np.bincount(first_chain)) // count
    bounds = np.flatnonzero(np.diff(last)) + 1
    return map(range, [0, *bounds.tolist()], [*bounds.tolist(), len(last)])


def _without_chords(graph: LineGraph) -> LineGraph:
    """The graph without edges whose two ends are connected through nodes beside them.

    The longest are dropped first. So a coarse line that shares some points with a finer one adds
    nothing to it.
    """
    neighbors = _NeighborSets(graph)
    branching = np.flatnonzero(graph.degrees()[graph.edges].max(axis=1) > 2)
    pairs = near_pairs(graph, _reach(graph), edges=branching)
    order = np.argsort(pairs.segments, kind="stable")
    nodes, limits = pairs.nodes[order], np.arange(len(graph.edges) + 1)
    bounds = np.searchsorted(pairs.segments[order], limits)
    kept = np.ones(len(graph.edges), dtype=bool)
    longest_first = np.argsort(-graph.edge_lengths(), kind="stable")
    may_be = bounds[:-1] < bounds[1:]
    for edge in longest_first[may_be[longest_first]]:
        a, b = graph.edges[edge].tolist()
        beside = set(nodes[bounds[edge] : bounds[edge + 1]].tolist())
        if _meet(neighbors, a, b, beside):
            kept[edge] = False
            neighbors[a].discard(b)
            neighbors[b].discard(a)
    return graph._replace(edges=graph.edges[kept])


class _NeighborSets(dict[int, set[int]]):
    """The sets of nodes next to a node, looked up when first asked for."""

    def __init__(self, graph: LineGraph) -> None:
        self._table = graph.neighbors()

    def __missing__(self, node: int) -> set[int]:
        self[node] = set(self._table.of(node))
        return self[node]


def _meet(neighbors: _NeighborSets, start: int, end: int, through: set[int]) -> bool:
    """Whether there is a way from start to end through at least one of the given nodes."""
    reached = neighbors[start] & through
    front = list(reached)
    # Ends: a node comes in when it is reached for the first time.
    while front:
        steps = neighbors[front.pop()]
        if end in steps:
            return True
        fresh = (steps & through) - reached
        reached |= fresh
        front += fresh
    return False


class _Merge:
    """The state of a merge: the segment of an earlier chain under every node, and the edges gone.

    Parameters
    ----------
    graph : LineGraph
    found : Chains

    Attributes
    ----------
    foot, fraction : (n,) arrays
        Edge of an earlier chain on which every node lies, or -1, and the place on it.
    gone : (m,) array of bool
        Edges that run along earlier chains.
    """

    def __init__(self, graph: LineGraph, found: Chains) -> None:
        self.graph, self.found = graph, found
        self.foot = np.full(len(graph.points), -1, dtype=np.int64)
        self.fraction = np.zeros(len(graph.points))
        self.gone = np.zeros(len(graph.edges), dtype=bool)

    def look_round(self, first_chain: Indices, numbers: range) -> None:
        """Find the segments of earlier chains, and of some chains, near the new nodes of these.

        Pairs are sorted by the first chain that has their node, then by distance; those of each
        chain begin at `first_pair`.
        """
        nodes = np.flatnonzero((first_chain >= numbers.start) & (first_chain < numbers.stop))
        edges = np.flatnonzero((self.found.of_edge < numbers.stop) & ~self.gone)
        pairs = near_pairs(self.graph, _reach(self.graph), nodes=nodes, edges=edges)
        self.pairs = pairs.selected(np.lexsort((pairs.distances, first_chain[pairs.nodes])))
        limits = np.arange(numbers.start, numbers.stop + 1)
        self.first_pair = np.searchsorted(first_chain[self.pairs.nodes], limits)
        self.first_number = numbers.start

    def put_on_earlier_chains(self, number: int) -> None:
        """Note the feet of a chain's new nodes; drop its edges that run along earlier chains."""
        candidates = self._candidates(number)
        ends, at_end = self.found.ends[number], self.found.at_end
        meeting = {chain for end in ends for chain in at_end[end]}
        beside = {
            node: [
                pair
                for chain, pair in pairs.items()
                if chain not in meeting or self._is_beside(number, pair)
            ]
            for node, pairs in candidates.items()
        }
        for node, usable in beside.items():
            if usable:
                self._put(node, min(usable))
        path = self.found.paths[number].tolist()
        self._fill_from_end(number, path, candidates, beside)
        self._fill_from_end(number, path[::-1], candidates, beside)
        is_foot = self.foot[path] >= 0
        if not is_foot.any():
            return
        on = [self._lies_on(number, node) for node in path]
        for i, edge in enumerate(self.found.edge_numbers[number]):
            either = is_foot[i] or is_foot[i + 1]
            self.gone[edge] = either and self._connected(on[i], on[i + 1])

    def _put(self, node: int, pair: int) -> None:
        self.foot[node] = self.pairs.segments[pair]
        self.fraction[node] = self.pairs.fractions[pair]

    def _candidates(self, number: int) -> dict[int, dict[int, int]]:
        """The nearest pair for every new node of a chain and every earlier chain in reach of it."""
        row = number - self.first_number
        first, end = self.first_pair[row : row + 2].tolist()
        segments = self.pairs.segments[first:end]
        chains_of_pairs = self.found.of_edge[segments]
        usable = np.flatnonzero((chains_of_pairs < number) & ~self.gone[segments])
        nodes, chains = self.pairs.nodes[first + usable], chains_of_pairs[usable]
        # The first of each node and chain is the nearest.
        _, nearest = np.unique(nodes * number + chains, return_index=True)
        candidates: dict[int, dict[int, int]] = {}
        for pair, node, chain in zip(
            (first + usable[nearest]).tolist(),
            nodes[nearest].tolist(),
            chains[nearest].tolist(),
            strict=True,
        ):
            candidates.setdefault(node, {})[chain] = pair
        return candidates

    def _is_beside(self, number: int, pair: int) -> bool:
        """Whether a node runs along a chain rather than leaving it at their common end."""
        chain = int(self.found.of_edge[self.pairs.segments[pair]])
        node = self.graph.points[self.pairs.nodes[pair]].tolist()
        distance = float(self.pairs.distances[pair])
        return all(
            distance <= LEAVING_RATIO * dist(self.graph.points[end].tolist(), node)
            for end in self.found.ends[number] & self.found.ends[chain]
        )

    def _fill_from_end(
        self,
        number: int,
        path: list[int],
        candidates: dict[int, dict[int, int]],
        beside: dict[int, list[int]],
    ) -> None:
        """Put all nodes from a common end up to the last one that runs along onto the chain."""
        for chain in self._lies_on(number, path[0]):
            reached: list[tuple[int, int]] = []
            last = 0
            for node in path[1:]:
                pair = candidates.get(node, {}).get(chain)
                if pair is None:
                    break
                reached.append((node, pair))
                last = len(reached) if pair in beside[node] else last
            for node, pair in reached[:last]:
                if self.foot[node] < 0:
                    self._put(node, pair)

    def _lies_on(self, number: int, node: int) -> set[int]:
        """The earlier chains on which a node lies."""
        if self.foot[node] >= 0:
            return {int(self.found.of_edge[self.foot[node]])}
        return {chain for chain in self.found.at_end.get(node, ()) if chain < number}

    def _connected(self, some: set[int], others: set[int]) -> bool:
        """Whether a chain of the first set is, or meets, a chain of the second."""
        ends = self.found.ends
        return any(one == other or ends[one] & ends[other] for one in some for other in others)


def _with_feet(graph: LineGraph, merge: _Merge) -> LineGraph:
    """The graph without edges that are gone, and with nodes left at a seam moved onto their
    segment."""
    foot, gone = merge.foot, merge.gone
    needed = np.zeros(len(graph.points), dtype=bool)
    needed[graph.edges[~gone]] = True
    nodes = np.flatnonzero(needed & (foot >= 0))
    segments, fractions = foot[nodes], merge.fraction[nodes]
    points, radius = graph.points.copy(), graph.radius.copy()
    points[nodes], radius[nodes] = graph.interpolated(segments, fractions)
    ends = graph.end_at(segments, fractions)
    inner = ends < 0
    same_as = np.arange(len(points))
    same_as[nodes[~inner]] = ends[~inner]
    for _ in range(len(nodes)):
        if (same_as[same_as] == same_as).all():
            break
        same_as = same_as[same_as]
    edges = split_edges(
        graph.edges, segments[inner], fractions[inner], nodes[inner], np.flatnonzero(gone)
    )
    return LineGraph(points, radius, graph.edges[:0]).with_edges(same_as[edges]).without_isolated()
