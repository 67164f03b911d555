"""What a fresh process does for the benchmarks of latency and memory; prints one line of JSON.

python -m benchmarks.fresh_process first-frame|memory|svmorph-frame|svmorph-memory MESH.npz MODE
"""

from __future__ import annotations

import sys
import time

BEGAN = time.perf_counter()

import json  # noqa: E402
import resource  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

from .peak import peak_mb  # noqa: E402


def first_frame(mesh: str, mode: str) -> dict[str, float]:
    """Times, s, from the start of this script to the first state, and of later ones."""
    arrays = np.load(mesh)
    from SDFStentLib import Deployment, Surface

    imported = time.perf_counter()
    settings = _settings(mode)
    points, triangles, axis = (arrays[name] for name in ("points", "triangles", "axis"))
    radius = float(arrays["radius"])
    loaded = time.perf_counter()
    surface = Surface(points, triangles)
    deployment = Deployment(surface, settings.chain(axis), radius, settings)
    next(iter(deployment))
    first = time.perf_counter()
    warm = []
    assert surface.topology  # known from here on
    for shift in (0.5, -0.5, 0.3, -0.3, 0.1):
        start = time.perf_counter()
        moved = axis + np.array([shift, 0, 0])
        next(iter(Deployment(surface, settings.chain(moved), radius, settings)))
        warm.append(time.perf_counter() - start)
    return {
        "imports": imported - BEGAN,
        "mesh": loaded - imported,
        "first_state": first - loaded,
        "warm": float(np.median(warm)),
    }


def svmorph_frame(mesh: str, mode: str) -> dict[str, float]:
    """The same of svmorph: its first deformation."""
    arrays = np.load(mesh)
    points, axis = arrays["points"], arrays["axis"]
    start = time.perf_counter()
    from benchmarks.svmorph_peer import SvmorphPeer

    touching = float(arrays["touching_radius"])
    peer = SvmorphPeer(points, axis, axis, touching, touching + 0.1)
    imported = time.perf_counter()
    peer.deployed()
    first = time.perf_counter()
    peer.deployed()
    warm = time.perf_counter() - first
    SvmorphPeer(points, axis, axis[: len(axis) // 2], touching, touching + 0.1).deployed()
    other = time.perf_counter() - first - warm
    return {
        "imports": imported - start,
        "first_state": first - imported,
        "warm": warm,
        "warm_other_stent": other,
    }


def memory(mesh: str, mode: str) -> dict[str, float]:
    """Peak resident memory, MB, above NumPy, scipy.spatial and the mesh."""
    import scipy.spatial  # noqa: F401

    arrays = np.load(mesh)
    points, triangles, axis = (arrays[name] for name in ("points", "triangles", "axis"))
    base, peak_before = _resident_mb(), peak_mb()
    from SDFStentLib import Deployment, Surface

    library = _resident_mb() - base
    settings = _settings(mode)
    surface = Surface(points, triangles)
    deployment = Deployment(surface, settings.chain(axis), float(arrays["radius"]), settings)
    for _ in deployment:
        pass
    peak = peak_mb()
    return {
        "base": base,
        "base_peak": peak_before,
        "library_import": library,
        "peak": peak,
        "above_base": peak - base,
    }


def svmorph_memory(mesh: str, mode: str) -> dict[str, float]:
    """The same of svmorph; JAX counts as its import."""
    import scipy.spatial  # noqa: F401

    from benchmarks.svmorph_peer import SvmorphPeer

    arrays = np.load(mesh)
    points, _, axis = (arrays[name] for name in ("points", "triangles", "axis"))
    base = _resident_mb()
    start, end = float(arrays["touching_radius"]), float(arrays["radius"])
    SvmorphPeer(points, axis, axis, start, end).deployed()
    return {"base": base, "peak": peak_mb(), "above_base": peak_mb() - base}


def _settings(mode: str) -> Any:
    from SDFStentLib import DeploymentSettings

    return DeploymentSettings() if mode == "default" else getattr(DeploymentSettings, mode)()


def _resident_mb() -> float:
    """Resident now; where the system does not tell, the peak so far."""
    try:
        with open("/proc/self/statm", encoding="utf-8") as status:
            return int(status.read().split()[1]) * resource.getpagesize() / 1e6
    except OSError:
        return peak_mb()


WORK = {
    "first-frame": first_frame,
    "memory": memory,
    "svmorph-frame": svmorph_frame,
    "svmorph-memory": svmorph_memory,
}

if __name__ == "__main__":
    print(json.dumps(WORK[sys.argv[1]](*sys.argv[2:])))
