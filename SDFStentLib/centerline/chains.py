"""The lines of a graph between its ends and branchings, no denser than the width requires."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Floats, Indices
from .line_graph import LineGraph, half_edges


class Chains(NamedTuple):
    """Node paths, longest first, with their edges, the path of every edge, and the paths at every
    end."""

    paths: list[Indices]
    edge_numbers: list[Indices]
    of_edge: Indices
    at_end: dict[int, set[int]]
    ends: list[set[int]]


def ranked_chains(graph: LineGraph, stops: NDArray[np.bool_]) -> Chains:
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
    return Chains(paths, edge_numbers, of_edge, at_end, ends)


def chains(edges: Indices, count: int, stops: NDArray[np.bool_]) -> list[Indices]:
    """Node paths between ends, branchings and stops; then rings that have none of these."""
    table = half_edges(edges, count)
    degree = np.diff(table.starts)
    is_stop = (degree != 2) | stops
    # The two neighbors of every node; for stops any two numbers will do.
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


def thinned(graph: LineGraph, line_ends: Indices, spacing: Floats) -> tuple[LineGraph, Indices]:
    """The graph with points left out where they follow each other more closely than a spacing.

    The work on a graph grows with the number of points near each other: a line of 100,000 points
    over 40 mm has 150 million such pairs. Only graphs that are this dense on the whole are thinned;
    a few dense points, as where lines of a file run along each other, do no harm. Ends, junctions
    and ends of the file's lines stay.

    Parameters
    ----------
    graph : LineGraph
        Welded lines.
    line_ends : array of nodes
    spacing : (n,) array
        Spacing at every node, mm.

    Returns
    -------
    LineGraph, array of nodes
        The thinned graph, and `line_ends` in its numbers.
    """
    steps = graph.edge_lengths() / spacing[graph.edges].min(axis=1)
    if steps.mean() >= 1:
        return graph, line_ends
    stops = np.zeros(len(graph.points), dtype=bool)
    stops[line_ends] = True
    edges = []
    for path in chains(graph.edges, len(graph.points), stops):
        sides = np.linalg.norm(np.diff(graph.points[path], axis=0), axis=1)
        steps = sides / np.minimum(spacing[path[1:]], spacing[path[:-1]])
        # A point farther from the one before it than the spacing begins another step.
        numbers = np.floor(np.concatenate([[0.0], np.cumsum(steps)]))
        is_kept = np.concatenate([[True], numbers[1:] > numbers[:-1]])
        is_kept[-1] = True
        if path[0] == path[-1] and is_kept.sum() < 4:
            is_kept[:] = True  # a ring stays one
        kept = path[is_kept]
        edges.append(np.column_stack([kept[:-1], kept[1:]]))
    kept_edges = np.concatenate(edges)
    used = np.unique(kept_edges)
    thin = graph._replace(edges=graph.edges[:0]).with_edges(kept_edges).without_isolated()
    return thin, np.searchsorted(used, line_ends)
