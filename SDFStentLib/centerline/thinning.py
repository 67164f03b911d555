"""Points of lines that are denser than the vessel's width can tell."""

from __future__ import annotations

import numpy as np

from ..validation import Floats, Indices
from .chains import chains
from .line_graph import LineGraph


def thinned(graph: LineGraph, line_ends: Indices, spacing: Floats) -> tuple[LineGraph, Indices]:
    """The graph, where points follow each other more closely than a spacing, without most of them.

    The work on a graph goes with the number of points near each other: a line of 100,000 points
    over 40 mm has 150 million such pairs. Only lines that are as dense on the whole are thinned; a
    few such points, as where files' lines run along each other, do no harm. Ends, junctions and
    ends of the file's lines stay.

    Parameters
    ----------
    graph : LineGraph
        Welded lines.
    line_ends : array of nodes
    spacing : (n,) array
        At every node, mm.

    Returns
    -------
    LineGraph, array of nodes
        The latter are `line_ends` in it.
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
