"""Tetrahedra in a closed surface: filled by TetGen, sized and improved by MMG.

TetGen (AGPL) is a wheel of the user's own installation, used in a process of its own. It keeps the
surface and adds only the points that it needs; those between have the sizes that they shall have
by MMG, which keeps the surface, too. Neither makes layers along the wall.
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from ..files import VolumeMesh
from ..geometry import edges, norm
from ..interpreter import interpreter
from ..validation import DeploymentError, Floats, Indices, InputError, Points
from .mmg import INSTALL, MeditMesh, by_mmg, run_mesher
from .remesh import GRADING, Remeshed

SWITCHES = "pq1.4YQ"
"""Switches of TetGen: fill a surface, no flat tetrahedra, the surface as it is."""

_FILL = """
import sys, numpy, tetgen
given = numpy.load(sys.argv[1])
mesher = tetgen.TetGen(given["points"], given["triangles"])
points, tetrahedra = mesher.tetrahedralize(switches=sys.argv[3])[:2]
numpy.savez(sys.argv[2], points=points, tetrahedra=tetrahedra)
"""

_SIDES = [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)]


class Quality(NamedTuple):
    """The quality of a volume mesh."""

    points: int
    tetrahedra: int
    smallest_angle: float
    """Smallest angle between two sides of a tetrahedron, degrees."""
    largest_angle: float


def check_meshers() -> None:
    """`InputError` that says how to install TetGen, where it is missing."""
    if find_spec("tetgen") is None:
        raise InputError(f"expected TetGen to mesh a vessel, it is not installed; {INSTALL}.")


def filled(made: Remeshed) -> VolumeMesh:
    """Tetrahedra in a surface whose points come first, as long as its edges nearby.

    Raises
    ------
    InputError
        TetGen or MMG is not installed.
    DeploymentError
        One of them fails, or does not keep the surface.
    """
    check_meshers()
    surface = made.surface
    points, tetrahedra = _by_tetgen(surface.points, surface.triangles)
    mesh = MeditMesh(points, surface.triangles, made.face_ids, tetrahedra)
    options = ["-nosurf", "-hgrad", f"{GRADING}"]
    found = by_mmg("mmg3d", mesh, _sizes(points, made), options)
    return _with_surface_first(found, surface.points)


def quality(volume: VolumeMesh) -> Quality:
    """Numbers of points and tetrahedra, and their extreme angles."""
    angles = dihedral_angles(volume.points, volume.tetrahedra)
    return Quality(
        len(volume.points), len(volume.tetrahedra), float(angles.min()), float(angles.max())
    )


def dihedral_angles(points: Points, tetrahedra: Indices) -> Floats:
    """Angles (t, 6) between the sides of tetrahedra, degrees."""
    corners = points[tetrahedra]
    found = []
    for a, b, c, d in _SIDES:
        axis = corners[:, b] - corners[:, a]
        one, other = (np.cross(axis, corners[:, k] - corners[:, a]) for k in (c, d))
        cosine = (one * other).sum(axis=1) / (norm(one) * norm(other))
        found.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.stack(found, axis=1)


def _by_tetgen(points: Points, triangles: Indices) -> tuple[Points, Indices]:
    with TemporaryDirectory(prefix="sdfstent-mesh-") as folder:
        question, answer = Path(folder) / "surface.npz", Path(folder) / "volume.npz"
        np.savez(question, points=points, triangles=triangles.astype(np.int32))
        command = [interpreter(), "-c", _FILL, str(question), str(answer), SWITCHES]
        run_mesher("TetGen", command, answer)
        with np.load(answer) as data:
            return data["points"].astype(np.float64), data["tetrahedra"].astype(np.int64)


def _sizes(points: Points, made: Remeshed) -> Floats:
    """Sizes of edges at points (n, 3): the mean at the nearest point of the surface, mm."""
    from scipy.spatial import cKDTree

    wall = made.surface.points
    ends = edges(made.surface.triangles).vertices
    lengths = norm(wall[ends[:, 0]] - wall[ends[:, 1]])
    count = np.bincount(ends.ravel(), minlength=len(wall))
    mean = np.bincount(ends.ravel(), np.repeat(lengths, 2), len(wall)) / count
    return np.asarray(mean[cKDTree(wall).query(points)[1]])


def _with_surface_first(found: MeditMesh, wall: Points) -> VolumeMesh:
    """The points of the surface in their order, and to the bit."""
    from scipy.spatial import cKDTree

    away, place = cKDTree(found.points).query(wall)
    if away.max() > 1e-6 or len(np.unique(place)) < len(wall):
        raise DeploymentError(
            "MMG: expected tetrahedra that keep the surface, got others; install a newer one: "
            f"{INSTALL}."
        )
    inner = np.setdiff1d(np.arange(len(found.points)), place)
    number = np.empty(len(found.points), np.int64)
    number[np.r_[place, inner]] = np.arange(len(number))
    return VolumeMesh(np.vstack([wall, found.points[inner]]), number[found.tetrahedra])
