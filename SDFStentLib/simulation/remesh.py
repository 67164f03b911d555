"""A surface for a volume mesh: triangles as large as its vessel allows, on the wall as it was."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..certificate import check_surface, smallest_angles
from ..geometry import Surface, SurfaceIndex, edges, section_around, vertex_normals
from ..segment import Segment
from ..validation import DeploymentError, Flags, Floats, Indices, Points
from .mmg import MeditMesh, by_mmg

TOLERANCE = 0.02
"""Largest distance of the old wall's points from the new one, mm."""

CHORD = 0.75
"""Part of the tolerance that the edges of a round wall may take."""

TRIES = ((35, 0.9), (25, 0.9), (35, 0.7), (25, 0.7), (20, 0.5))
"""Attempts in turn: degrees between two triangles from which on their edge is kept, as that round a
cap is, and times the tolerance. MMG keeps it only nearly, and now and then lays a wall that is bent
sharply over itself: with another angle it does not."""

MENDS = 10
"""Times at most that the corners of faulty triangles go to the mean of their neighbors."""

SLIM_DEG = 10.0
"""Smallest angle below which a triangle counts as faulty: tetrahedra on it are as flat."""

GRADING = 1.25
"""Largest ratio of an edge to the next one."""

SPARE = 1.2
"""Largest ratio of an edge to the wanted size, as they come out."""

NEAR = 32
"""Points of the centerline among which the vessel of a place is looked for."""


class Wishes(NamedTuple):
    """Fineness of a mesh."""

    edges_round: float = 20.0
    """The least number of edges that go round the vessel everywhere."""
    coarser: float = 1.0
    """Times the size of all edges: a second mesh of the same kind."""

    @property
    def tolerance(self) -> float:
        """mm; what chords leave grows with the square of their length."""
        return TOLERANCE * self.coarser**2


class Axis(NamedTuple):
    """Radii of a vessel along its centerlines, for places of its wall."""

    points: Points
    """(k, 3) along the centerlines, mm."""
    radius: Floats
    """(k,) of the lumen there, mm."""

    def nearest(self, points: Points) -> Indices:
        """The point of the centerlines in whose vessel each place (n, 3) is, or least outside."""
        # Late: scipy costs what a first frame should not pay.
        from scipy.spatial import cKDTree

        away, near = cKDTree(self.points).query(points, k=[*range(1, 1 + NEAR)])
        near = np.minimum(near, len(self.points) - 1)  # those that are missing are infinitely far
        best = np.argmin(away - self.radius[near], axis=1)
        return np.asarray(near[np.arange(len(points)), best])

    def radius_at(self, points: Points) -> Floats:
        """Radii of the vessel in which places (n, 3) are, mm."""
        return np.asarray(self.radius[self.nearest(points)])


class Remeshed(NamedTuple):
    """A closed surface of new triangles."""

    surface: Surface
    face_ids: Indices
    """(m,)"""
    deviation: float
    """The distance of the old points from it, mm."""


def axis_of(surface: Surface, is_wall: Flags, line: Points) -> Axis:
    """The radii of a closed or open lumen along points (k, 3) of centerlines.

    `is_wall` (m,) are the triangles that are no caps. Points outside of a closed one are left out.
    """
    from scipy.spatial import cKDTree

    if surface.topology.is_watertight:
        line = line[surface.contains(line)]
    corners = surface.points[surface.triangles[is_wall]]
    wall = np.vstack([corners.reshape(-1, 3), corners.mean(axis=1)])
    return Axis(line, np.asarray(cKDTree(wall).query(line)[0]))


def edge_sizes(points: Points, axis: Axis, wishes: Wishes) -> Floats:
    """Edges (n,) so long that enough go round the vessel, and a round wall is kept, mm."""
    radius = axis.radius_at(points)
    chord = np.sqrt(8 * radius * CHORD * TOLERANCE)
    size = np.minimum(2 * np.pi * radius / (SPARE * wishes.edges_round), chord)
    return np.asarray(wishes.coarser * size)


def remeshed(segment: Segment, axis: Axis, wishes: Wishes) -> Iterator[Remeshed]:
    """A segment with triangles sized by its radius, by MMG, in one way after the other.

    MMG keeps the borders of caps, and lays new points on the curved wall for which the old
    triangles stand.

    Raises
    ------
    InputError
        MMG is not installed.
    DeploymentError
        It fails, or in all ways crosses itself or leaves the wall by more than the tolerance;
        coarser meshes may leave it, and say so.
    """
    old, none = segment.surface, np.zeros((0, 4), np.int64)
    is_wall = np.isin(segment.face_ids, [*segment.walls])
    # One wall: triangles along borders that run anywhere through it would be slim.
    one_wall = min(segment.walls)
    merged = np.where(is_wall, one_wall, segment.face_ids)
    mesh = MeditMesh(old.points, old.triangles, merged, none)
    sizes = edge_sizes(old.points, axis, wishes)
    fault, is_found = "", False
    for angle, part in TRIES:
        options = [
            "-ar",
            f"{angle}",
            "-hgrad",
            f"{GRADING}",
            "-hausd",
            f"{part * wishes.tolerance}",
        ]
        made = by_mmg("mmgs", mesh, sizes, options)
        surface = mended(made)
        away = SurfaceIndex(surface.points, made.triangles).distances(old.points).distance.max()
        check = check_surface(surface)
        if not check.passed:
            fault = f"one that is not sound ({check.sentence().rstrip('.')})"
        elif away > wishes.tolerance and wishes.coarser == 1:
            fault = f"one {away:.3f} mm from it"
        else:
            is_found = True
            ids, own = made.faces.copy(), made.faces == one_wall
            wall = SurfaceIndex(old.points, old.triangles[is_wall])
            middles = surface.points[made.triangles[own]].mean(axis=1)
            ids[own] = segment.face_ids[is_wall][wall.distances(middles).triangle]
            yield Remeshed(surface, ids, float(away))
    if not is_found:
        raise DeploymentError(
            f"mesh: expected one within {wishes.tolerance:g} mm of the wall, got {fault}; look for "
            "spikes and folds with sdfstent check, or choose other ends of the segment."
        )


def mended(made: MeditMesh) -> Surface:
    """A surface whose few turned, crossing or slim triangles are spread out, where that mends them.

    Corners between faces stay where they are, those of triangles that are only slim go along the
    wall, and a surface that is sound stays so.
    """
    points, triangles = made.points.copy(), made.triangles
    ends = edges(triangles).vertices
    both = np.vstack([ends, ends[:, ::-1]])
    count = np.bincount(both[:, 0], minlength=len(points))
    least, most = np.full(len(points), made.faces.max()), np.full(len(points), -1)
    for corner in triangles.T:
        np.minimum.at(least, corner, made.faces)
        np.maximum.at(most, corner, made.faces)
    surface = sound = Surface(points, triangles, name="mesh")
    is_sound = False
    for _ in range(MENDS):
        faulty = [one for spot in check_surface(surface).places for one in spot.triangles]
        if not faulty:
            sound, is_sound = surface, True
        slim = np.flatnonzero(smallest_angles(points, triangles) < SLIM_DEG)
        corners = np.unique(triangles[[*faulty, *slim.tolist()]])
        corners = corners[least[corners] == most[corners]]
        if not len(corners):
            break
        total = np.zeros_like(points)
        np.add.at(total, both[:, 0], points[both[:, 1]])
        step = total[corners] / count[corners, None] - points[corners]
        # Inward a mean leaves a bent wall by more than the tolerance.
        normals = vertex_normals(points, triangles)[corners]
        normals[np.isin(corners, triangles[faulty])] = 0.0
        step -= (step * normals).sum(axis=1, keepdims=True) * normals
        points = points.copy()
        points[corners] += step
        surface = Surface(points, triangles, name="mesh")
    return sound if is_sound else surface


def edges_around(surface: Surface, origin: Points, normal: Floats) -> int:
    """Number of edges round a surface in a plane: half of the triangles that it cuts there."""
    section = section_around(surface.points, surface.triangles, origin, normal)
    return 0 if section is None else len(section.triangles) // 2
