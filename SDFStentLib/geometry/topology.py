"""Connectivity of a surface's triangles: edges, fans, components; no coordinates here.

Triangles are (m, 3) arrays of int64, at least one row and no index below 0: those of a `Surface`,
or a part of them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..validation import Flags, Indices, Triangles
from .fans import component_labels, connected, fans_by_graph, fans_by_walking, following

Sides = NDArray[Any]
"""Numbers of triangle sides, in 32 bits where that is enough."""


class Edges(NamedTuple):
    """The unique edges of a surface and the faces at each.

    Attributes
    ----------
    vertices : (e, 2) array
        End points of each edge, the lower index first, in ascending order.
    face_edges : (m, 3) array
        Edge of every triangle side; side k runs from corner k to corner (k + 1) % 3.
    offsets, sides : (e + 1,) and (3 m,) arrays
        The sides at edge i are `sides[offsets[i]:offsets[i + 1]]`, side 3 f + k being side k of
        face f.
    """

    vertices: Indices
    face_edges: Indices
    offsets: Indices
    sides: Indices

    @property
    def face_counts(self) -> Indices:
        """(e,) number of triangle sides at each edge; 2 everywhere on a closed manifold."""
        return np.diff(self.offsets)

    @property
    def faces(self) -> Indices:
        """(3 m,) face of every entry of `sides`."""
        return self.sides // 3

    @property
    def paired_sides(self) -> Indices:
        """(p, 2) the two sides at every edge that has exactly two."""
        return _in_pairs(self.sides, self.offsets[:-1])


class VertexNeighbors(NamedTuple):
    """Vertices joined to each vertex by an edge, in compressed rows.

        Attributes
        ----------
        offsets : (n + 1,) array
        indices : (k,) array
    The neighbors of vertex i are `indices[offsets[i]:offsets[i + 1]]`, ascending.
    """

    offsets: Indices
    indices: Indices


class Topology(NamedTuple):
    """Topology of a surface, from its triangles alone.

    Attributes
    ----------
    is_closed : bool
        No edge is free.
    is_edge_manifold, is_vertex_manifold : bool
        At most two faces at every edge; one fan of faces at every vertex.
    is_consistently_wound, is_orientable : bool
        The two faces at an edge run along it in opposite directions, at every edge; they can be
        wound so, which a Moebius strip cannot.
    boundary_edge_count, component_count : int
        Edges with one face; parts joined by edges.
    unshared_points : int
        Points that lie on others at a seam and count as the same point in everything else here.
        A reader of the file has to merge them.
    """

    is_closed: bool
    is_edge_manifold: bool
    is_vertex_manifold: bool
    is_consistently_wound: bool
    is_orientable: bool
    boundary_edge_count: int
    component_count: int
    unshared_points: int = 0

    @property
    def is_manifold(self) -> bool:
        """Manifold, with or without boundary, at edges and vertices."""
        return self.is_edge_manifold and self.is_vertex_manifold

    @property
    def is_oriented(self) -> bool:
        """Closed and consistently wound: it has an inside."""
        return self.is_closed and self.is_consistently_wound

    @property
    def is_watertight(self) -> bool:
        """Closed and manifold: the surface bounds a volume without a leak."""
        return self.is_closed and self.is_manifold

    def in_words(self) -> str:
        """Watertight, not manifold or open, and whether one-sided, as a part of a sentence."""
        sided = "" if self.is_orientable else ", one-sided (as a Moebius strip is)"
        if self.unshared_points:
            sided += f" once {self.unshared_points} points that lie on others are merged"
        if self.is_watertight:
            return f"watertight{sided}"
        if not self.is_manifold:
            return f"not manifold{sided}"
        return f"open ({self.boundary_edge_count} boundary edges){sided}"


def edges(triangles: Triangles) -> Edges:
    """Unique edges of a surface with the faces at each."""
    keys, sides, is_first = _sorted_sides(triangles)
    offsets = np.r_[np.flatnonzero(is_first), len(keys)]
    face_edges = np.empty(len(keys), dtype=np.int64)
    face_edges[sides] = np.cumsum(is_first) - 1
    firsts, base = keys[is_first], int(triangles.max()) + 1
    lower = firsts // base
    vertices = np.stack([lower, firsts - lower * base], axis=1)
    return Edges(vertices, face_edges.reshape(-1, 3), offsets, sides.astype(np.int64))


def paired_sides(triangles: Triangles) -> Indices:
    """`Edges.paired_sides` without building the rest."""
    _, sides, is_first = _sorted_sides(triangles)
    return _in_pairs(sides, np.flatnonzero(is_first)).astype(np.int64)


def _in_pairs(sides: Indices, starts: Indices) -> Indices:
    """(p, 2) sides of every edge that has two, from where each edge begins among all sides."""
    first = starts[np.diff(starts, append=len(sides)) == 2]
    return np.stack([sides[first], sides[first + 1]], axis=1)


def boundary_edges(triangles: Triangles) -> Indices:
    """Edges (b, 2) at which there is only one face, in the direction of that face."""
    found = edges(triangles)
    single = found.sides[found.offsets[:-1][found.face_counts == 1]]
    return np.stack([triangles.ravel()[single], _side_ends(triangles)[single]], axis=1)


def is_manifold(triangles: Triangles) -> bool:
    """Whether the surface is manifold, with or without boundary, at its edges and its vertices."""
    return surface_topology(triangles).is_manifold


def surface_topology(triangles: Triangles) -> Topology:
    """Work out the topology of a surface from its triangles alone."""
    corners = triangles.ravel()
    sides, is_first = _sorted_sides(triangles)[1:]
    starts = np.flatnonzero(is_first)
    counts = np.diff(starts, append=len(sides))
    is_closed = bool(np.all(counts % 2 == 0))
    boundary_edge_count = int(np.count_nonzero(counts == 1))
    firsts = sides[starts]
    has_length = not np.any(corners[firsts] == corners[following(firsts)])
    del firsts
    is_edge_manifold = bool(np.all(counts <= 2) and has_length)
    pairs = starts[counts == 2]
    first, second = sides[pairs], sides[pairs + 1]
    del starts, counts, pairs  # of a large surface these are as large as the graphs below
    is_consistently_wound = not np.any(corners[first] == corners[second])
    is_orientable = is_consistently_wound
    if not is_consistently_wound:
        wound = consistently_wound(triangles)[0]
        is_orientable = not _disagree(wound, paired_sides(wound)).any()
    if is_edge_manifold and is_consistently_wound:
        fans = fans_by_walking(corners, first, second)
    else:
        fans = fans_by_graph(corners, *_meeting_sides(sides, is_first))
    del first, second
    side, other = _meeting_sides(sides, is_first)
    del sides, is_first
    return Topology(
        is_closed=is_closed,
        is_edge_manifold=is_edge_manifold,
        is_vertex_manifold=fans == int(np.count_nonzero(np.bincount(corners))),
        is_consistently_wound=is_consistently_wound,
        is_orientable=is_orientable,
        boundary_edge_count=boundary_edge_count,
        component_count=connected(len(triangles), side // 3, other // 3)[0],
    )


def vertex_neighbors(triangles: Triangles, point_count: int | None = None) -> VertexNeighbors:
    """Neighbors of every vertex.

    Parameters
    ----------
    triangles : (m, 3) array
    point_count : int, optional
        Number of points; by default up to the highest index in use. Points without a triangle
        have no neighbors.
    """
    start, end = triangles.ravel(), _side_ends(triangles)
    count = int(triangles.max(initial=-1)) + 1 if point_count is None else point_count
    has_length = start != end
    start, end = start[has_length], end[has_length]
    # Every side both ways; a side of two triangles stands twice and counts once.
    keys = np.concatenate([start * count + end, end * count + start])
    keys.sort()
    is_first = np.ones(len(keys), dtype=bool)
    np.not_equal(keys[1:], keys[:-1], out=is_first[1:])
    start, end = np.divmod(keys[is_first], count)
    return VertexNeighbors(np.r_[0, np.cumsum(np.bincount(start, minlength=count))], end)


def consistently_wound(triangles: Triangles) -> tuple[Triangles, Indices]:
    """Triangles whose neighbors all agree in winding, and the part to which each belongs.

    In each part the fewer faces are turned (the first face keeps its winding when both are as
    many). Only edges with exactly two faces carry winding across. A part that cannot be oriented
    (a Moebius band) keeps the winding it came with.

    Returns
    -------
    triangles : (m, 3) array
    part : (m,) array
        Faces with the same number are joined through edges with two faces.
    """
    result = triangles.copy()
    count = len(result)
    sides = paired_sides(triangles)
    left, right = sides[:, 0] // 3, sides[:, 1] // 3
    disagree = _disagree(triangles, sides)
    # Every face stands twice in the graph, as it is (f) and turned (f + count). Faces that agree
    # are joined as they are and as turned; faces that disagree, one as it is, the other turned.
    label = component_labels(
        2 * count,
        np.r_[left, left + count],
        np.r_[right + count * disagree, right + count * ~disagree],
    )
    as_is, turned = label[:count], label[count:]
    part = np.unique(np.minimum(as_is, turned), return_inverse=True)[1].reshape(-1)
    # Each part is a pair of mirrored sheets; `as_is > turned` marks one side of the split.
    minority = as_is > turned
    share = np.bincount(part, weights=minority) / np.bincount(part)
    turn = (minority ^ (share > 0.5)[part]) & (as_is != turned)
    result[turn] = result[turn][:, ::-1]
    return result, part


def _disagree(triangles: Triangles, pairs: Indices) -> Flags:
    """Mask (p,) of the pairs of sides (p, 2) at one edge that run along it in the same
    direction."""
    starts = triangles.ravel()[pairs]
    return np.asarray(starts[:, 0] == starts[:, 1])


def _side_ends(triangles: Triangles) -> Indices:
    # Columns one by one: NumPy takes several times longer over a choice of them.
    ends = np.empty(triangles.shape, dtype=triangles.dtype)
    for corner in range(3):
        ends[:, corner] = triangles[:, (corner + 1) % 3]
    return ends.ravel()


def _sorted_sides(
    triangles: Triangles,
) -> tuple[Indices, Sides, NDArray[np.bool_]]:
    """Edge keys of the triangle sides, ascending; the sides in that order; whether each begins an
    edge.

    Sides are numbered in 32 bits where that is enough: they are the largest arrays of a topology.
    """
    first, second = triangles.ravel(), _side_ends(triangles)
    keys = np.minimum(first, second)
    keys *= int(triangles.max()) + 1
    keys += np.maximum(first, second)
    del second
    count = len(keys)
    if (int(keys.max()) + 1) * count < 2**63:
        # Sorting numbers is several times quicker than sorting the indices of what they number.
        keys *= count
        keys += np.arange(count)
        keys.sort()
        sides = keys.copy()
        keys //= count
        sides -= keys * count
    else:
        sides = np.argsort(keys, kind="stable")
        keys = keys[sides]
    is_first = np.ones(len(keys), dtype=bool)
    np.not_equal(keys[1:], keys[:-1], out=is_first[1:])
    return keys, sides.astype(np.int32 if len(keys) < 2**31 else np.int64), is_first


def _meeting_sides(sides: Sides, is_first: NDArray[np.bool_]) -> tuple[Sides, Sides]:
    """Every side but the first at its edge, and the side before it at that edge."""
    later = np.flatnonzero(~is_first)
    return sides[later], sides[later - 1]
