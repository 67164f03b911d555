"""Meshes of the synthetic vessels: walls swept along an axis, flat caps, edge flips."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from SDFStentLib.geometry import dot, edges, face_normals
from SDFStentLib.validation import Floats, Indices, Points, Triangles

from .axis import TrueAxis

ROW_HEIGHT = np.sqrt(0.75)
"""Height of an equilateral triangle over its side."""


class FacedMesh(NamedTuple):
    """Points, triangles, and a face id for each triangle."""

    points: Points
    triangles: Triangles
    face_ids: Indices


def swept_tube(
    axis: TrueAxis, radius: Callable[[Floats], Floats], edge_length: float, first_face_id: int = 1
) -> FacedMesh:
    """A closed tube of circles across the axis: wall, cap at the start, cap at the end.

    All circles have as many points, so that edges shrink with the radius and triangles stay
    near equilateral; the longest edges of a straight tube have the requested length. Rows are
    staggered by half an edge.

    Parameters
    ----------
    axis : TrueAxis
        The tube's axis; its bends must have a radius larger than the tube's.
    radius : callable
        Radius of the circle by arc length, mm.
    edge_length : float
        Requested edge length where the tube is widest, mm.
    first_face_id : int
        Id of the wall; the caps take the next two.
    """
    stations, count = _stations(axis, radius, edge_length)
    angles = (np.arange(count) + np.arange(len(stations))[:, None] / 2) * (2 * np.pi / count)
    tangent, normal = axis.tangent(stations), axis.normal(stations)
    radial = (
        np.cos(angles)[..., None] * normal[:, None]
        + np.sin(angles)[..., None] * np.cross(tangent, normal)[:, None]
    )
    rings = axis.point(stations)[:, None] + radius(stations)[:, None, None] * radial
    wall = FacedMesh(
        rings.reshape(-1, 3),
        _staggered_rows(len(stations), count),
        np.full(2 * count * (len(stations) - 1), first_face_id, dtype=np.int64),
    )
    last = count * (len(stations) - 1)
    wall = with_cap(wall, np.arange(count), -tangent[0], first_face_id + 1)
    return with_cap(wall, last + np.arange(count), tangent[-1], first_face_id + 2)


def with_cap(patch: FacedMesh, rim: Indices, outward: Floats, face_id: int) -> FacedMesh:
    """The patch with a flat cap over a round rim, made of rings of near-uniform triangles.

    Parameters
    ----------
    patch : FacedMesh
        The mesh to which the rim belongs.
    rim : (k,) array
        Indices of the rim's points, on a circle, in order around it.
    outward : (3,) array
        Unit normal of the cap, out of the lumen.
    face_id : int
        Face id of the new triangles.
    """
    loop = patch.points[rim]
    center = loop.mean(axis=0)
    center = center + ((loop[0] - center) @ outward) * outward  # in the rim's plane to the bit
    first = loop[0] - center
    first = first / np.linalg.norm(first)
    plane = np.stack([first, np.cross(outward, first)])
    inner, triangles = disc((loop - center) @ plane.T)
    numbers = np.r_[rim, len(patch.points) + np.arange(len(inner))]
    return FacedMesh(
        np.vstack([patch.points, center + inner @ plane]),
        np.vstack([patch.triangles, numbers[triangles]]),
        np.r_[patch.face_ids, np.full(len(triangles), face_id, dtype=np.int64)],
    )


def disc(rim: Floats) -> tuple[Floats, Triangles]:
    """Fill a circle of points (k, 2) around the origin: inner points and triangles.

    Triangles turn counterclockwise; indices from k on are those of inner points.
    """
    # Late: scipy.spatial costs more to import than the rest of the library together.
    from scipy.spatial import Delaunay

    inner = _inner_rings(rim)
    triangles = Delaunay(np.vstack([rim, inner])).simplices
    for _ in range(4):
        inner = _centered(np.vstack([rim, inner]), triangles)[len(rim) :]
        triangles = Delaunay(np.vstack([rim, inner])).simplices
    points = np.vstack([rim, inner])
    return inner, _counterclockwise(points, triangles.astype(np.int64))


def flipped(points: Points, triangles: Triangles, rounds: int = 3) -> Triangles:
    """Triangles after Delaunay flips of edges whose opposite angles together exceed 180 degrees.

    A flip that would fold the surface, or make an edge a second time, is left out. Rims stay.
    """
    for _ in range(rounds):
        chosen = _edges_to_flip(points, triangles)
        if not len(chosen.faces):
            break
        triangles = triangles.copy()
        a, b, c, d = chosen.corners.T
        triangles[chosen.faces[:, 0]] = np.stack([c, a, d], axis=1)
        triangles[chosen.faces[:, 1]] = np.stack([c, d, b], axis=1)
    return triangles


class _Flips(NamedTuple):
    """Edges a-b to be replaced by c-d, with the two faces (k, 2) and corners a b c d (k, 4)."""

    faces: Indices
    corners: Indices


def _edges_to_flip(points: Points, triangles: Triangles) -> _Flips:
    found = edges(triangles)
    faces, side = np.divmod(found.paired_sides, 3)
    a = triangles[faces[:, 0], side[:, 0]]
    b = triangles[faces[:, 0], (side[:, 0] + 1) % 3]
    c = triangles[faces[:, 0], (side[:, 0] + 2) % 3]
    d = triangles[faces[:, 1], (side[:, 1] + 2) % 3]
    excess = -(_cotangent(points, c, a, b) + _cotangent(points, d, a, b))
    wanted = np.flatnonzero(excess > 1e-9)  # few once a mesh is even
    faces, excess = faces[wanted], excess[wanted]
    a, b, c, d = (corner[wanted] for corner in (a, b, c, d))

    old = face_normals(points, triangles[faces[:, 0]]) + face_normals(
        points, triangles[faces[:, 1]]
    )
    wanted = np.ones(len(faces), dtype=bool)
    for corners in (np.stack([c, a, d], axis=1), np.stack([c, d, b], axis=1)):
        wanted &= dot(face_normals(points, corners), old) > 1.0
    base = len(points)
    old_keys = found.vertices[:, 0] * base + found.vertices[:, 1]  # they rise
    new_keys = np.minimum(c, d) * base + np.maximum(c, d)
    at = np.minimum(np.searchsorted(old_keys, new_keys), len(old_keys) - 1)
    wanted &= old_keys[at] != new_keys

    # One flip per face and round: the edge that is worst in both its faces.
    score = np.where(wanted, excess, 0)
    worst = np.zeros(len(triangles))
    np.maximum.at(worst, faces.ravel(), np.repeat(score, 2))
    chosen = np.flatnonzero(wanted & (score >= worst[faces].max(axis=1)))
    chosen = chosen[np.unique(new_keys[chosen], return_index=True)[1]]
    _, first = np.unique(faces[chosen].ravel(), return_index=True)
    alone = np.zeros(2 * len(chosen), dtype=bool)
    alone[first] = True
    chosen = chosen[alone.reshape(-1, 2).all(axis=1)]
    return _Flips(faces[chosen], np.stack([a, b, c, d], axis=1)[chosen])


def _cotangent(points: Points, apex: Indices, start: Indices, end: Indices) -> Floats:
    """Cotangent of the angle at `apex`."""
    first, second = points[start] - points[apex], points[end] - points[apex]
    doubled_area = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(dot(first, second) / np.maximum(doubled_area, 1e-300))


def _stations(
    axis: TrueAxis, radius: Callable[[Floats], Floats], edge_length: float
) -> tuple[Floats, int]:
    """Arc lengths of the circles, and the number of points on each."""
    samples = axis.sampled(min(0.05, axis.length / 1000))
    radii = radius(samples)
    count = max(int(np.ceil(2 * np.pi * radii.max() / edge_length - 1e-9)), 6)
    # In the coordinate ds / r the rows of a tube of any radius are equally far apart.
    per_length = 1 / radii
    stretched = np.r_[0, np.cumsum(np.diff(samples) * (per_length[1:] + per_length[:-1]) / 2)]
    rows = max(round(stretched[-1] / (2 * np.pi / count * ROW_HEIGHT)), 2)
    return np.interp(np.linspace(0, stretched[-1], rows + 1), stretched, samples), count


def _staggered_rows(rows: int, count: int) -> Triangles:
    start = (np.arange(rows - 1) * count)[:, None]
    here = np.arange(count)
    following = (here + 1) % count
    lower = np.stack([start + here, start + following, start + count + here], axis=-1)
    upper = np.stack([start + following, start + count + following, start + count + here], axis=-1)
    return np.concatenate([lower, upper], axis=1).reshape(-1, 3)


def _inner_rings(rim: Floats) -> Floats:
    """The center and circles around it, as far apart as the rim's points."""
    outer = float(np.linalg.norm(rim, axis=1).mean())
    spacing = 2 * np.pi * outer / len(rim)
    rings = max(round(outer / (spacing * ROW_HEIGHT)), 1)
    start = np.arctan2(rim[0, 1], rim[0, 0])
    points = [np.zeros((1, 2))]
    for ring in range(1, rings):
        reach = outer * ring / rings
        count = max(round(2 * np.pi * reach / spacing), 6)
        angles = start + (np.arange(count) + (rings - ring) / 2) * (2 * np.pi / count)
        points.append(reach * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return np.vstack(points)


def _centered(points: Floats, triangles: Indices) -> Floats:
    """Points moved halfway to the mean of the corners of their triangles."""
    corners = triangles.ravel()
    weight = np.bincount(corners, minlength=len(points))
    total = np.stack(
        [np.bincount(corners, np.repeat(sums, 3)) for sums in points[triangles].sum(axis=1).T],
        axis=1,
    )
    return np.asarray(0.5 * points + 0.5 * total / (3 * weight[:, None]))


def _counterclockwise(points: Floats, triangles: Indices) -> Indices:
    first = points[triangles[:, 1]] - points[triangles[:, 0]]
    second = points[triangles[:, 2]] - points[triangles[:, 0]]
    turns_back = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0
    return np.where(turns_back[:, None], triangles[:, ::-1], triangles)
