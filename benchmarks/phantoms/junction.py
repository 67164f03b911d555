"""Mesh of a branching synthetic vessel: surface nets, cut flat at the ends, then relaxed."""

from __future__ import annotations

import numpy as np

from SDFStentLib.geometry import boundary_edges, connected, dot, edges, is_manifold
from SDFStentLib.validation import Flags, Floats, Indices, InputError, Points, Triangles

from .field import Rim, TubeUnion
from .mesh import FacedMesh, flipped, with_cap

COARSEST_CELL = 2.0
"""Size, mm, that the cells have at least with which the search for the surface starts."""

SPACING_FACTORS = (1.1, 1.07, 1.04, 1.0, 0.95)
"""Grid spacings over the edge length, in the order in which they are tried."""

REPAIRS = 20
"""Most rounds of separating the two sheets in cells; a handful of cells takes two or three."""

RELAXATIONS = 24
"""Rounds of smoothing; fewer leave short edges, more no longer change the angles."""


def branching_tube(union: TubeUnion, edge_length: float, *, is_repaired: bool = False) -> FacedMesh:
    """Closed mesh of a union of tubes: wall with face id 1, flat caps from 2 in order of rims.

    Parameters
    ----------
    union : TubeUnion
        The tubes, which go on beyond their rims by at least three edges.
    edge_length : float
        Requested edge length, mm; at most two thirds of the smallest radius.
    is_repaired : bool
        Whether to separate the sheets in grid cells that hold two, as a large surface has at any
        spacing; otherwise a spacing without such cells is searched.
    """
    rims = union.rims()
    points, triangles = _manifold_nets(union, edge_length, is_repaired)
    triangles = _without_peaks(_trimmed(points, triangles, rims))
    points, triangles = _without_unused(union.projected(points), triangles)
    loops = [_rim_loop(points, triangles, rim) for rim in rims]
    points = points.copy()
    for loop, rim in zip(loops, rims, strict=True):
        points[loop] = _on_circle(points[loop], rim)
    points, triangles = _relaxed(union, points, triangles, list(zip(loops, rims, strict=True)))

    patch = FacedMesh(points, triangles, np.ones(len(triangles), dtype=np.int64))
    for number, (loop, rim) in enumerate(zip(loops, rims, strict=True)):
        patch = with_cap(patch, loop, rim.outward, number + 2)
    return patch


def surface_nets(
    union: TubeUnion, spacing: float, *, is_repaired: bool = False
) -> tuple[Points, Triangles]:
    """Isosurface f = 0 as the dual of a grid: a point per crossed cell, a quad per crossed edge.

    Method: Gibson, "Constrained elastic surface nets", MICCAI 1998, doi 10.1007/BFb0056277,
    without the elastic step. Cells far from the surface are never made. `is_repaired` separates two
    sheets in one cell: the node of the cell that is nearest to the surface changes sides.
    """
    lower, cells, counts = _cells_at_surface(union, spacing)
    strides = np.array([1, counts[0], counts[0] * counts[1]])
    nodes = np.unique(cells[:, None] + _corners() @ strides)
    grid = (nodes[:, None] // strides) % counts
    values = union(lower + spacing * grid).value
    if is_repaired:
        corners = np.searchsorted(nodes, cells[:, None] + _corners() @ strides)
        values = _of_one_sheet(values, corners)

    quads, crossings = [], []
    for direction in range(3):
        ahead = np.searchsorted(nodes, nodes + strides[direction])
        ahead[ahead == len(nodes)] = 0
        is_crossed = (nodes[ahead] == nodes + strides[direction]) & (
            (values < 0) != (values[ahead] < 0)
        )
        start, end = np.flatnonzero(is_crossed), ahead[is_crossed]
        fraction = values[start] / (values[start] - values[end])
        crossing = grid[start].astype(float)
        crossing[:, direction] += fraction
        first, second = strides[(direction + 1) % 3], strides[(direction + 2) % 3]
        quad = nodes[start][:, None] - np.array([first + second, second, 0, first])
        quads.append(np.where((values[start] < 0)[:, None], quad, quad[:, ::-1]))
        crossings.append(crossing)
    numbers, quad = np.unique(np.vstack(quads), return_inverse=True)
    quad = quad.reshape(-1, 4)
    total = np.repeat(np.vstack(crossings), 4, axis=0)
    weight = np.bincount(quad.ravel(), minlength=len(numbers))
    sums = np.stack([np.bincount(quad.ravel(), part) for part in total.T], axis=1)
    points = lower + spacing * sums / weight[:, None]
    return points, _split_quads(points, quad)


def _manifold_nets(
    union: TubeUnion, edge_length: float, is_repaired: bool
) -> tuple[Points, Triangles]:
    """Surface nets of the first grid whose cells each hold only one sheet of the surface."""
    for factor in SPACING_FACTORS:
        points, triangles = surface_nets(union, factor * edge_length, is_repaired=is_repaired)
        if len(triangles) and is_manifold(triangles):
            return points, triangles
    raise InputError(
        f"edge_length: {edge_length:g} mm is too long for the narrowest places of this vessel; "
        "choose a shorter one."
    )


def _of_one_sheet(values: Floats, corners: Indices) -> Floats:
    """Values at the nodes, changed so that no cell (c, 8) holds two sheets, if enough rounds do."""
    values = values.copy()
    for _ in range(REPAIRS):
        inside = values[corners] < 0
        crossed = np.flatnonzero(inside.any(axis=1) & ~inside.all(axis=1))
        patterns, which = np.unique(inside[crossed], axis=0, return_inverse=True)
        is_torn = np.array([not _is_one_sheet(pattern) for pattern in patterns], dtype=bool)
        torn = corners[crossed[is_torn[which.ravel()]]]
        if not len(torn):
            break
        nearest = np.abs(values[torn]).argmin(axis=1)
        values[np.unique(torn[np.arange(len(torn)), nearest])] *= -1
    return values


def _is_one_sheet(inside: Flags) -> bool:
    """Whether the corners (8,) of a cell that are inside are connected, and those outside, too."""
    steps = np.abs(_corners()[:, None] - _corners()).sum(axis=2)
    start, end = np.nonzero(steps == 1)
    same = inside[start] == inside[end]
    return connected(8, start[same], end[same])[0] == 2


def _corners() -> Indices:
    return np.indices((2, 2, 2)).reshape(3, -1).T


def _cells_at_surface(union: TubeUnion, spacing: float) -> tuple[Floats, Indices, Indices]:
    """Lower corner of the grid, numbers of the cells near the surface, and grid size in nodes."""
    levels = max(int(np.ceil(np.log2(COARSEST_CELL / spacing))), 0)
    lower, upper = union.bounds()
    coarse = np.ceil((upper - lower) / (spacing * 2**levels)).astype(np.int64)
    cells = np.indices(tuple(coarse)).reshape(3, -1).T
    for level in range(levels, -1, -1):
        size = spacing * 2**level
        value = union(lower + size * (cells + 0.5)).value
        # Half the diagonal, times a bound on the slope of f (radii change by < 1 per mm).
        cells = cells[np.abs(value) < 1.3 * np.sqrt(0.75) * size]
        if level:
            cells = (2 * cells[:, None] + _corners()).reshape(-1, 3)
    counts = coarse * 2**levels + 1
    return lower, cells @ np.array([1, counts[0], counts[0] * counts[1]]), counts


def _split_quads(points: Points, quads: Indices) -> Triangles:
    """Two triangles for each quad, along its shorter diagonal."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    first = np.linalg.norm(a - c, axis=1) <= np.linalg.norm(b - d, axis=1)
    turned = np.where(first[:, None], quads, np.roll(quads, 1, axis=1))
    return np.vstack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])


def _trimmed(points: Points, triangles: Triangles, rims: list[Rim]) -> Triangles:
    """Triangles inside the rims, none of which touches the boundary at all three corners."""
    centers = points[triangles].mean(axis=1)
    keep = np.ones(len(triangles), dtype=bool)
    for rim in rims:
        offset = centers - rim.center
        keep &= (offset @ rim.outward < 0) | (np.linalg.norm(offset, axis=1) > 3 * rim.radius)
    triangles = triangles[keep]
    # Ends: every round takes triangles away.
    while True:
        at_boundary = np.zeros(len(points), dtype=bool)
        at_boundary[boundary_edges(triangles)] = True
        ears = at_boundary[triangles].all(axis=1)
        if not ears.any():
            return triangles
        triangles = triangles[~ears]


def _without_peaks(triangles: Triangles) -> Triangles:
    """Triangles without the points at which only three meet, as these would stay slivers."""
    valence = np.bincount(triangles.ravel())
    valence[boundary_edges(triangles)] = 0
    is_peak = valence == 3
    if not is_peak.any():
        return triangles
    at_peak = is_peak[triangles]
    around = triangles[at_peak.any(axis=1)]
    peak = np.argmax(is_peak[around], axis=1)
    rows = np.arange(len(around))
    start, end = around[rows, (peak + 1) % 3], around[rows, (peak + 2) % 3]
    order = np.argsort(around[rows, peak], kind="stable").reshape(-1, 3)
    # The three sides around a peak follow each other: s-e, e-t, t-s.
    first = order[:, 0]
    third = np.where(end[order[:, 1]] == start[first], start[order[:, 1]], start[order[:, 2]])
    lids = np.stack([start[first], end[first], third], axis=1)
    return np.vstack([triangles[~at_peak.any(axis=1)], lids])


def _without_unused(points: Points, triangles: Triangles) -> tuple[Points, Triangles]:
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 3)


def _rim_loop(points: Points, triangles: Triangles, rim: Rim) -> Indices:
    """The boundary points near a rim, in their order around it."""
    free = boundary_edges(triangles)
    near = np.linalg.norm(points[free[:, 0]] - rim.center, axis=1) < 1.5 * rim.radius
    following = dict(free[near].tolist())
    loop = [int(free[near][0, 0])]
    # Ends: an edge is taken out when it is used.
    while (onward := following.pop(loop[-1], None)) != loop[0]:
        if onward is None:
            raise InputError(
                "edge_length: expected rims that are one loop each, got one that meets itself; "
                "make it a little smaller or larger."
            )
        loop.append(onward)
    return np.array(loop)


def _on_circle(loop: Points, rim: Rim) -> Points:
    """The loop spread evenly over the rim, as near as possible to its present places."""
    radial = loop - rim.center
    first = radial[0] - (radial[0] @ rim.outward) * rim.outward
    first = first / np.linalg.norm(first)
    second = np.cross(rim.outward, first)
    angles = np.unwrap(np.arctan2(radial @ second, radial @ first))
    even = np.arange(len(loop)) * (2 * np.pi / len(loop)) * np.sign(angles[-1] - angles[0])
    even = even + (angles - even).mean()
    return rim.center + rim.radius * (
        np.cos(even)[:, None] * first + np.sin(even)[:, None] * second
    )


def _relaxed(
    union: TubeUnion, points: Points, triangles: Triangles, fixed: list[tuple[Indices, Rim]]
) -> tuple[Points, Triangles]:
    """Points spread evenly over the surface, with rims kept and edges flipped where that helps."""
    is_free = np.ones(len(points), dtype=bool)
    for loop, _ in fixed:
        is_free[loop] = False
    for _ in range(RELAXATIONS):
        triangles = flipped(points, triangles, rounds=1)
        toward = 0.6 * (_neighbor_means(points, triangles) - points)
        value, gradient = union(points)
        squared = np.maximum(dot(gradient, gradient), 0.01)
        # Toward the neighbors within the surface, and one Newton step back onto it.
        along = dot(toward, gradient) + value
        toward -= (along / squared)[:, None] * gradient
        points = np.where(is_free[:, None], points + toward, points)
    points = np.where(is_free[:, None], union.projected(points, 5), points)
    return points, flipped(points, triangles)


def _neighbor_means(points: Points, triangles: Triangles) -> Points:
    ends = edges(triangles).vertices
    both = np.vstack([ends, ends[:, ::-1]])
    total = np.stack([np.bincount(both[:, 0], part) for part in points[both[:, 1]].T], axis=1)
    return np.asarray(total / np.bincount(both[:, 0])[:, None])
