"""The graph of a centerline file's lines: points welded, edges, and which nodes lie near which
edges."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry import box_of, component_labels, distances_to_segments, in_one_row, norm
from ..validation import Floats, Indices, InputError, Points
from .point_tree import NeighborTable, mixed_radius

WELD_EXTENT = 1e-6
"""Distance, over the bounding box's diagonal, below which two points are one point."""


PAIRS = 1 << 18
"""Pairs of a node and a segment compared at once: some ten MB."""


class Bridges(NamedTuple):
    """Pairs of a node and a segment near it that it does not end, with fraction and
    distance, mm."""

    nodes: Indices
    segments: Indices
    fractions: Floats
    distances: Floats

    def selected(self, which: NDArray[np.generic]) -> Bridges:
        """The pairs that a mask or an index array picks."""
        return Bridges(*(column[which] for column in self))


class LineGraph(NamedTuple):
    """Nodes with a radius (NaN where unknown), and undirected edges (m, 2), each once, no
    self-loops."""

    points: Points
    radius: Floats
    edges: Indices

    def degrees(self) -> Indices:
        """Number (n,) of edges at each node."""
        return np.bincount(self.edges.ravel(), minlength=len(self.points))

    def edge_lengths(self) -> Floats:
        """Length (m,) of each edge, mm."""
        return np.linalg.norm(self.points[self.edges[:, 0]] - self.points[self.edges[:, 1]], axis=1)

    def extent(self) -> float:
        """Diagonal of the bounding box, mm."""
        return float(np.linalg.norm(np.subtract(*box_of(self.points))))

    def neighbors(self) -> NeighborTable:
        """The nodes next to each, in the order of the edges."""
        return half_edges(self.edges, len(self.points))

    def matrix(self) -> Any:
        """Edge lengths as a sparse matrix (one entry per edge), for scipy's graph functions."""
        # SciPy is imported where it is used, throughout: it would slow every start of the program.
        from scipy.sparse import csr_matrix

        shape = (len(self.points), len(self.points))
        return csr_matrix((self.edge_lengths(), (self.edges[:, 0], self.edges[:, 1])), shape)

    def component_labels(self) -> Indices:
        """Number (n,) of the connected piece of every node."""
        return component_labels(len(self.points), self.edges[:, 0], self.edges[:, 1])

    def with_edges(self, more: Indices) -> LineGraph:
        """The graph with edges added; self-loops and doubles are left out."""
        return self._replace(edges=_unique_edges(np.concatenate([self.edges, more])))

    def bridged(self, bridges: Bridges) -> LineGraph:
        """The graph with each pair's node joined to its segment, which is split at the foot.

        An end of the segment serves as the foot where the two coincide, and the node itself does
        where it lies on the segment.
        """
        edges, fractions = bridges.segments, bridges.fractions
        feet, radius = self.interpolated(edges, fractions)
        nodes = self.end_at(edges, fractions)
        inner = nodes < 0
        on_segment = inner & (bridges.distances <= WELD_EXTENT * self.extent())
        nodes[on_segment] = bridges.nodes[on_segment]
        new = np.flatnonzero(inner & ~on_segment)
        nodes[new] = len(self.points) + np.arange(len(new))
        split = split_edges(self.edges, edges[inner], fractions[inner], nodes[inner])
        return LineGraph(
            np.concatenate([self.points, feet[new]]),
            np.concatenate([self.radius, radius[new]]),
            _unique_edges(np.concatenate([split, np.column_stack([bridges.nodes, nodes])])),
        )

    def interpolated(self, edges: Indices, fractions: Floats) -> tuple[Points, Floats]:
        """Points and radii on edges; where one end has no radius, that of the other end."""
        starts, ends = self.edges[edges].T
        weights = fractions[:, None]
        feet = (1.0 - weights) * self.points[starts] + weights * self.points[ends]
        return feet, mixed_radius(self.radius[starts], self.radius[ends], fractions)

    def end_at(self, edges: Indices, fractions: Floats) -> Indices:
        """End (k,) of the edge with which a point on it coincides; -1 for a point in between."""
        ends = self.edges[edges, (fractions >= 0.5).astype(np.int64)]
        to_end = np.minimum(fractions, 1.0 - fractions) * self.edge_lengths()[edges]
        return np.where(to_end <= WELD_EXTENT * self.extent(), ends, -1)

    def without_isolated(self) -> LineGraph:
        """The graph without nodes that have no edge; the others keep their order."""
        used, edges = np.unique(self.edges, return_inverse=True)
        return LineGraph(self.points[used], self.radius[used], edges.reshape(-1, 2))


def half_edges(edges: Indices, count: int) -> NeighborTable:
    """The nodes next to each of `count` nodes, in the order of the edges (m, 2)."""
    order = np.argsort(edges.ravel(), kind="stable")
    starts = np.searchsorted(edges.ravel()[order], np.arange(count + 1))
    return NeighborTable(starts, edges[:, ::-1].ravel()[order])


def reach_of(graph: LineGraph, fraction: float, extent_fraction: float) -> Floats:
    """Fraction (n,) of every node's radius, or of the extent where that is unknown, mm."""
    known = fraction * graph.radius
    return np.where(np.isnan(known), extent_fraction * graph.extent(), known)


def welded(points: Points, radius: Floats, lines: list[Indices]) -> tuple[LineGraph, Indices]:
    """The graph of the lines, in which coincident points are one node.

    Returns
    -------
    LineGraph, array of shape (number of lines, 2)
        Nodes keep the order in which their points are stored; first and last node of each line.

    Raises
    ------
    InputError
        All points of the lines coincide.
    """
    used, compact = np.unique(np.concatenate(lines), return_inverse=True)
    tolerance = WELD_EXTENT * float(np.linalg.norm(np.ptp(points[used], axis=0)))
    node_of = _coincident(points[used], tolerance)
    nodes = node_of[compact.ravel()]
    lasts = np.cumsum([len(line) for line in lines]) - 1
    steps = np.column_stack([nodes[:-1], nodes[1:]])
    edges = _unique_edges(np.delete(steps, lasts[:-1], axis=0))
    if len(edges) == 0:
        raise InputError(
            "centerline: expected a line through at least two different points, got "
            f"{len(used)} point(s) at one place; extract the centerline again."
        )
    _, first = np.unique(node_of, return_index=True)
    node_radius = np.full(len(first), np.nan)
    np.fmax.at(node_radius, node_of, radius[used])
    firsts = np.concatenate([[0], lasts[:-1] + 1])
    graph = LineGraph(points[used][first], node_radius, edges)
    return graph, np.column_stack([nodes[firsts], nodes[lasts]])


def _coincident(points: Points, tolerance: float) -> Indices:
    """Node number of each point, in stored order; points within the tolerance share one."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    # Rounding first bounds the number of pairs, however many points lie at one place.
    cells = np.round((points - box_of(points)[0]) / max(tolerance, np.finfo(float).tiny))
    # There are at most 1 / WELD_EXTENT cells a side, so that one number identifies a cell.
    x, y, z = cells.astype(np.int64).T
    side = int(1 / WELD_EXTENT) + 2
    cell = (x * side + y) * side + z
    _, first, cell_of = np.unique(cell, return_index=True, return_inverse=True)
    pairs = cKDTree(points[first]).query_pairs(tolerance, output_type="ndarray")
    links = csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(first), len(first)))
    labels = connected_components(links, directed=False)[1][cell_of.ravel()]
    _, first_use, number = np.unique(labels, return_index=True, return_inverse=True)
    as_stored = np.empty(len(first_use), dtype=np.int64)
    as_stored[np.argsort(first_use)] = np.arange(len(first_use))
    return as_stored[number.ravel()]


def _unique_edges(edges: Indices) -> Indices:
    first, last = edges[edges[:, 0] != edges[:, 1]].T
    low, high = np.minimum(first, last), np.maximum(first, last)
    # One number per edge is sorted several times faster than rows of two.
    base = int(high.max(initial=0)) + 1
    return np.column_stack(np.divmod(np.unique(low * base + high), base))


def split_edges(
    edges: Indices,
    which: Indices,
    fractions: Floats,
    nodes: Indices,
    without: Indices | tuple[int, ...] = (),
) -> Indices:
    """Edges (m, 2) with nodes inserted into some, at fractions counted from their first end.

    Edge `which[i]` gets `nodes[i]` at `fractions[i]`; the edges `without` are left out.
    """
    parts = [np.delete(edges, np.concatenate([which, without]).astype(np.int64), axis=0)]
    order = np.lexsort((fractions, which))
    for edge in np.unique(which):
        inner = nodes[order[which[order] == edge]]
        path = np.concatenate([edges[edge, :1], inner, edges[edge, 1:]])
        parts.append(np.column_stack([path[:-1], path[1:]]))
    return _unique_edges(np.concatenate(parts))


def near_pairs(
    graph: LineGraph,
    reach: Floats,
    piece: Indices | None = None,
    *,
    nodes: Indices | None = None,
    edges: Indices | None = None,
) -> Bridges:
    """Pairs of a node and a segment that it does not end, within reach of the segment's wider end.

    Dense points of wide vessels have hundreds of neighbors each: so the pairs are looked at in
    blocks, and only those within reach are kept.

    Parameters
    ----------
    graph : LineGraph
    reach : (n,) array
        Reach of every node, mm.
    piece : (n,) array, optional
        Piece to which every node belongs: then only pairs between different pieces count.
    nodes, edges : arrays of int, optional
        The only nodes and edges to look at, each once; by default all.
    """
    from scipy.spatial import cKDTree

    if nodes is None:
        nodes = np.arange(len(graph.points))
    if edges is None:
        edges = np.arange(len(graph.edges))
    nothing = np.empty(0, dtype=np.int64)
    if not len(nodes) or not len(edges):
        return Bridges(nothing, nothing, np.empty(0), np.empty(0))
    tree, ends = cKDTree(graph.points[nodes]), graph.edges[edges]
    starts, stops = graph.points[ends[:, 0]], graph.points[ends[:, 1]]
    limits = reach[ends].max(axis=1)
    centers, radii = (starts + stops) / 2, norm(stops - starts) / 2 * (1 + 1e-9) + limits
    found = []
    for part in _blocks(tree.query_ball_point(centers, radii, return_length=True)):
        which, rows = _within(tree, centers, radii, part)
        near = nodes[which]
        other = (near[:, None] != ends[rows]).all(axis=1)
        if piece is not None:
            other &= piece[near] != piece[ends[rows, 0]]
        near, rows = near[other], rows[other]
        squared, fractions = distances_to_segments(graph.points[near], starts[rows], stops[rows])
        pairs = Bridges(near, edges[rows], fractions, np.sqrt(squared))
        found.append(pairs.selected(pairs.distances <= limits[rows]))
    return Bridges(*(np.concatenate(column) for column in zip(*found, strict=True)))


def pairs_within(graph: LineGraph, reach: Floats, edges: Indices) -> int:
    """An estimate of the number of pairs that `near_pairs` looks at for some edges."""
    from scipy.spatial import cKDTree

    ends = graph.edges[edges]
    starts, stops = graph.points[ends[:, 0]], graph.points[ends[:, 1]]
    radii = norm(stops - starts) / 2 + reach[ends].max(axis=1)
    tree = cKDTree(graph.points)
    return int(tree.query_ball_point((starts + stops) / 2, radii, return_length=True).sum())


def _blocks(counts: Indices) -> Iterator[slice]:
    """Slices of a row of counts whose sums are about `PAIRS` at most; at least one slice."""
    block = np.cumsum(counts) // PAIRS
    bounds = np.flatnonzero(np.diff(block)) + 1
    for start, end in pairwise([0, *bounds.tolist(), len(counts)]):
        yield slice(start, end)


def _within(tree: Any, centers: Points, radii: Floats, part: slice) -> tuple[Indices, Indices]:
    """Points of a tree within radii of some centers, and for each the number of its center."""
    found = tree.query_ball_point(centers[part], radii[part], return_sorted=True)
    numbers, nodes = in_one_row(found)
    return nodes, part.start + numbers
