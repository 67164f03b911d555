"""One tree from the lines of a centerline file, whatever made it.

The same steps serve every form: weld points that coincide, merge lines that run along each
other, join pieces across small gaps, choose the root, open loops. Tolerances are fractions of
the inscribed radius or of the extent, so that the result does not depend on the unit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import nearest_distances, norm, search_tree
from ..validation import (
    Flags,
    Floats,
    Indices,
    InputError,
    Points,
    as_point,
    as_points,
    coordinates,
)
from .chains import thinned
from .line_graph import LineGraph, near_pairs, reach_of, welded
from .overlaps import OVERLAP_EXTENT, OVERLAP_FRACTION, merged_overlaps
from .point_tree import PointTree, as_radii

GAP_FRACTION = 1.0
"""Pieces are joined across a gap of up to this fraction of the local inscribed radius."""

GAP_EXTENT = 1e-2
"""The same as a fraction of the bounding box's diagonal where no radius is known."""

DENSEST = 0.05
"""Mean spacing of points, over the distance at which lines are one, below which they are thinned:
one in 200 of the radius. Files of VMTK and SimVascular have 0.5 and more."""

WIDER = 1.1
"""Times as wide as every other end from which the widest end is the root, whatever the order in
which a file stores its lines; less may be the way in which ends are measured."""


def tree_from_lines(
    points: ArrayLike,
    lines: Sequence[ArrayLike],
    inscribed_radius: ArrayLike | None = None,
    *,
    inlet: ArrayLike | None = None,
    wall: ArrayLike | None = None,
) -> PointTree:
    """The tree that the lines describe; see `Centerline.from_lines`, which documents it.

    Returns
    -------
    PointTree
        Parents come before their children, branch after branch.
    """
    checked = as_points(points, "centerline points")
    index_lines = _as_lines(lines, len(checked))
    radius = as_radii(inscribed_radius, len(checked))
    is_known = bool(np.isfinite(radius).any())
    if wall is not None and not is_known:
        radius = as_radii(nearest_distances(checked, as_points(wall, "wall")), len(checked))
    graph, line_ends = welded(checked, radius, index_lines)
    end_points = graph.points[line_ends]
    two_point_cells = len(index_lines) > 1 and all(len(line) == 2 for line in index_lines)
    graph, line_ends = _thinned(graph, line_ends[:0] if two_point_cells else line_ends)
    graph = merged_overlaps(graph, line_ends)
    graph = _joined(graph)
    root = _root(graph, end_points, inlet, two_point_cells)
    if inlet is None and not two_point_cells:
        root = _common_begin(graph, [checked[line] for line in index_lines], end_points, root)
    tree = _rooted(graph, root, end_points)
    return tree if is_known else tree._replace(inscribed_radius=np.full(len(tree.points), np.nan))


def _as_lines(lines: Sequence[ArrayLike], point_count: int) -> list[Indices]:
    index_lines = []
    for number, line in enumerate(lines):
        indices = np.asarray(line)
        if indices.size == 0:
            continue
        if indices.ndim != 1 or indices.dtype.kind not in "iu":
            raise InputError(
                f"centerline line {number}: expected a list of point indices, "
                f"got {indices.dtype} of shape {indices.shape}."
            )
        if indices.min() < 0 or indices.max() >= point_count:
            raise InputError(
                f"centerline line {number}: expected point indices from 0 to {point_count - 1}, "
                f"got {indices.min()} to {indices.max()}."
            )
        index_lines.append(indices.astype(np.int64))
    if not index_lines:
        raise InputError(
            f"centerline: expected at least one line, got {point_count} points and no line; "
            "extract the centerline again."
        )
    return index_lines


def _joined(graph: LineGraph) -> LineGraph:
    """One connected graph: gaps below the local radius are bridged, shortest first."""
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    labels = graph.component_labels()
    if labels.max() == 0:
        return graph
    reach = reach_of(graph, GAP_FRACTION, GAP_EXTENT)
    pairs = near_pairs(graph, reach, piece=labels)
    # Shortest bridge per pair of pieces, then the spanning tree over the pieces.
    pairs = pairs.selected(np.argsort(pairs.distances, kind="stable"))
    here, there = labels[pairs.nodes], labels[graph.edges[pairs.segments, 0]]
    couples = np.sort(np.column_stack([here, there]), axis=1)
    couples, first = np.unique(couples, axis=0, return_index=True)
    pairs = pairs.selected(first)
    count = labels.max() + 1
    weights = np.zeros((count, count))
    # A bridge of no length would read as no bridge in a graph matrix, hence the ranks.
    weights[couples[:, 0], couples[:, 1]] = 1.0 + np.argsort(np.argsort(pairs.distances))
    used = minimum_spanning_tree(weights).toarray()[couples[:, 0], couples[:, 1]] > 0
    if used.sum() < count - 1:
        groups = connected_components(weights, directed=False)[1]
        _refuse_gap(graph, groups[labels], reach)
    return graph.bridged(pairs.selected(used))


def _refuse_gap(graph: LineGraph, labels: Indices, reach: Floats) -> None:
    """Name the gap between the largest piece and the piece nearest to it."""
    from scipy.spatial import cKDTree

    largest = np.bincount(labels).argmax()
    inside, outside = np.flatnonzero(labels == largest), np.flatnonzero(labels != largest)
    distances, nearest = cKDTree(graph.points[inside]).query(graph.points[outside])
    closest = distances.argmin()
    here, there = outside[closest], inside[nearest[closest]]
    place = (graph.points[here] + graph.points[there]) / 2
    raise InputError(
        f"centerline: expected connected lines, got {labels.max() + 1} pieces with a gap of "
        f"{distances[closest]:.3g} mm at {coordinates(place)}, wider "
        f"than the {max(reach[here], reach[there]):.3g} mm that are bridged there; connect the "
        "lines or give one piece only."
    )


def _root(
    graph: LineGraph, line_ends: Floats, inlet: ArrayLike | None, two_point_cells: bool
) -> int:
    """The node where the tree starts; the rules are in `Centerline.from_lines`."""
    leaves = np.flatnonzero(graph.degrees() == 1)
    if not len(leaves):
        place = ", ".join(f"{value:.4g}" for value in line_ends[0, 0])
        raise InputError(
            "centerline: expected a line with two ends, got a closed loop, which ends where it "
            f"begins, at ({place}); take a part of it."
        )
    if inlet is not None:
        distances = np.linalg.norm(graph.points[leaves] - as_point(inlet, "inlet"), axis=1)
        return int(leaves[distances.argmin()])
    radius = np.nan_to_num(graph.radius[leaves], nan=0.0)
    second = np.sort(radius)[-2] if len(radius) > 1 and radius.min() > 0 else np.inf
    is_widest = radius > WIDER * second
    if two_point_cells and leaves[0] == 0 and not is_widest.any():
        return 0
    starts = ends = np.zeros(len(leaves), dtype=np.int64)
    if not two_point_cells:
        starts = _lines_at(graph, leaves, line_ends[:, 0])
        ends = _lines_at(graph, leaves, line_ends[:, 1])
    # Most common end of lines, then one that is clearly the widest: both are the same for lines
    # that are stored backward. Then rather the start of lines, then the widest, then the first.
    order = np.lexsort((leaves, -radius, -starts, ~is_widest, -np.maximum(starts, ends)))
    return int(leaves[order[0]])


def _common_begin(graph: LineGraph, lines: Sequence[Points], line_ends: Floats, root: int) -> int:
    """The node where more lines begin, or end, than at the root, and that no other line passes.

    Lines that begin at places of one inlet cross before they are one, so that no end of the graph
    may be left there.
    """
    reach = GAP_EXTENT * graph.extent()
    sides = line_ends.transpose(1, 0, 2)
    most = max(int((norm(ends - graph.points[root]) <= reach).sum()) for ends in sides)
    for ends, others in zip(sides, sides[::-1], strict=True):
        together = np.linalg.norm(ends[:, None] - ends, axis=2) <= reach
        counts = together.sum(axis=1)
        begins, count = together[int(counts.argmax())], int(counts.max())
        if count <= most:
            continue
        middle = ends[begins].mean(axis=0)
        passes = np.array([norm(line - middle).min() <= reach for line in lines]) & ~begins
        passes |= norm(others - middle) <= reach
        if not passes.any():
            most, root = count, int(norm(graph.points - middle).argmin())
    return root


def _lines_at(graph: LineGraph, leaves: Indices, points: Points) -> Indices:
    """How many of the points lie at each leaf, that is within its radius and nearest to it."""
    from scipy.spatial import cKDTree

    distances, nearest = cKDTree(graph.points[leaves]).query(points)
    near = distances <= reach_of(graph, GAP_FRACTION, GAP_EXTENT)[leaves[nearest]]
    return np.bincount(nearest[near], minlength=len(leaves))


def _rooted(graph: LineGraph, root: int, line_ends: Floats) -> PointTree:
    """Shortest way from the root to every node; spurs that end where no line does are dropped."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import depth_first_order, dijkstra

    _, parent = dijkstra(graph.matrix(), directed=False, indices=root, return_predecessors=True)
    parent = np.where(parent < 0, -1, parent).astype(np.int64)
    at_inlet = max(reach_of(graph, GAP_FRACTION, GAP_EXTENT)[root], GAP_EXTENT * graph.extent())
    at_root = np.linalg.norm(line_ends - graph.points[root], axis=2) <= at_inlet
    # But the ends at the root of lines that begin there.
    meant = line_ends[~(at_root & ~at_root[:, ::-1])]
    is_inlet = norm(graph.points - graph.points[root]) <= at_inlet
    kept = _without_spurs(graph, parent, meant, is_inlet)
    children = np.flatnonzero(kept & (parent >= 0))
    count = len(parent)
    links = csr_matrix((np.ones(len(children)), (parent[children], children)), (count, count))
    order = depth_first_order(links, root, return_predecessors=False).astype(np.int64)
    new_index = np.full(count + 1, -1, dtype=np.int64)
    new_index[order] = np.arange(len(order))
    return PointTree(graph.points[order], graph.radius[order], new_index[parent[order]])


def _without_spurs(graph: LineGraph, parent: Indices, ends: Floats, is_inlet: Flags) -> Flags:
    """Which nodes stay: dead ends made by opening a loop, or by merging lines that part for a
    moment, go when inside their junction's sphere or at the inlet, where a cap leaves no sphere, or
    all along beside another line, in a lumen that is told by it."""
    kept = np.ones(len(parent), dtype=bool)
    child_count = np.bincount(parent[parent >= 0], minlength=len(parent))
    reach = reach_of(graph, GAP_FRACTION, GAP_EXTENT)
    steps = np.linalg.norm(graph.points - graph.points[parent], axis=1).tolist()
    above_of = parent.tolist()
    dead_ends = np.flatnonzero(child_count == 0)
    is_meant = _lines_at(graph, dead_ends, ends) > 0
    spurs = dead_ends[(graph.degrees()[dead_ends] > 1) | ~is_meant].tolist()
    if not spurs:
        return kept
    everywhere = search_tree(graph.points)
    # Ends: a node comes in when it loses its last child, once.
    while spurs:
        spur, size = [spurs.pop()], 0.0
        # Ends: shortest ways lead to the root.
        while above_of[spur[-1]] >= 0 and child_count[spur[-1]] <= (len(spur) > 1):
            size += steps[spur[-1]]
            spur.append(above_of[spur[-1]])
        *own, junction = spur
        if not own:
            continue
        kept[own] = False
        if size > reach[junction] and not is_inlet[own].all():
            near = everywhere.query_ball_point(graph.points[own], reach[own])
            if not all(kept[one].any() for one in near):
                kept[own] = True
                continue
        child_count[junction] -= 1
        if child_count[junction] == 0:
            spurs.append(junction)
    return kept


def _thinned(graph: LineGraph, line_ends: Indices) -> tuple[LineGraph, Indices]:
    """The graph with no more points than are needed, and the ends of the lines in it."""
    spacing = reach_of(graph, DENSEST * OVERLAP_FRACTION, DENSEST * OVERLAP_EXTENT)
    return thinned(graph, line_ends, spacing)
