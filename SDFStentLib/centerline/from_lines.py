"""Centerline tree from the lines of a file, whichever program wrote it.

The same steps serve every form: weld points that coincide, merge lines that run along each
other, join pieces across small gaps, choose the root, open loops. Tolerances are fractions of
the inscribed radius or of the extent, so that the result does not depend on the unit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import nearest_distances, norm, search_tree
from ..validation import Flags, Floats, Indices, InputError, Points, as_points, coordinates, plain
from .chains import thinned
from .line_graph import WELD_EXTENT, LineGraph, near_pairs, reach_of, welded
from .loops import opened_where_they_meet
from .overlaps import OVERLAP_EXTENT, OVERLAP_FRACTION, merged_overlaps
from .point_tree import PointTree, as_radii, sums_to_root
from .root import FileLines, Widths, ends_at, root_of

GAP_FRACTION = 1.0
"""Length of a spur, over the inscribed radius, up to which it counts as within its junction."""

JOINED_FRACTION = 2.0
"""Largest gap, in radii, across which pieces are joined: the diameter of a sphere. Without their
parts within the sphere of a junction, pieces of VMTK's lines are up to 1.0 radii of it apart."""

GAP_EXTENT = 1e-2
"""The same as a fraction of the bounding box's diagonal where no radius is known."""

DENSEST = 0.05
"""Mean spacing of points, over the distance at which lines are one, below which they are thinned:
one in 200 of the radius. Files of VMTK and SimVascular have 0.5 and more."""


def tree_from_lines(
    points: ArrayLike,
    lines: Sequence[ArrayLike],
    inscribed_radius: ArrayLike | None = None,
    inlet: ArrayLike | None = None,
    wall: ArrayLike | None = None,
    widths: Widths | None = None,
) -> PointTree:
    """The tree that the lines describe; documented at `Centerline.from_lines`.

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
    checked, radius, index_lines = _in_order(checked, radius, index_lines)
    graph, line_ends = welded(checked, radius, index_lines)
    graph = graph._replace(radius=_filled(graph))
    two_point_cells = len(index_lines) > 1 and all(len(line) == 2 for line in index_lines)
    ends = FileLines(graph.points[line_ends], two_point_cells or len(index_lines) == 1)
    tips = graph.points[graph.degrees() == 1]
    graph, line_ends = _thinned(graph, line_ends[:0] if two_point_cells else line_ends)
    graph = merged_overlaps(graph, line_ends)
    graph, bridges = _joined(graph)
    if len(bridges):
        tips = tips[nearest_distances(tips, bridges) > GAP_EXTENT * graph.extent()]
    tree = _rooted(graph, root_of(graph, ends, tips, inlet, widths), tips)
    return tree if is_known else tree._replace(inscribed_radius=np.full(len(tree.points), np.nan))


def _in_order(
    points: Points, radius: Floats, lines: list[Indices]
) -> tuple[Points, Floats, list[Indices]]:
    """The same lines with their points in an order that does not depend on that of the file.

    All further steps go by the numbers of points where nothing else distinguishes two of them.
    """
    order = np.lexsort((radius, *points.T))
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return points[order], radius[order], [rank[line] for line in lines]


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


def _filled(graph: LineGraph) -> Floats:
    """Radii (n,), missing ones filled from the nearest known point."""
    known = np.isfinite(graph.radius)
    if known.all() or not known.any():
        return graph.radius
    nearest = search_tree(graph.points[known]).query(graph.points)[1]
    return graph.radius[known][nearest]


def _joined(graph: LineGraph) -> tuple[LineGraph, Points]:
    """The graph, joined across gaps within a sphere, shortest first, and the places of the
    bridges."""
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    labels = graph.component_labels()
    if labels.max() == 0:
        return graph, graph.points[:0]
    reach = reach_of(graph, JOINED_FRACTION, GAP_EXTENT)
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
    pairs = pairs.selected(used)
    feet, _ = graph.interpolated(pairs.segments, pairs.fractions)
    return graph.bridged(pairs), np.concatenate([graph.points[pairs.nodes], feet])


def _refuse_gap(graph: LineGraph, labels: Indices, reach: Floats) -> None:
    """Raise an error that names the gap between the largest piece and the one nearest to it."""
    from scipy.spatial import cKDTree

    largest = np.bincount(labels).argmax()
    inside, outside = np.flatnonzero(labels == largest), np.flatnonzero(labels != largest)
    distances, nearest = cKDTree(graph.points[inside]).query(graph.points[outside])
    closest = distances.argmin()
    here, there = outside[closest], inside[nearest[closest]]
    place = (graph.points[here] + graph.points[there]) / 2
    gap, bridged = plain(distances[closest], ".3g"), plain(max(reach[here], reach[there]), ".3g")
    raise InputError(
        f"centerline: expected connected lines, got {labels.max() + 1} pieces with a gap of "
        f"{gap} mm at {coordinates(place)}, wider "
        f"than the {bridged} mm that are bridged there; connect the "
        "lines or give one piece only."
    )


def _rooted(graph: LineGraph, root: int, tips: Points) -> PointTree:
    """The tree of shortest ways from the root to every node, without spurs that end where no line
    does.

    Where it divides, the longest way comes first.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import depth_first_order, dijkstra

    away, parent = dijkstra(graph.matrix(), directed=False, indices=root, return_predecessors=True)
    parent = np.where(parent < 0, -1, parent).astype(np.int64)
    at_inlet = max(reach_of(graph, GAP_FRACTION, GAP_EXTENT)[root], GAP_EXTENT * graph.extent())
    is_inlet = norm(graph.points - graph.points[root]) <= at_inlet
    kept = _without_spurs(graph, parent, tips[norm(tips - graph.points[root]) > at_inlet], is_inlet)
    reach = reach_of(graph, GAP_FRACTION, GAP_EXTENT)
    parent, loops = opened_where_they_meet(graph, parent, away, kept, reach)
    rank = _longest_first(graph, parent, kept)
    children = np.flatnonzero(kept & (parent >= 0))
    count = len(parent)
    ones, places = np.ones(len(children)), (rank[parent[children]], rank[children])
    links = csr_matrix((ones, places), (count, count))
    by_rank = np.argsort(rank)
    order = by_rank[depth_first_order(links, rank[root], return_predecessors=False)]
    new_index = np.full(count + 1, -1, dtype=np.int64)
    new_index[order] = np.arange(len(order))
    above = new_index[parent[order]]
    return PointTree(graph.points[order], graph.radius[order], above, new_index[loops])


def _longest_first(graph: LineGraph, parent: Indices, kept: Flags) -> Indices:
    """A rank for each node (n,), the lower the longer the way from its parent down through it is.

    Ways that differ by rounding only count as equally long; then the order is that of the nodes.
    """
    steps = np.where(parent < 0, 0.0, norm(graph.points - graph.points[parent]))
    away = sums_to_root(parent, steps)
    farthest, above = np.where(kept, away, 0.0).tolist(), parent.tolist()
    for node in np.argsort(-away, kind="stable").tolist():
        if above[node] >= 0:
            farthest[above[node]] = max(farthest[above[node]], farthest[node])
    lengths = np.round(np.array(farthest) / (WELD_EXTENT * graph.extent()))
    rank = np.empty_like(parent)
    rank[np.argsort(-lengths, kind="stable")] = range(len(parent))
    return rank


def _without_spurs(graph: LineGraph, parent: Indices, tips: Points, is_inlet: Flags) -> Flags:
    """Whether each node stays; dead ends made by opening a loop or by merging lines do not.

    They go when they end within their junction's sphere, or at the inlet, where a cap leaves no
    sphere, or run all along beside another line, which then stands for their lumen. What is left
    of one limb of a loop stays for the other one's sake, however short it is.
    """
    kept = np.ones(len(parent), dtype=bool)
    child_count = np.bincount(parent[parent >= 0], minlength=len(parent))
    reach = reach_of(graph, GAP_FRACTION, GAP_EXTENT)
    steps = np.linalg.norm(graph.points - graph.points[parent], axis=1).tolist()
    above_of = parent.tolist()
    dead_ends = np.flatnonzero(child_count == 0)
    is_meant = ends_at(graph, dead_ends, tips) > 0
    # Those where a step was left out come last: how long they are shows without the others.
    is_limb = graph.degrees()[dead_ends] > 1
    spurs = [*dead_ends[is_limb].tolist(), *dead_ends[~is_limb & ~is_meant].tolist()]
    if not spurs:
        return kept
    everywhere = search_tree(graph.points)
    limbs: set[int] = set()
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
                limbs.add(own[0])
                continue
        child_count[junction] -= 1
        if child_count[junction] == 0:
            spurs.append(junction)
    one, other = graph.edges.T
    is_left_out = (parent[one] != other) & (parent[other] != one)
    for step in graph.edges[is_left_out & ~(kept[one] & kept[other])].tolist():
        ways = [_up_to_kept(above_of, kept, node) for node in step]
        if any(way[-1] in limbs for way in ways):
            kept[np.concatenate(ways)] = True
    return kept


def _up_to_kept(above_of: list[int], kept: Flags, node: int) -> list[int]:
    """The nodes from a given one up to the first that stays, both included."""
    way = [node]
    # Ends: the root stays.
    while not kept[way[-1]]:
        way.append(above_of[way[-1]])
    return way


def _thinned(graph: LineGraph, line_ends: Indices) -> tuple[LineGraph, Indices]:
    """The graph with no more points than needed, and the ends of the lines in its numbers."""
    spacing = reach_of(graph, DENSEST * OVERLAP_FRACTION, DENSEST * OVERLAP_EXTENT)
    return thinned(graph, line_ends, spacing)
