"""Lines that part and meet again: a tree has to leave out a step of such a loop."""

from __future__ import annotations

import numpy as np

from ..validation import Flags, Floats, Indices
from .line_graph import LineGraph


def opened_where_they_meet(
    graph: LineGraph, parent: Indices, away: Floats, kept: Flags
) -> tuple[Indices, Indices]:
    """The tree whose loops are opened where a limb meets the vessel again, and these places.

    Shortest ways leave out a step somewhere within a limb. So that a limb is one branch, from
    where it parts on, what comes to this step from the far side is turned round.

    Parameters
    ----------
    graph : LineGraph
    parent : (n,) array
        Of every node on the shortest way to the root, -1 there.
    away : (n,) array
        Length of that way, mm.
    kept : (n,) array of bool
        Nodes of the tree.

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
        parent[chain[1:-1]] = chain[:-2]
        found.append((chain[-2], chain[-1]))
    return parent, np.array(sorted(found), dtype=np.int64).reshape(-1, 2)


def _up_to_junction(parent: Indices, degrees: Indices, node: int) -> list[int]:
    """The nodes from one to the next junction on its way to the root, both included."""
    way = [node]
    # Ends: at the root at the latest.
    while degrees[way[-1]] == 2 and parent[way[-1]] >= 0:
        way.append(int(parent[way[-1]]))
    return way
