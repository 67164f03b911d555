"""Which side branches lie under a stent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..centerline import as_parents
from ..geometry import arc_lengths, closest_points, without_repeats
from ..validation import Floats, InputError, Points, as_number, as_points, read_only


@dataclass(frozen=True)
class BranchOstium:
    """The opening of a side branch, seen from the stent. All mm."""

    position: Floats
    """(3,) where the branch's centerline leaves the lumen of the stented vessel."""
    radius: float
    """Inscribed radius of the branch there; NaN when the centerline has none."""
    distance_inside_proximal_end: float
    """From the proximal end of the stent along the axis; negative: proximal of the stent."""
    distance_inside_distal_end: float
    """From the distal end of the stent, backward; negative: distal of the stent."""
    is_covered: bool
    """Whether any part of the opening lies between the two ends."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", read_only(self.position))


def branch_ostia(
    points: ArrayLike,
    parent: ArrayLike,
    stent_axis: ArrayLike,
    inscribed_radius: ArrayLike | None = None,
    *,
    margin: float = 10.0,
) -> tuple[BranchOstium, ...]:
    """Side branches of a centerline tree near a stent, from proximal to distal.

    The stented vessel is the way through the tree from one end of the stent to the other,
    continued at both ends in the straightest direction. What else leaves it is a side branch. Its
    ostium is the first point of its centerline that lies outside the vessel's inscribed spheres
    (without radii: the point where it leaves the vessel's centerline). A branch that ends
    inside them is none.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        The tree's points, mm.
    parent : array_like of int, shape (n,)
        Index of the next point towards the root, -1 at a root.
    stent_axis : array_like, shape (k, 3)
        Polyline from the proximal to the distal end of the stent.
    inscribed_radius : array_like, shape (n,), optional
        NaN where unknown.
    margin : float
        How far beyond the ends of the stent branches are listed, mm.

    Raises
    ------
    InputError
        Arrays that do not fit, parents that are no points or go round in a circle, or ends of the
        stent in two trees.
    """
    points = as_points(points, minimum=2)
    axis = without_repeats(as_points(stent_axis, "stent_axis", minimum=2))
    if len(axis) < 2:
        raise InputError("stent_axis: expected two different points at least, got one place.")
    as_number(margin, "margin", unit="mm", minimum=0)
    neighbors = _neighbors(parent, len(points))
    radii = _radii(inscribed_radius, len(points))
    ends = [int(np.argmin(np.linalg.norm(points - end, axis=1))) for end in (axis[0], axis[-1])]
    path = _way(neighbors, *ends)
    path = _continued(points, neighbors, path, margin + _radius_at(radii, path[-1]))
    path = _continued(points, neighbors, path[::-1], margin + _radius_at(radii, path[0]))[::-1]

    on_path = set(path)
    found = [
        _ostium(points, neighbors, radii, path, index, branch, axis)
        for index in path[1:-1]
        for branch in neighbors[index]
        if branch not in on_path
    ]
    near = [
        ostium
        for ostium in found
        if ostium is not None
        and min(ostium.distance_inside_proximal_end, ostium.distance_inside_distal_end) >= -margin
    ]
    return tuple(sorted(near, key=lambda ostium: ostium.distance_inside_proximal_end))


def _radii(inscribed_radius: ArrayLike | None, count: int) -> Floats:
    radii = np.full(count, np.nan) if inscribed_radius is None else inscribed_radius
    radii = np.asarray(radii, dtype=np.float64)
    if radii.shape != (count,):
        raise InputError(
            f"inscribed_radius: expected one for each of {count} points, got {radii.shape}."
        )
    return radii


def _neighbors(parent: ArrayLike, count: int) -> list[list[int]]:
    neighbors: list[list[int]] = [[] for _ in range(count)]
    for child, upstream in enumerate(as_parents(parent, count).tolist()):
        if upstream >= 0:
            neighbors[child].append(upstream)
            neighbors[upstream].append(child)
    return neighbors


def _way(neighbors: list[list[int]], start: int, end: int) -> list[int]:
    """Indices from `start` to `end` through the tree, both included."""
    came_from = {start: start}
    waiting = [start]
    # Ends: every point comes in once.
    while waiting and end not in came_from:
        index = waiting.pop()
        for following in neighbors[index]:
            if following not in came_from:
                came_from[following] = index
                waiting.append(following)
    if end not in came_from:
        raise InputError(
            "stent_axis: expected both ends in one tree of the centerline, got two separate "
            "trees; use a centerline that connects them."
        )
    way = [end]
    # Ends: every point came from one that was in earlier, and only the start from itself.
    while way[-1] != start:
        way.append(came_from[way[-1]])
    return way[::-1]


def _continued(
    points: Points, neighbors: list[list[int]], path: list[int], length: float
) -> list[int]:
    """The path, led on beyond its last point in the straightest direction."""
    path, travelled = list(path), 0.0
    if len(path) == 1 and neighbors[path[0]]:
        path = [neighbors[path[0]][0], path[0]]
    # Ends: never back, and the tree has no circle.
    while travelled < length:
        onward = [index for index in neighbors[path[-1]] if index not in path[-2:]]
        if not onward:
            break
        heading = points[path[-1]] - points[path[max(0, len(path) - 4)]]
        turns = [_cosine(points[index] - points[path[-1]], heading) for index in onward]
        path.append(onward[int(np.argmax(turns))])
        travelled += float(np.linalg.norm(points[path[-1]] - points[path[-2]]))
    return path


def _ostium(
    points: Points,
    neighbors: list[list[int]],
    radii: Floats,
    path: list[int],
    junction: int,
    branch: int,
    axis: Points,
) -> BranchOstium | None:
    vessel, vessel_radii = points[path], radii[path]
    previous, index = junction, branch
    # Ends: never back, and the tree has no circle. Without radii the comparison is false at once:
    # the branch leaves at its first point.
    while _is_in_vessel(points[index], vessel, vessel_radii):
        onward = [following for following in neighbors[index] if following != previous]
        if not onward:
            return None
        previous, index = index, onward[0]
    position = points[index] if np.isfinite(radii[junction]) else points[junction]
    radius = float(radii[index])
    inside = _position_on(axis, position)
    total = float(arc_lengths(axis)[-1])
    half_width = radius if np.isfinite(radius) else 0.0
    is_covered = -half_width <= inside <= total + half_width
    return BranchOstium(position, radius, inside, total - inside, bool(is_covered))


def _is_in_vessel(point: Floats, vessel: Points, radii: Floats) -> bool:
    return bool(np.any(np.linalg.norm(vessel - point, axis=1) < radii))


def _position_on(axis: Points, point: Floats) -> float:
    """Arc length of the nearest point of the axis, led on straight beyond its ends, mm."""
    length = float(arc_lengths(axis)[-1])
    before = axis[0] + (axis[0] - axis[1]) / np.linalg.norm(axis[1] - axis[0]) * 1e4
    after = axis[-1] + (axis[-1] - axis[-2]) / np.linalg.norm(axis[-1] - axis[-2]) * 1e4
    at = float(closest_points(np.vstack([before, axis, after]), point[None]).arc_lengths[0]) - 1e4
    return float(np.clip(at, -1e4, length + 1e4))


def _radius_at(radii: Floats, index: int) -> float:
    return float(np.nan_to_num(radii[index]))


def _cosine(a: Floats, b: Floats) -> float:
    scale = np.linalg.norm(a) * np.linalg.norm(b)
    return float(a @ b / scale) if scale > 0 else -1.0
