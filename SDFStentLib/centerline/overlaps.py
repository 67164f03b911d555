"""Lines of one vessel that run along each other become one line, up to where they part."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Indices
from .line_graph import LineGraph, NearPairs, half_edges, near_pairs, reach_of, split_edges

OVERLAP_FRACTION = 0.1
"""Lines nearer to each other than this fraction of the inscribed radius are one line."""

OVERLAP_EXTENT = 1e-3
"""The same as a fraction of the bounding box's diagonal where no radius is known."""

LEAVING_RATIO = 0.5
"""From a common end two lines overlap while their distance is below this fraction of the way."""


class _Chains(NamedTuple):
    """Node paths, longest first, and the number of the path to which each edge belongs."""

    paths: list[Indices]
    edge_numbers: list[Indices]
    of_edge: Indices
    at_end: dict[int, set[int]]
    ends: list[set[int]]


def merged_overlaps(graph: LineGraph, line_ends: Indices) -> LineGraph:
    """The graph in which lines that run along a longer one are part of it.

    A node within `OVERLAP_FRACTION` of the radius of a longer line's segment lies on that line.
    Where a line leaves the longer one, its last such node is moved onto it and inserted there.

    Parameters
    ----------
    graph : LineGraph
        Welded lines.
    line_ends : array of nodes
        Where lines of the file start or end: lines that touch there are compared as well.
    """
    pairs = near_pairs(graph, reach_of(graph, OVERLAP_FRACTION, OVERLAP_EXTENT))
    if len(pairs.nodes) == 0:
        return graph
    graph, pairs = _without_chords(graph, pairs)
    stops = np.zeros(len(graph.points), dtype=bool)
    stops[line_ends] = True
    found = _ranked_chains(graph, stops)
    first_chain = np.zeros(len(graph.points), dtype=np.int64)
    for number in reversed(range(len(found.paths))):
        first_chain[found.paths[number]] = number
    pairs = pairs.selected(np.lexsort((pairs.distances, first_chain[pairs.nodes])))
    limits = np.arange(len(found.paths) + 1)
    merge = _Merge(
        graph=graph,
        found=found,
        pairs=pairs,
        first_pair=np.searchsorted(first_chain[pairs.nodes], limits),
        foot=np.full(len(graph.points), -1, dtype=np.int64),
        gone=np.zeros(len(graph.edges), dtype=bool),
    )
    for number in range(len(found.paths)):
        merge.put_on_earlier_chains(number)
    return _with_feet(graph, merge)


def _without_chords(graph: LineGraph, pairs: NearPairs) -> tuple[LineGraph, NearPairs]:
    """Drop edges, longest first, whose two ends are connected through nodes beside them.

    So a coarse line that shares some points with a finer one adds nothing to it.
    """
    neighbors = _NeighborSets(graph)
    branching = graph.degrees()[graph.edges].max(axis=1) > 2
    order = np.argsort(pairs.segments, kind="stable")
    nodes, limits = pairs.nodes[order], np.arange(len(graph.edges) + 1)
    bounds = np.searchsorted(pairs.segments[order], limits)
    kept = np.ones(len(graph.edges), dtype=bool)
    longest_first = np.argsort(-graph.edge_lengths(), kind="stable")
    may_be = branching & (bounds[:-1] < bounds[1:])
    for edge in longest_first[may_be[longest_first]]:
        a, b = graph.edges[edge].tolist()
        beside = set(nodes[bounds[edge] : bounds[edge + 1]].tolist())
        if _meet(neighbors, a, b, beside):
            kept[edge] = False
            neighbors[a].discard(b)
            neighbors[b].discard(a)
    new_number = np.cumsum(kept) - 1
    pairs = pairs.selected(kept[pairs.segments])
    return (
        graph._replace(edges=graph.edges[kept]),
        pairs._replace(segments=new_number[pairs.segments]),
    )


class _NeighborSets(dict[int, set[int]]):
    """The nodes next to a node, looked up when first asked for."""

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


@dataclass
class _Merge:
    """The state of one merge: per node the pair that puts it on an earlier chain, edges gone.

    Pairs are sorted by the first chain that has their node, then by distance; `first_pair` tells
    where those of each chain begin.
    """

    graph: LineGraph
    found: _Chains
    pairs: NearPairs
    first_pair: Indices
    foot: Indices
    gone: NDArray[np.bool_]

    def put_on_earlier_chains(self, number: int) -> None:
        """Enter the feet of a chain's new nodes; drop its edges that run along earlier chains."""
        candidates = self._candidates(number)
        beside = {
            node: [pair for pair in pairs.values() if self._is_beside(number, pair)]
            for node, pairs in candidates.items()
        }
        for node, usable in beside.items():
            if usable:
                self.foot[node] = min(usable)
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

    def _candidates(self, number: int) -> dict[int, dict[int, int]]:
        """Per new node and earlier chain in reach the nearest pair."""
        first, end = self.first_pair[number : number + 2].tolist()
        segments = self.pairs.segments[first:end]
        chains_of_pairs = self.found.of_edge[segments]
        usable = np.flatnonzero((chains_of_pairs < number) & ~self.gone[segments])
        candidates: dict[int, dict[int, int]] = {}
        for pair, node, chain in zip(
            (first + usable).tolist(),
            self.pairs.nodes[first + usable].tolist(),
            chains_of_pairs[usable].tolist(),
            strict=True,
        ):
            candidates.setdefault(node, {}).setdefault(chain, pair)
        return candidates

    def _is_beside(self, number: int, pair: int) -> bool:
        """Whether the node runs along the chain rather than leaves it at their common end."""
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
        """From a common end on, all nodes up to the last one that runs along are on the chain."""
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
                    self.foot[node] = pair

    def _lies_on(self, number: int, node: int) -> set[int]:
        """The earlier chains on which a node lies."""
        if self.foot[node] >= 0:
            return {int(self.found.of_edge[self.pairs.segments[self.foot[node]]])}
        return {chain for chain in self.found.at_end.get(node, ()) if chain < number}

    def _connected(self, some: set[int], others: set[int]) -> bool:
        """Whether a chain of the first set is, or meets, one of the second."""
        ends = self.found.ends
        return any(one == other or ends[one] & ends[other] for one in some for other in others)


def _with_feet(graph: LineGraph, merge: _Merge) -> LineGraph:
    """Drop the edges that are gone; move the nodes that are left at a seam onto their segment."""
    pairs, foot, gone = merge.pairs, merge.foot, merge.gone
    needed = np.zeros(len(graph.points), dtype=bool)
    needed[graph.edges[~gone]] = True
    nodes = np.flatnonzero(needed & (foot >= 0))
    segments, fractions = pairs.segments[foot[nodes]], pairs.fractions[foot[nodes]]
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


def _ranked_chains(graph: LineGraph, stops: NDArray[np.bool_]) -> _Chains:
    """The chains between ends, branchings and stops of the graph, longest first."""
    count = len(graph.points)
    paths = chains(graph.edges, count, stops)
    lengths = [np.linalg.norm(np.diff(graph.points[path], axis=0), axis=1).sum() for path in paths]
    paths = [paths[i] for i in np.argsort(-np.array(lengths), kind="stable")]
    codes = graph.edges[:, 0] * count + graph.edges[:, 1]
    edge_numbers, at_end = [], dict[int, set[int]]()
    of_edge = np.empty(len(graph.edges), dtype=np.int64)
    for number, path in enumerate(paths):
        low, high = np.minimum(path[:-1], path[1:]), np.maximum(path[:-1], path[1:])
        edge_numbers.append(np.searchsorted(codes, low * count + high))
        of_edge[edge_numbers[-1]] = number
        for end in (int(path[0]), int(path[-1])):
            at_end.setdefault(end, set()).add(number)
    ends = [{int(path[0]), int(path[-1])} for path in paths]
    return _Chains(paths, edge_numbers, of_edge, at_end, ends)


def chains(edges: Indices, count: int, stops: NDArray[np.bool_]) -> list[Indices]:
    """Node paths between ends, branchings and stops; then rings that have none of these."""
    table = half_edges(edges, count)
    degree = np.diff(table.starts)
    is_stop = (degree != 2) | stops
    # Of the others the two neighbors; of stops whatever stands there.
    last = max(len(table.points) - 1, 0)
    one, other = (table.points[np.minimum(table.starts[:-1] + k, last)].tolist() for k in (0, 1))
    ends, seen = is_stop.tolist(), np.zeros(count, dtype=bool)
    done: set[tuple[int, int]] = set()
    paths = []

    def follow(start: int) -> None:
        for step in table.of(start):
            if (start, step) in done:
                continue
            path = [start, step]
            # Ends: on nodes with two neighbors, a way that has no end closes.
            while not ends[path[-1]] and path[-1] != start:
                node = path[-1]
                path.append(other[node] if one[node] == path[-2] else one[node])
            done.add((path[-1], path[-2]))
            paths.append(np.array(path, dtype=np.int64))
            seen[paths[-1]] = True

    for start in np.flatnonzero(is_stop).tolist():
        follow(start)
    for start in np.flatnonzero(~seen & ~is_stop).tolist():
        if not seen[start]:
            follow(start)
    return paths
