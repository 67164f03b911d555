"""The truth about a narrowing, by brute force: spheres tried on grids, nothing of the library.

The inscribed sphere of a station is the largest of those whose centers lie in the plane across the
vessel. Its center is searched on a grid of the plane, which is then refined about the best place.
Distances are to points that cover the surface's triangles densely.
"""

from __future__ import annotations

import itertools
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.ndimage import label
from scipy.spatial import cKDTree

from .layout import VesselTree
from .narrowing import MadeNarrowing
from .surface import Wall

HEALTHY = 0.9
"""Share of its reference below which a vessel is narrowed."""

LEAST_CALIBER = 3.1
"""Diameter, mm, below which vessels are not reported unless asked for."""

_COVERS = (0.05, 0.1, 0.2, 0.4)
"""Spacings of the points that cover the triangles, mm: fine ones for the last steps of a search."""

_STEP = 0.5
"""Spacing of stations, mm; a fifth of it near those that are nearly the narrowest."""

_NEARLY = 1.05
"""Width over the narrowest one up to which a station is nearly the narrowest: a wall of triangles
has dips that are shorter than the spacing of stations."""

_WIDER = 1.25
"""Width over the narrowest one of what passes beside a narrowing that is none: at a fork another
vessel may lie so near that both are one lumen."""

_PLATEAU = 3.0
"""Length beside the narrowing, mm, over which the healthy caliber is the median."""


@dataclass(frozen=True)
class Truth:
    """A narrowing as it is in the final surface; lengths in mm, `percent` by diameter.

    `stations` (n, 3) go along the vessel; `diameter` and `own` (n,) are its inscribed diameters and
    those it had before; `along` (n,) mm. `begin` and `end` are the extent as numbers of stations.
    """

    shape: str
    place: list[float]
    minimum: float
    reference: float
    percent: float
    proximal: float | None
    distal: float | None
    begin: int
    end: int
    at: int
    stations: list[list[float]]
    along: list[float]
    diameter: list[float]
    own: list[float]

    @property
    def length(self) -> float:
        return self.along[self.end] - self.along[self.begin]

    def as_dict(self) -> dict[str, Any]:
        return {**asdict(self), "length": self.length}


class Spheres:
    """Inscribed spheres of a surface near some places."""

    def __init__(self, wall: Wall, places: np.ndarray, reach: float) -> None:
        corners = wall.points[wall.triangles]
        apart, _ = cKDTree(places).query(corners.mean(axis=1))
        near = corners[apart < reach]
        self._covers = [cKDTree(_cover(near, apart)) for apart in _COVERS]

    def radius_at(self, place: np.ndarray) -> float:
        """Radius of the largest sphere about a place that lies inside."""
        return float(self._covers[0].query(place)[0])

    def across(self, place: np.ndarray, way: np.ndarray, within: float) -> tuple[np.ndarray, float]:
        """Center and radius of the largest sphere whose center lies in a disk inside
        of the vessel."""
        first = np.cross(way, np.eye(3)[np.argmin(np.abs(way))])
        first /= np.linalg.norm(first)
        plane = np.stack([first, np.cross(way, first)])
        steps = np.linspace(-1, 1, 9)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        grid = grid[np.linalg.norm(grid, axis=1) <= 1]
        best, size = np.zeros(2), within
        largest = float(self._covers[-1].query(place)[0])
        while size > 0.004:
            tried = best + size * grid
            tried = np.vstack([best, tried[np.linalg.norm(tried, axis=1) <= within]])
            center = place + best @ plane
            cover = self._covers[self._level(0.3 * size + 0.05 * within)]
            # Nothing farther away can touch a sphere about any of the places tried.
            most = largest + 2 * size
            wall = self._about(cover, center, most)
            shift = (tried - best) @ plane
            square = (wall**2).sum(axis=1) - 2 * shift @ wall.T
            radii = np.sqrt(square.min(axis=1) + (shift**2).sum(axis=1))
            largest = float(radii.max())
            best, size = tried[int(np.argmax(radii))], size / 3
        return place + best @ plane, largest

    @staticmethod
    def _about(cover: cKDTree, center: np.ndarray, reach: float) -> np.ndarray:
        near = np.fromiter(cover.query_ball_point(center, reach), dtype=int)
        return np.asarray(cover.data[near] - center)

    def _level(self, apart: float) -> int:
        return max(int(np.searchsorted(_COVERS, apart)) - 1, 0)


def _cover(corners: np.ndarray, apart: float) -> np.ndarray:
    """Points on triangles (n, 3, 3), at most a given distance apart."""
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(np.ceil(longest / apart).astype(int), 1)
    found = []
    for count in np.unique(parts):
        one, other = np.divmod(np.arange(count**2), count)
        inner = one + other < count
        rest = count - one - other - 2 / 3
        shares = np.stack([one + 1 / 3, other + 1 / 3, rest], axis=1)[inner] / count
        found.append(np.einsum("sk,nkx->nsx", shares, corners[parts == count]).reshape(-1, 3))
    return np.vstack([*found, corners.reshape(-1, 3)])


@dataclass(frozen=True)
class VesselCourse:
    """Stations (n, 3) along a vessel, mm apart; directions (n, 3) and radii (n,) of the tree."""

    along: np.ndarray
    points: np.ndarray
    ways: np.ndarray
    radius: np.ndarray


def course(tree: VesselTree, vessel: np.ndarray, along: np.ndarray) -> VesselCourse:
    """Stations of a vessel at arc lengths (n,) from its first point."""
    own = tree.arc_length[vessel] - tree.arc_length[vessel[0]]
    along = along[(along >= own[0]) & (along <= own[-1])]
    line = [
        np.stack([np.interp(at, own, x) for x in tree.points[vessel].T], axis=1)
        for at in (along - 1.0, along, along + 1.0)
    ]
    ways = line[2] - line[0]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    return VesselCourse(along, line[1], ways, np.interp(along, own, tree.radius[vessel]))


def profile(spheres: Spheres, stations: VesselCourse) -> tuple[np.ndarray, np.ndarray]:
    """Centers (n, 3) and diameters (n,) of the largest spheres across a vessel."""
    found = [
        spheres.across(place, way, 0.9 * radius)
        for place, way, radius in zip(stations.points, stations.ways, stations.radius, strict=True)
    ]
    return np.array([c for c, _ in found]), 2 * np.array([r for _, r in found])


def truths(
    before: tuple[VesselTree, Wall | None],
    after: tuple[VesselTree, Wall | None],
    narrowing: MadeNarrowing,
) -> list[Truth]:
    """The truth about a narrowing: one, or as many as healthy vessel separates.

    Raises
    ------
    ValueError
        It is not as intended: too shallow, or the surface separates what the shape does not.
    """
    begin, end = narrowing.healthy
    is_ostial = narrowing.shape == "ostial"
    tree, vessel = before[0], narrowing.vessel
    # Within a radius of its end no sphere is as wide as the vessel: that is no narrowing.
    last = float(tree.arc_length[vessel[-1]] - tree.arc_length[vessel[0]] - tree.radius[vessel[-1]])
    along = np.arange(max(begin - 2 * _PLATEAU, 0.0), min(end + 2 * _PLATEAU, last), _STEP)
    healthy = _measured(*before, vessel, along[::2])
    distal = _plateau(healthy, end, end + _PLATEAU)
    proximal = None if is_ostial else _plateau(healthy, begin - _PLATEAU, begin)
    if min(distal, proximal or distal) < LEAST_CALIBER:
        raise ValueError(f"a vessel below {LEAST_CALIBER} mm")
    ends = [begin - _PLATEAU / 2, end + _PLATEAU / 2]

    def reference(at: np.ndarray) -> np.ndarray:
        return np.interp(at, ends, [distal if proximal is None else proximal, distal])

    course_, centers, wide = _measured(*after, vessel, along)
    along = course_.along
    parts = _parts(along, wide / reference(along))
    if len(parts) != (2 if narrowing.shape == "tandem apart" else 1):
        raise ValueError(f"{narrowing.shape}: {len(parts)} parts")
    lowest = [first + int(np.argmin(wide[first : last + 1])) for first, last in parts]
    if (wide[lowest] > HEALTHY * np.interp(along[lowest], healthy[0].along, healthy[2])).any():
        raise ValueError(f"{narrowing.shape}: narrowest where the vessel was so before")
    if is_ostial and lowest[0] == parts[0][0]:
        raise ValueError("ostial: narrowest at the parent's end")
    narrow = [
        first + np.flatnonzero(wide[first : last + 1] <= _NEARLY * wide[at])
        for (first, last), at in zip(parts, lowest, strict=True)
    ]
    steps = _STEP * np.array([-0.8, -0.6, -0.4, -0.2, 0.2, 0.4, 0.6, 0.8])
    fine = np.unique((along[np.concatenate(narrow), None] + steps).round(6))
    more, more_centers, more_wide = _measured(*after, vessel, fine)
    order = np.argsort(np.r_[along, more.along], kind="stable")
    along = np.r_[along, more.along][order]
    centers = np.vstack([centers, more_centers])[order]
    wide = np.r_[wide, more_wide][order]
    points = np.vstack([course_.points, more.points])[order]
    own = np.interp(along, healthy[0].along, healthy[2])
    found = []
    for first, last in _parts(along, wide / reference(along)):
        at = first + int(np.argmin(wide[first : last + 1]))
        against = float(reference(along[at : at + 1])[0])
        if _is_passed(after[1], centers[[first, at, last]], float(wide[at])):
            raise ValueError(f"{narrowing.shape}: a wider way leads past it")
        found.append(
            Truth(
                str(narrowing.shape), centers[at].tolist(), float(wide[at]), against,
                float(100 * (1 - wide[at] / against)), proximal, distal, first, last, at,
                points.tolist(), along.tolist(), wide.tolist(), own.tolist(),
            )
        )  # fmt: skip
    return found


def _is_passed(wall: Wall | None, way: np.ndarray, narrowest: float) -> bool:
    """Whether a clearly wider sphere passes a narrowing, whatever way it takes from one end of that
    to the other; `way` (3, 3) is those and the narrowest place."""
    if wall is None:
        return False
    radius = _WIDER * narrowest / 2
    low, high = way.min(axis=0) - 3 * radius, way.max(axis=0) + 3 * radius
    corners = wall.points[wall.triangles]
    is_near = ((corners.max(axis=1) > low - radius) & (corners.min(axis=1) < high + radius)).all(1)
    cover = cKDTree(_cover(corners[is_near], _COVERS[1]))
    # Cells are closer than the wall: no two of them lie on different sides of it.
    step = radius / 5
    counts = np.ceil((high - low) / step).astype(int) + 1
    grid = low + step * np.moveaxis(np.indices(counts), 0, -1)
    room, _ = cover.query(grid, distance_upper_bound=radius)
    parts, _ = label(np.isinf(room), np.ones((3, 3, 3)))
    begin, end = (tuple(np.rint((one - low) / step).astype(int)) for one in way[[0, 2]])
    return bool(parts[begin] == parts[end] > 0)


def _measured(
    tree: VesselTree, wall: Wall | None, vessel: np.ndarray, along: np.ndarray
) -> tuple[VesselCourse, np.ndarray, np.ndarray]:
    """Stations, and centers (n, 3) and diameters (n,) of their spheres.

    Without a wall they are those in the tree's own spheres.
    """
    stations = course(tree, vessel, along)
    if wall is None:
        return stations, stations.points, width_in(tree, stations.points)
    spheres = Spheres(wall, stations.points, 2.2 * float(stations.radius.max()) + 1.0)
    return stations, *profile(spheres, stations)


def width_in(tree: VesselTree, places: np.ndarray) -> np.ndarray:
    """Diameters (n,) of the largest spheres about places in a tree's own spheres, mm."""
    widest = float(tree.radius.max())
    near = cKDTree(tree.points).query_ball_point(places, widest)
    radii = [
        (tree.radius[own] - np.linalg.norm(tree.points[own] - place, axis=1)).max(initial=0.0)
        for own, place in zip(near, places, strict=True)
    ]
    return 2 * np.array(radii)


def _plateau(
    measured: tuple[VesselCourse, np.ndarray, np.ndarray], begin: float, end: float
) -> float:
    along = measured[0].along
    return float(np.median(measured[2][(along >= begin) & (along <= end)]))


def _parts(along: np.ndarray, share: np.ndarray) -> list[tuple[int, int]]:
    """First and last stations of parts in which a vessel is narrower by a quarter somewhere.

    Raises
    ------
    ValueError
        A part between two narrowings is neither clearly healthy nor clearly narrowed.
    """
    below = share < HEALTHY
    edges = np.flatnonzero(np.diff(np.r_[False, below, False].astype(int)))
    runs = [(a, b - 1) for a, b in edges.reshape(-1, 2).tolist() if share[a:b].min() < 0.75]
    for (_, last), (first, _) in itertools.pairwise(runs):
        if along[first] - along[last] < 4.0 or np.median(share[last:first]) < 0.96:
            raise ValueError("hardly healthy between two narrowings")
    return runs


def degree_beside(
    tree: VesselTree, wall: Wall | None, place: np.ndarray, reach: float = 20.0
) -> float:
    """Degree, %, by which a vessel is narrower near a place than on both sides within `reach` mm.

    The narrower of the two sides counts, so that a tapering vessel has 0 %. Proximal of the
    beginning of a vessel its parent counts, as a narrowing may go across a fork.
    """
    node = int(np.argmin(np.linalg.norm(tree.points - place, axis=1) - 0.5 * tree.radius))
    vessel = next(one for one in tree.vessels if node in one[1:] or node == 0)
    line = np.concatenate([tree.path_to(int(vessel[0]))[:-1], vessel])
    own = tree.arc_length[line] - tree.arc_length[line[0]]
    at = float(own[np.flatnonzero(line == node)[0]])
    along = np.arange(max(at - reach, 0.0), min(at + reach, float(own[-1])), 1.0)
    if len(along) < 3:
        return 0.0
    stations, _, wide = _measured(tree, wall, line, along)
    is_near = np.abs(stations.along - at) <= 3.0
    if not is_near.any():
        return 0.0
    narrowest = int(np.argmin(np.where(is_near, wide, np.inf)))
    sides = [side.max() for side in (wide[:narrowest], wide[narrowest:]) if len(side) > 3]
    return float(100 * (1 - wide[narrowest] / min(sides))) if sides else 0.0
