"""Connected parts of a graph."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..validation import Indices


def component_labels(count: int, start: Indices, end: Indices) -> Indices:
    """Number (count,) of the connected part of each node, in the order of the first node."""
    labels = connected(count, start, end)[1]
    _, first, number = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.reshape(-1)]


def connected(count: int, start: NDArray[Any], end: NDArray[Any]) -> tuple[int, Indices]:
    """Number of connected parts of so many nodes joined by edges, and the part of each node."""
    # Imported here: scipy costs half a second, which a first frame should not pay.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    # Floats, because SciPy copies a graph of anything else.
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(count, count)).tocsr()
    number, labels = connected_components(graph, directed=False)
    return int(number), labels
