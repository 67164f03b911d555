"""Cutting a surface open along the one curve in which a plane meets it round a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..validation import Flags, Floats, Indices, Points, Triangles
from .faces import face_normals, faces_at
from .fans import component_labels
from .rows import across, dot, product, used_points
from .section import crossings

SNAPS = (0.2, 1e-3)
"""Share of a side, between its end and the plane, below which that end moves into the plane, as
otherwise slivers come about. The second share is used where the first would pinch the curve."""

TURNED = np.cos(np.deg2rad(20.0))
"""Cosine of the largest angle by which a triangle may turn; a point that would turn one by more
stays where it is."""


class SectionAround(NamedTuple):
    """The connected section of a surface round a point of the plane."""

    triangles: Indices
    """(k,) triangles that the section crosses."""
    sides: Indices
    """(c, 2) ends below and above the plane of every side that the section crosses."""
    start: Points
    """(k, 3) places where the section enters each of the triangles, mm."""
    end: Points
    """(k, 3) places where it leaves them; the lumen lies on the left, seen against the normal."""
    is_closed: bool
    area: float
    """Area of the polygon, mm^2, whatever lies inside it."""


class CutSurface(NamedTuple):
    """Triangles cut along a plane."""

    points: Points
    triangles: Triangles
    sources: Indices
    """(m,) triangle of the uncut surface of which each triangle is a part."""
    rim: Indices
    """(r,) points of the cut in order, in the winding of the triangles above; empty where the cut
    would touch itself."""


def section_around(
    points: Points, triangles: Triangles, origin: Points, normal: Points
) -> SectionAround | None:
    """The piece of a plane section that goes round a point of the plane; all others are left out.

    Parameters
    ----------
    points, triangles : (n, 3) and (m, 3) arrays
        Consistently wound, outward.
    origin, normal : (3,) arrays
        The point, mm, and a unit vector.

    Returns
    -------
    SectionAround or None
        The smallest one of several round the point; None where there is none.
    """
    crossed = crossings(points, triangles, origin, normal)
    start, end = crossed.nodes.T
    label = component_labels(len(crossed.corners), start, end)[start]
    first, second = across(normal[None])[0]
    plane = np.column_stack([crossed.corners @ first, crossed.corners @ second])
    plane -= [origin @ first, origin @ second]
    (x, y), (end_x, end_y) = plane[start].T, plane[end].T
    turn = x * end_y - y * end_x
    angle = np.bincount(label, np.arctan2(turn, x * end_x + y * end_y))
    areas = np.bincount(label, turn) / 2
    round_it = np.flatnonzero(np.abs(angle) > np.pi)
    if not len(round_it):
        return None
    number = round_it[np.argmin(np.abs(areas[round_it]))]
    own = label == number
    used, times = np.unique(crossed.nodes[own], return_counts=True)
    return SectionAround(
        crossed.triangles[own],
        crossed.sides[used],
        crossed.corners[start[own]],
        crossed.corners[end[own]],
        bool((times == 2).all()),
        float(abs(areas[number])),
    )


def cut_along(
    points: Points, triangles: Triangles, section: SectionAround, origin: Points, normal: Points
) -> CutSurface:
    """Divide the triangles that a section crosses, and move points beside it into the plane.

    Points move along a side of the surface. New points come last; what a section elsewhere would
    cross is left as it is.
    """
    # All that changes has a corner in a triangle that is crossed.
    is_near = np.zeros(len(points), dtype=bool)
    is_near[triangles[section.triangles]] = True
    near = np.flatnonzero(faces_at(is_near, triangles))
    used = used_points(triangles[near])
    number = np.zeros(len(points), dtype=np.int64)
    number[used] = np.arange(len(used))
    own = section._replace(
        triangles=np.searchsorted(near, section.triangles), sides=number[section.sides]
    )
    cut = _cut_near(points[used], number[triangles[near]], own, origin, normal)
    # Back among all: new points come last, and new triangles.
    number = np.r_[used, len(points) + np.arange(len(cut.points) - len(used))]
    moved = np.vstack([points, cut.points[len(used) :]])
    moved[used] = cut.points[: len(used)]
    kept = np.delete(np.arange(len(triangles)), section.triangles)
    new = slice(len(near) - len(section.triangles), None)
    return CutSurface(
        moved,
        np.vstack([triangles[kept], number[cut.triangles[new]]]),
        np.r_[kept, near[cut.sources[new]]],
        number[cut.rim],
    )


def _cut_near(
    points: Points, triangles: Triangles, section: SectionAround, origin: Points, normal: Points
) -> CutSurface:
    """`cut_along` of the triangles about a section."""
    heights = product(points - origin, normal)
    for snap in SNAPS:
        moved, moved_heights = _snapped(points, heights, triangles, section.sides, snap)
        cut = _divided(moved, moved_heights, triangles, section)
        if len(cut.rim):
            break
    in_plane = cut.points[cut.rim]
    cut.points[cut.rim] = in_plane - np.outer(product(in_plane - origin, normal), normal)
    return cut


def _snapped(
    points: Points, heights: Floats, triangles: Triangles, sides: Indices, snap: float
) -> tuple[Points, Floats]:
    """Points, those beside the plane moved into it, and their heights, 0 for the moved ones."""
    low, high = sides.T
    fraction = heights[low] / (heights[low] - heights[high])
    corners = points[low] + fraction[:, None] * (points[high] - points[low])
    nearer, share = np.where(fraction < 0.5, low, high), np.minimum(fraction, 1 - fraction)
    order = np.argsort(share, kind="stable")
    moving, first = np.unique(nearer[order], return_index=True)
    chosen = order[first]
    moving, places = moving[share[chosen] < snap], corners[chosen[share[chosen] < snap]]
    # Ends: every round but the last leaves points where they were.
    while True:
        moved = points.copy()
        moved[moving] = places
        stays = ~np.isin(moving, _turned(points, moved, triangles, moving))
        if stays.all():
            break
        moving, places = moving[stays], places[stays]
    heights = heights.copy()
    heights[moving] = 0.0
    return moved, heights


def _turned(points: Points, moved: Points, triangles: Triangles, moving: Indices) -> Indices:
    """Corners of the triangles that turn too much when some points move."""
    is_moving = np.zeros(len(points), dtype=bool)
    is_moving[moving] = True
    faces = triangles[faces_at(is_moving, triangles)]
    cosine = dot(face_normals(points, faces), face_normals(moved, faces))
    return faces[cosine < TURNED].ravel()


def _divided(
    points: Points, heights: Floats, triangles: Triangles, section: SectionAround
) -> CutSurface:
    """The surface with the triangles of a section divided into their parts above and below."""
    is_crossed = (heights[section.sides] * [-1, 1] > 0).all(axis=1)
    low, high = sides = section.sides[is_crossed].T
    fraction = (heights[low] / (heights[low] - heights[high]))[:, None]
    new = {(a, b): len(points) + i for i, (a, b) in enumerate(sides.T.tolist())}
    points = np.vstack([points, points[low] + fraction * (points[high] - points[low])])
    heights = np.r_[heights, np.zeros(len(new))]

    parts: list[list[int]] = []
    sources: list[int] = []
    for number in section.triangles.tolist():
        for half in _halves(triangles[number].tolist(), heights, new):
            pieces = _pieces(half, points)
            parts += pieces
            sources += [number] * len(pieces)
    kept = np.delete(np.arange(len(triangles)), section.triangles)
    divided = np.vstack([triangles[kept], np.array(parts, dtype=np.int64).reshape(-1, 3)])
    on_rim = np.zeros(len(points), dtype=bool)
    on_rim[divided[len(kept) :]] = True
    rim = _rim(divided, heights, on_rim & (heights == 0))
    return CutSurface(points, divided, np.r_[kept, sources].astype(np.int64), rim)


def _halves(
    corners: list[int], heights: Floats, new: dict[tuple[int, int], int]
) -> list[list[int]]:
    """Polygons of a triangle above and below the plane; a triangle in the plane counts as above."""
    above: list[int] = []
    below: list[int] = []
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        if heights[start] >= 0:
            above.append(start)
        if heights[start] <= 0:
            below.append(start)
        crossing = new.get((start, end), new.get((end, start)))
        if crossing is not None:
            above.append(crossing)
            below.append(crossing)
    if max(heights[corners]) <= 0 and min(heights[corners]) < 0:
        return [below]
    return [above] if min(heights[corners]) >= 0 else [above, below]


def _pieces(polygon: list[int], points: Points) -> list[list[int]]:
    """A polygon of three or four corners as triangles, along its shorter diagonal."""
    if len(polygon) == 3:
        return [polygon]
    a, b, c, d = polygon
    if np.linalg.norm(points[a] - points[c]) <= np.linalg.norm(points[b] - points[d]):
        return [[a, b, c], [a, c, d]]
    return [[a, b, d], [b, c, d]]


def _rim(triangles: Triangles, heights: Floats, on_rim: Flags) -> Indices:
    """Points between the triangles above and those below, in order; empty unless they are one
    curve."""
    above: list[tuple[int, int]] = []
    below: set[tuple[int, int]] = set()
    for corners in triangles[on_rim[triangles].sum(axis=1) >= 2].tolist():
        for turn in range(3):
            start, end, third = (corners[(turn + step) % 3] for step in range(3))
            if on_rim[start] and on_rim[end] and heights[third] < 0:
                below.add((start, end))
            elif on_rim[start] and on_rim[end]:
                above.append((start, end))
    following = {start: end for start, end in above if (end, start) in below}
    count = sum((end, start) in below for start, end in above)
    if not following or count != len(following):
        return np.zeros(0, dtype=np.int64)
    order = [next(iter(following))]
    for _ in range(count - 1):
        order.append(following.get(order[-1], -1))
    is_one = len(set(order)) == count and following.get(order[-1]) == order[0]
    return np.array(order if is_one else [], dtype=np.int64)
