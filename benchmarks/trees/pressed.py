"""Real surfaces with narrowings pressed into them: vessels that are neither round nor even.

The mesh of a patient stays; its points move toward the line of a vessel. The truth is measured in
the surfaces before and after, as in synthetic trees; lesions that the patient has anyway are no
part of it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import vtk
from scipy.spatial import cKDTree
from vtk.util.numpy_support import vtk_to_numpy

from .case import TreeCase
from .layout import VesselTree, read_tree, resampled
from .narrowing import SHAPES, MadeNarrowing, narrowed, narrowings
from .surface import Wall
from .truth import Truth, truths

PATIENTS = (("su0243", "mm"), ("pulmonary", "cm"), ("aorta_iliac", "cm"))
"""Patients with a surface and a centerline, and the unit of these."""

_FADES = (1.3, 2.5)
"""Distances from the line of a vessel, in its radii: wall nearer than the first moves in full, wall
farther than the second stays."""

_SAME = 0.5
"""Distance, in radii, within which lines of a file are one vessel."""


def pressed_case(seed: int, number: int, data: Path, only: str | None = None) -> TreeCase:
    """The case of a number: one of the patients, with up to four narrowings."""
    random = np.random.default_rng([seed, number, 1])
    name, unit = PATIENTS[number % len(PATIENTS)]
    scale = 10.0 if unit == "cm" else 1.0
    native = _read_wall(data / f"{name}_surface_{unit}.vtp", scale)
    line = data / f"{name}_centerline_{unit}.vtp"
    tree = read_tree(line, 1.0) if unit == "cm" else tree_of_lines(line)
    chosen = narrowings(tree, [only] * 4 if only else list(random.permutation(SHAPES)[:4]), random)
    wall = native
    for one in chosen:
        wall = pressed(wall, tree, one)
    after = narrowed(tree, chosen)
    found: list[Truth] = []
    refused: list[str] = []
    for one in chosen:
        try:
            found += truths((tree, native), (after, wall), one)
        except ValueError as error:
            refused.append(str(error))
    facts: dict[str, Any] = {
        "tree": name, "ends": "capped", "seed": seed, "number": number,
        "outlets": len(tree.leaves), "triangles": len(wall.triangles), "refused": refused,
        "wander": 0.0, "has_radius": bool(random.uniform() < 0.7),
    }  # fmt: skip
    return TreeCase(f"{name}_{number:04d}", after, wall, found, facts)


def pressed(wall: Wall, tree: VesselTree, one: MadeNarrowing) -> Wall:
    """A wall whose points near a narrowed vessel have moved toward its line by its factor."""
    vessel = one.vessel
    along = tree.arc_length[vessel] - tree.arc_length[vessel[0]]
    caliber = tree.calibers[int(vessel[1])]
    factor = one.factor
    if one.shape == "ostial":
        # The wall of the parent, beyond the throat, is no wall of the vessel.
        share = np.clip((one.throats[0] - along) / caliber, 0.0, 1.0)
        factor = 1 - (1 - factor) * (1 + np.cos(np.pi * share)) / 2
    at = np.arange(0.0, along[-1], 0.05)
    line = np.stack([np.interp(at, along, x) for x in tree.points[vessel].T], axis=1)
    away, nearest = cKDTree(line).query(wall.points)
    wide = np.minimum(np.interp(at, along, tree.radius[vessel]), 1.3 * caliber)[nearest]
    share = np.clip((away / wide - _FADES[0]) / (_FADES[1] - _FADES[0]), 0.0, 1.0)
    moves = (1 - np.interp(at, along, factor)[nearest]) * (1 + np.cos(np.pi * share)) / 2
    moves[~_is_of(tree, vessel[one.factor < 1], caliber)[_nearest(tree, wall.points)]] = 0.0
    places = wall.points + moves[:, None] * (line[nearest] - wall.points)
    return wall._replace(points=places)


def _nearest(tree: VesselTree, points: np.ndarray) -> np.ndarray:
    """The points of the tree whose spheres are nearest to some points (n, 3)."""
    away, about = cKDTree(tree.points).query(points, k=min(32, len(tree.points)))
    order = (away - tree.radius[about]).argmin(axis=1)
    return np.asarray(about[np.arange(len(points)), order])


def _is_of(tree: VesselTree, narrow: np.ndarray, caliber: float) -> np.ndarray:
    """Whether each point (n,) of a tree is narrowed, or hangs on such points within
    a few calibers."""
    found = np.zeros(len(tree.points), dtype=bool)
    left = np.full(len(tree.points), -1.0)
    left[narrow] = 4.0 * caliber
    waiting = narrow.tolist()
    while waiting:
        one = waiting.pop()
        found[one] = True
        for other in (*tree.children[one], int(tree.parent[one])):
            if other < 0:
                continue
            rest = left[one] - abs(tree.arc_length[other] - tree.arc_length[one])
            if rest > left[other] + 1e-9 and rest > 0:
                left[other] = rest
                waiting.append(other)
    return found


def tree_of_lines(path: Path) -> VesselTree:
    """The tree of lines from the root to every end, with `MaximumInscribedSphereRadius`, in mm."""
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    read = reader.GetOutput()
    places = vtk_to_numpy(read.GetPoints().GetData()).astype(float)
    radii = vtk_to_numpy(read.GetPointData().GetArray("MaximumInscribedSphereRadius"))
    cells = read.GetLines()
    lines = np.split(vtk_to_numpy(cells.GetConnectivityArray()),
                     vtk_to_numpy(cells.GetOffsetsArray())[1:-1])  # fmt: skip
    starts = np.ptp(places[[one[0] for one in lines]], axis=0)
    if np.linalg.norm(starts) > 1e-3:
        lines = [one[::-1] for one in lines]
    lines.sort(key=lambda one: -len(one))
    points, radius, parent = [], [], []
    for one in lines:
        before, first = -1, 0
        if points:
            known = cKDTree(np.array(points))
            away, near = known.query(places[one])
            apart = np.flatnonzero(away > _SAME * np.array(radius)[near])
            if not len(apart):
                continue
            first = int(apart[0])
            before = int(near[max(first - 1, 0)])
        for node in one[first:].tolist():
            points.append(places[node])
            radius.append(float(radii[node]))
            parent.append(before)
            before = len(points) - 1
    return resampled(VesselTree(np.array(points), np.array(radius), np.array(parent)))


def _read_wall(path: Path, scale: float) -> Wall:
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    read = reader.GetOutput()
    points = scale * vtk_to_numpy(read.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(read.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return Wall(points, triangles, np.ones(len(triangles), dtype=int))
