"""Loops of lines that part and meet again: a tree has to leave out a step of each."""

from __future__ import annotations

import numpy as np

from ..geometry import nearest_distances
from ..validation import Flags, Floats, Indices
from .line_graph import LineGraph
from .point_tree import ancestry_of


def opened_where_they_meet(
    graph: LineGraph, parent: Indices, away: Floats, kept: Flags, reach: Floats
) -> tuple[Indices, Indices]:
    """The tree with loops opened where a limb meets the vessel again, and these places.

    Shortest ways leave out a step somewhere within a limb. So that a limb is one branch from where
    it parts, the part that reaches this step from the far side is turned round.

    Parameters
    ----------
    graph : LineGraph
    parent : (n,) array
        Next node on the shortest way of every node to the root, -1 there.
    away : (n,) array
        Length of the shortest way to the root, mm.
    kept : (n,) array of bool
        Whether each node is in the tree.
    reach : (n,) array
        Distance, mm, up to which lines lie in one lumen and make no loop.

    Returns
    -------
    (n,) array
        `parent`, turned round where that was needed.
    (k, 2) array
        The last node of every limb, and the one where it meets the vessel again.
    """
    one, other = graph.edges[kept[graph.edges].all(axis=1)].T
    is_left_out = (parent[one] != other) & (parent[other] != one)
    parent, found = parent.copy(), []
    degrees = np.bincount(np.r_[one, other], minlength=len(parent))
    for step in zip(one[is_left_out].tolist(), other[is_left_out].tolist(), strict=True):
        ups = [_up_to_junction(parent, degrees, node) for node in step]
        # The limb begins at the junction that is nearer to the root.
        near, far = sorted((0, 1), key=lambda side: float(away[ups[side][-1]]))
        chain = [step[near], *ups[far]]
        limb = np.array([*ups[near][::-1], *ups[far][:-1]])
        other_limb = np.setdiff1d(_cycle(parent, step), limb[1:])
        places = np.vstack([graph.points[limb], graph.points[list(step)].mean(axis=0)])
        apart = nearest_distances(places, graph.points[other_limb])
        if (apart > np.r_[reach[limb], reach[list(step)].max()]).any():
            parent[chain[1:-1]] = chain[:-2]
            found.append((chain[-2], chain[-1]))
    return parent, np.array(sorted(found), dtype=np.int64).reshape(-1, 2)


def _cycle(parent: Indices, step: tuple[int, int]) -> Indices:
    """The nodes of the loop that a step closes, with the node where its two ways part."""
    one, other = (ancestry_of(parent, node) for node in step)
    count = min(len(one), len(other))
    shared = int(np.sum(one[:count] == other[:count]))
    return np.r_[one[shared - 1 :], other[shared:]]


def _up_to_junction(parent: Indices, degrees: Indices, node: int) -> list[int]:
    """The nodes from a given one to the next junction on its way to the root, both included."""
    way = [node]
    # Ends: at the root at the latest.
    while degrees[way[-1]] == 2 and parent[way[-1]] >= 0:
        way.append(int(parent[way[-1]]))
    return way
