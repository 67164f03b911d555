"""Root of a centerline: the end at which its tree begins, whatever order the file has.

Neither the order of lines and points nor the direction of pieces shows it, nor does one radius.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..geometry import Line, component_labels, nearest_distances, norm
from ..validation import Flags, Floats, Indices, InputError, Points, as_point, coordinates
from .line_graph import LineGraph, reach_of
from .lumen_tree import USUAL

WIDER = 1.1
"""Ratio of the widest end to every other beyond which it is the root, whatever the direction in
which a file stores its line; a smaller one may come from measuring."""

INLET_EXTENT = 1e-2
"""Distance, over the bounding box's diagonal, within which lines begin at one inlet."""

_BEYOND = 4.0
"""Multiple of that distance at which lines of one inlet are still in one lumen, unless lines meet
there."""

_FAR = 4.0
"""Distance from an end, in radii, within which the vessel's width there is measured, also past
places where lines part."""

Widths = Callable[[Sequence[Points]], Floats]
"""A function that gives the widths of a vessel at some of its ends, mm, from the lines (k, 3) that
lead inward from there; NaN where a width is not known."""


class FileLines(NamedTuple):
    """First and last places of a file's lines, in its order and direction."""

    places: Points
    """(n, 2, 3) first and last place of every line, mm."""
    tell_direction: bool
    """Whether the lines run on into each other from one end: one line, or all its segments."""


def root_of(
    graph: LineGraph, ends: FileLines, tips: Points, inlet: ArrayLike | None, widths: Widths | None
) -> int:
    """The node where the tree starts; the rules are in `Centerline.from_lines`.

    `tips` (t, 3) are the places at which a line ends and no other goes on.
    """
    leaves = np.flatnonzero(graph.degrees() == 1)
    if not len(leaves):
        place = coordinates(ends.places[0, 0])
        raise InputError(
            "centerline: expected a line with two ends, got a closed loop, which ends where it "
            f"begins, at {place}; take a part of it."
        )
    if inlet is not None:
        return int(leaves[norm(graph.points[leaves] - as_point(inlet, "inlet")).argmin()])
    is_tip = (ends_at(graph, leaves, tips) > 0) | _leave_their_junction(graph, leaves)
    leaves = leaves[is_tip] if is_tip.any() else leaves
    common = [] if ends.tell_direction else _common_ends(graph, ends.places, leaves)
    return _widest(graph, ends, np.array(common) if common else leaves, widths)


def ends_at(graph: LineGraph, leaves: Indices, places: Points) -> Indices:
    """Number of ends of lines (n, 3) at each leaf: within its radius, and nearest to it."""
    from scipy.spatial import cKDTree

    distances, nearest = cKDTree(graph.points[leaves]).query(places)
    near = distances <= reach_of(graph, 1.0, INLET_EXTENT)[leaves[nearest]]
    return np.bincount(nearest[near], minlength=len(leaves))


def _widest(graph: LineGraph, ends: FileLines, nodes: Indices, widths: Widths | None) -> int:
    """The widest end; of those about as wide the one where a single line begins."""
    if len(nodes) == 1:
        return int(nodes[0])
    ways = _lumens_in(graph, nodes)
    if widths is None:
        found = np.array([_usual(graph.radius[way]) for way in ways])
    else:
        found = np.nan_to_num(widths([graph.points[way] for way in ways]), nan=0.0)
    as_wide = WIDER * found >= found.max()
    if ends.tell_direction:
        first, last = (ends_at(graph, nodes, ends.places[:, side]) for side in (0, 1))
        begins = first > last
        as_wide &= begins if begins.sum() == 1 and as_wide[begins].all() else True
    return int(nodes[np.where(as_wide, found, -1.0).argmax()])


def _usual(radius: Floats) -> float:
    known = radius[np.isfinite(radius)]
    return float(np.quantile(known, USUAL)) if len(known) else 0.0


def _way_in(
    graph: LineGraph,
    node: int,
    neighbors: Callable[[int], list[int]],
    first: int | None = None,
) -> Indices:
    """Nodes from an end to the next junction, or halfway to another end."""
    way = [node, neighbors(node)[0] if first is None else first]
    # Ends: a way from an end comes to another one, or to a junction.
    while len(onward := neighbors(way[-1])) == 2:
        way.append(onward[onward[0] == way[-2]])
    found = np.array(way, dtype=np.int64)
    if len(onward) == 1 and first is None:
        line = Line(graph.points[found])
        found = found[: max(2, int(np.searchsorted(line.arc_lengths, line.length / 2)) + 1)]
    return found


def _lumens_in(graph: LineGraph, nodes: Indices) -> list[Indices]:
    """The ways in from ends, each as far as it stays in one lumen: lines may part before that."""
    table, reach = graph.neighbors(), reach_of(graph, 1.0, INLET_EXTENT)
    found = []
    for node in nodes.tolist():
        way = _way_in(graph, node, table.of)
        # Ends: a step farther every time, and no node twice.
        while (onward := [k for k in table.of(int(way[-1])) if k not in way]) and (
            Line(graph.points[way]).length
        ) < (far := _FAR * float(reach[way].max())):
            ahead = graph.points[way[-1]] - graph.points[node]
            step = graph.points[onward] - graph.points[way[-1]]
            straight = onward[int((step @ ahead / norm(step)).argmax())]
            way = np.r_[way, _way_in(graph, int(way[-1]), table.of, straight)[1:]]
            at = Line(graph.points[way]).arc_lengths
            way = way[: max(2, int(np.searchsorted(at, far)) + 1)]
        found.append(way)
    return found


def _leave_their_junction(graph: LineGraph, leaves: Indices) -> Flags:
    """Whether each end (n,) of the graph lies outside of the sphere of the next junction."""
    table, reach = graph.neighbors(), reach_of(graph, 1.0, INLET_EXTENT)
    ways = [_way_in(graph, leaf, table.of) for leaf in leaves.tolist()]
    return np.array([Line(graph.points[way]).length > reach[way[-1]] for way in ways])


def _common_ends(graph: LineGraph, places: Points, leaves: Indices) -> list[int]:
    """The ends from which lines of the file lead to the most others, if to several.

    Lines that begin at different places of one inlet may cross before they merge, so that no end of
    the graph is left there: then all of them go on in one lumen.
    """
    reach, most = INLET_EXTENT * graph.extent(), 2
    found: list[int] = []
    for count, own in _clusters(places, reach):
        if count < most:
            break
        middle = own.mean(axis=0)
        near = leaves[norm(graph.points[leaves] - middle) <= reach]
        at_leaf = _beside_leaves(graph, near, own)
        if at_leaf.sum() > 1:
            counts = ends_at(graph, near, own[at_leaf])
            order = np.lexsort((norm(graph.points[near] - middle), -counts))
            found.append(int(near[order[0]]))
        elif _goes_one_way(graph, middle, reach, leaves):
            found.append(int(norm(graph.points - middle).argmin()))
        most = count if found else most
    return sorted(found)


def _beside_leaves(graph: LineGraph, leaves: Indices, places: Points) -> Flags:
    """Whether each place (n,) is nearer to an end of the graph than to where lines meet."""
    if not len(leaves):
        return np.zeros(len(places), dtype=bool)
    meeting = graph.points[graph.degrees() > 2]
    away = nearest_distances(places, graph.points[leaves])
    return away < nearest_distances(places, meeting) if len(meeting) else away >= 0


def _clusters(places: Points, reach: float) -> Iterator[tuple[int, Points]]:
    """Ends of lines (n, 2, 3) that lie together, each with the number of places lines lead to.

    The cluster whose lines lead to the most other places comes first.
    """
    from scipy.spatial import cKDTree

    every = places.reshape(-1, 3)
    pairs = cKDTree(every).query_pairs(reach, output_type="ndarray")
    number = component_labels(len(every), pairs[:, 0], pairs[:, 1])
    couples = np.sort(number.reshape(-1, 2), axis=1)
    couples = np.unique(couples[couples[:, 0] != couples[:, 1]], axis=0)
    counts = np.bincount(couples.ravel(), minlength=number.max() + 1)
    for cluster in np.argsort(-counts, kind="stable").tolist():
        yield int(counts[cluster]), every[number == cluster]


def _goes_one_way(graph: LineGraph, middle: Points, reach: float, leaves: Indices) -> bool:
    """Whether everything connected with a place goes on in one lumen, and no line ends beside it.

    Lines that begin there may also be one for a moment before they part.
    """
    away = norm(graph.points - middle)
    apart = max(reach, float(np.nan_to_num(graph.radius[away.argmin()])))
    size = max(_BEYOND * reach, 2 * apart)
    inner = away < size
    within = graph.edges[inner[graph.edges].all(axis=1)]
    label = component_labels(len(away), within[:, 0], within[:, 1])
    is_there = inner & (label == label[away.argmin()])
    if is_there[leaves].any():
        return False
    leaving = is_there[graph.edges].any(axis=1) & ~inner[graph.edges].all(axis=1)
    outer = np.where(inner[graph.edges[leaving]], -1, graph.edges[leaving]).max(axis=1)
    places = size * (graph.points[outer] - middle) / away[outer, None]
    return bool(len(places)) and bool((norm(places - places.mean(axis=0)) < apart).all())
