"""Start fresh processes with a mesh, for the benchmarks of latency and memory."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from SDFStentLib.field import CapsuleChain

from .common import Case, Found
from .sweep import PROJECT

HAS_SVMORPH = importlib.util.find_spec("svmorph") is not None


@contextmanager
def mesh_file(case: Case) -> Iterator[Path]:
    """The case as a file that NumPy reads without vtk."""
    touching = CapsuleChain.along(case.axis).field(case.points).distance.min()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.npz"
        np.savez(
            path,
            points=case.points,
            triangles=case.triangles,
            axis=case.axis,
            radius=case.radius,
            touching_radius=touching,
        )
        yield path


def fresh(work: str, mesh: Path, mode: str) -> Found:
    """What `fresh_process.py` measured, and the time of the whole process, s."""
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.fresh_process", work, str(mesh), mode],
        cwd=PROJECT,
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    return {"process": time.perf_counter() - start, **json.loads(done.stdout.splitlines()[-1])}


def medians(found: list[Found]) -> Found:
    """Median of every number over repeated runs."""
    return {name: float(np.median([one[name] for one in found])) for name in found[0]}
