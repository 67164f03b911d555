"""Common parts of the benchmarks: vessels, stents, timing, tables, description of the machine."""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from SDFStentLib.geometry import Surface

from .sweep import DATA_FOLDER, leaves_by_place, vessel

AORTA_TRIANGLES = 18_584
"""Number of triangles of the aorto-iliac model; each linear subdivision has four times as many."""

Found = dict[str, Any]


class StentCase(NamedTuple):
    """A stent in a vessel; the centerline is dragged along."""

    name: str
    surface: Surface
    axis: np.ndarray
    radius: float
    centerline: np.ndarray

    @property
    def points(self) -> np.ndarray:
        return self.surface.points

    @property
    def triangles(self) -> np.ndarray:
        return self.surface.triangles


def anatomy_case(name: str, start: float, length: float, radius: float) -> StentCase:
    """A stent over a range of arc length, mm, of the path to an anatomy's first leaf."""
    made = vessel(name)
    line = made.centerline
    path = line.path(line.points[line.roots[0]], line.points[leaves_by_place(line)[0]])
    return StentCase(
        name, made.surface, path.line.cut(start, start + length).points, radius, path.points
    )


@cache
def aorta_case(subdivisions: int = 0) -> StentCase:
    """36 mm x 24 mm in the aorto-iliac model, across its bifurcation at 212 mm."""
    if subdivisions:
        case = aorta_case(subdivisions - 1)
        return case._replace(surface=Surface(*subdivided(case.points, case.triangles)))
    return anatomy_case("aorta_iliac", 200.0, 36.0, 12.0)


def pulmonary_case() -> StentCase:
    """25 mm x 22 mm across the bifurcation of the pulmonary artery (at 16 mm), 1.2 x the lumen."""
    return anatomy_case("pulmonary", 8.0, 25.0, 11.0)


def subdivided(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every triangle cut into four at the middles of its sides."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, middle = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    first, second = np.divmod(keys, len(points))
    a, b, c, ab, bc, ca = *triangles.T, *(len(points) + middle.reshape(-1, 3)).T
    finer = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return np.vstack([points, (points[first] + points[second]) / 2]), finer


def seconds_of(function: Callable[[], object]) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def interleaved(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median time, s, of every run; one after the other in every round, so that load hits all."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            times[name].append(seconds_of(run))
    return {name: float(np.median(values)) for name, values in times.items()}


def markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table; numbers to the right, the first column to the left."""
    lines = [header, ["---", *["---:"] * (len(header) - 1)], *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def duration(seconds: float) -> str:
    """A time with three figures, in ms below a second."""
    if seconds >= 0.9995:
        return f"{seconds:.3g} s"
    return f"{1e3 * seconds:.3g} ms"


def machine() -> Found:
    """The machine that a result comes from."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "memory_gb": _memory_gb(),
        "os": platform.platform(),
        "thread_settings": {
            name: os.environ[name]
            for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "XLA_FLAGS")
            if name in os.environ
        },
        "versions": {"python": platform.python_version(), **_versions()},
    }


def load_average() -> float | None:
    """Number of processes that wanted a core during the last minute, if the system reports it."""
    return round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None


def _versions() -> dict[str, str]:
    found = {}
    for name in ("sdfstent", "numpy", "scipy", "vtk", "svmorph", "jax", "jaxlib", "pymeshlab"):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def _memory_gb() -> float | None:
    try:
        return round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1)
    except (AttributeError, ValueError, OSError):
        return None


def options(description: str, arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """The options that every benchmark understands."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="small sizes, one run each")
    parser.add_argument(
        "--largest", type=int, metavar="SUBDIVISIONS",
        help="of the aorto-iliac model, for scripts that use them (4: 4.76 million triangles)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers here")
    return parser.parse_args(arguments)


def run_alone(
    description: str, measured: Callable[[bool, int | None], Found], table: Callable[[Found], str]
) -> None:
    """Main function of a benchmark: measure, print the tables, write the numbers."""
    chosen = options(description)
    if not DATA_FOLDER.is_dir():
        sys.exit(f"real anatomies not found in {DATA_FOLDER}; set SDFSTENT_DATA to their folder")
    before = load_average()
    found = measured(chosen.quick, chosen.largest)
    found["load_average"] = [before, load_average()]
    print(table(found))
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def progress(text: str) -> None:
    """Print what is going on, apart from the tables."""
    print(text, file=sys.stderr, flush=True)
