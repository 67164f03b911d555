"""Verdicts on a surface from programs that others wrote: MeshLab and TetGen."""

from __future__ import annotations

import numpy as np


class JudgeError(RuntimeError):
    """What TetGen has to complain."""


def meshlab_faces(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Self-intersecting faces as MeshLab finds them."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points, triangles.astype(np.int32)))
    meshes.compute_selection_by_self_intersections_per_face()
    return np.flatnonzero(meshes.current_mesh().face_selection_array())


def tetrahedra(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tetrahedra (t, 4) inside, the surface kept as for CFD; `JudgeError` where that fails."""
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
