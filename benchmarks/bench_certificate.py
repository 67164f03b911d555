"""Time of the self-intersection test and the certificate on finer and finer aortas.

    python benchmarks/bench_certificate.py [--levels N] [--meshlab] [--data DIR]

The aorto-iliac model is subdivided linearly, which leaves its faces coplanar in fours: the
hardest neighbours. Beside the moved tenth of the faces the whole surface is tested once. Medians
of five runs (of one beyond a million faces).
"""

from __future__ import annotations

import argparse
import os
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

from SDFStentLib.certificate import certify, check_surface, self_intersecting_triangles
from SDFStentLib.geometry import Precision, Surface

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
MOVED_FRACTION = 0.122
"""36,000 of 297,000 faces, as a stent in this aorta moves."""


def read(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Points, mm, and triangles of the aorto-iliac model."""
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(folder / "aorta_iliac_surface_cm.vtp"))
    reader.Update()
    surface = reader.GetOutput()
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return 10.0 * vtk_to_numpy(surface.GetPoints().GetData()), triangles.astype(np.int64)


def subdivided(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every triangle cut into four at the middles of its sides."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, middle = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    first, second = np.divmod(keys, len(points))
    a, b, c, ab, bc, ca = *triangles.T, *(len(points) + middle.reshape(-1, 3)).T
    finer = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return np.vstack([points, (points[first] + points[second]) / 2]), finer


def seconds(function: Callable[[], object], repeats: int) -> float:
    """Median wall time of a call."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def meshlab_seconds(points: np.ndarray, triangles: np.ndarray) -> float:
    """Time of MeshLab's filter on the whole surface."""
    import pymeshlab

    judge = pymeshlab.MeshSet()
    judge.add_mesh(pymeshlab.Mesh(points, triangles))
    return seconds(judge.compute_selection_by_self_intersections_per_face, 1)


def row(points: np.ndarray, triangles: np.ndarray, with_meshlab: bool) -> str:
    """One line of the table."""
    single = Precision(np.float32)
    repeats = 5 if len(triangles) < 1e6 else 1
    distance = np.linalg.norm(points - points[5], axis=1)
    reach = np.sort(distance)[int(MOVED_FRACTION * len(points))]
    bump = np.clip(1 - (distance / reach) ** 2, 0, None)[:, None]
    after = points + bump * np.array([0.3, 0.2, 0.1])
    moved = np.flatnonzero(bump > 0)
    among = np.isin(triangles, moved).any(axis=1)

    def local() -> np.ndarray:
        return self_intersecting_triangles(single.stored(after), triangles, among)

    surface = Surface(points, triangles)
    check = check_surface(surface, precision=single)
    cells = [
        len(triangles),
        np.count_nonzero(among),
        len(local()),
        f"{seconds(local, repeats):.3f}",
        f"{seconds(lambda: certify(surface, after, moved, check=check), repeats):.3f}",
        f"{seconds(lambda: certify(Surface(points, triangles), after, moved), 1):.3f}",
        f"{seconds(lambda: check_surface(Surface(points, triangles), precision=single), 1):.3f}",
        f"{peak_megabytes(local):.0f}",
        f"{meshlab_seconds(after, triangles):.3f}" if with_meshlab else "-",
    ]
    return " ".join(f"{cell:>10}" for cell in cells)


def peak_megabytes(function: Callable[[], object]) -> float:
    """Most memory a call holds beyond what was there before."""
    tracemalloc.start()
    function()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--levels", type=int, default=3, help="subdivisions (4 is 4.8 million)")
    parser.add_argument("--meshlab", action="store_true", help="time MeshLab's filter as well")
    parser.add_argument("--data", type=Path, default=os.environ.get("SDFSTENT_DATA", DATA))
    arguments = parser.parse_args()
    names = "faces moved found moved/s certify/s +topology/s check/s peak/MB MeshLab/s"
    print(" ".join(f"{name:>10}" for name in names.split()))
    points, triangles = read(Path(arguments.data))
    for level in range(arguments.levels + 1):
        if level:
            points, triangles = subdivided(points, triangles)
        print(row(points, triangles, arguments.meshlab), flush=True)


if __name__ == "__main__":
    main()
