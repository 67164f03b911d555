"""Verdicts on a surface by programs of others: MeshLab, TetGen and VTK's distances."""

from __future__ import annotations

from typing import Any

import numpy as np


class JudgeError(RuntimeError):
    """An error or a changed surface of TetGen."""


def meshlab_faces(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Self-intersecting faces that MeshLab finds."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points, triangles.astype(np.int32)))
    meshes.compute_selection_by_self_intersections_per_face()
    return np.flatnonzero(meshes.current_mesh().face_selection_array())


def tetrahedra(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tetrahedra (t, 4) inside, with the surface kept as for CFD; `JudgeError` if that fails."""
    import tetgen

    try:
        mesher = tetgen.TetGen(points, triangles.astype(np.int32))
        nodes, elements = mesher.tetrahedralize(switches="pq1.4YQ")[:2]
    except RuntimeError as error:
        raise JudgeError(str(error).splitlines()[0][:60]) from error
    if not (len(nodes) >= len(points) and np.array_equal(nodes[: len(points)], points)):
        raise JudgeError("surface changed")
    if not len(elements):
        raise JudgeError("no tetrahedra")
    return np.asarray(elements)


def _locator(points: np.ndarray, triangles: np.ndarray) -> Any:
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    data, coordinates, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    coordinates.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    corners = np.ascontiguousarray(triangles.ravel(), dtype=np.int64)
    cells.SetData(3, numpy_to_vtkIdTypeArray(corners, deep=True))
    data.SetPoints(coordinates)
    data.SetPolys(cells)
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(data)
    locator.BuildLocator()
    return locator


def _distance(locator: Any, place: np.ndarray) -> float:
    import vtk

    closest, cell = [0.0, 0.0, 0.0], vtk.reference(0)
    part, squared = vtk.reference(0), vtk.reference(0.0)
    locator.FindClosestPoint(place, closest, cell, part, squared)
    return float(squared) ** 0.5


def wall_distances(points: np.ndarray, triangles: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """Distance (n,) from stations to the surface, mm."""
    locator = _locator(points, triangles)
    return np.array([_distance(locator, station) for station in stations])


def widest_spheres(points: np.ndarray, triangles: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """Radius (n,) of the largest empty sphere in the plane across a polyline, by pattern search."""
    locator = _locator(points, triangles)
    along = np.gradient(stations, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    radii = []
    for station, direction in zip(stations, along, strict=True):
        _, _, rows = np.linalg.svd(direction[None])
        center, radius = station, _distance(locator, station)
        step = radius / 4
        for _ in range(200):
            if step < 1e-3:
                break
            angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
            around = center + step * (
                np.cos(angles)[:, None] * rows[1] + np.sin(angles)[:, None] * rows[2]
            )
            widths = [_distance(locator, place) for place in around]
            best = int(np.argmax(widths))
            if widths[best] > radius:
                center, radius = around[best], widths[best]
            else:
                step /= 2
        radii.append(radius)
    return np.array(radii)
