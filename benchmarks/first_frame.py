"""From a fresh Python process to the first state that can be shown, and the same once warm.

    python -m benchmarks.first_frame [--quick] [--largest SUBDIVISIONS]

The fresh time has the interpreter, all imports, reading the mesh (.npz) and the first state; the
warm one a new deployment to its first state, the stent having been moved and the topology of the
triangles being known. svmorph, where installed, does its first deformation.
"""

from __future__ import annotations

import subprocess
import sys
import time

from .common import Found, aorta_case, duration, markdown, run_alone
from .subprocesses import HAS_SVMORPH, fresh, medians, mesh_file


def interpreter_seconds(rounds: int) -> float:
    """A Python process that does nothing."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", "pass"], check=True)
        times.append(time.perf_counter() - start)
    return sorted(times)[len(times) // 2]


def measured(quick: bool, largest: int | None) -> Found:
    rounds = 1 if quick else 7
    case = aorta_case((0 if quick else 2) if largest is None else min(largest, 2))
    works = [(mode, "first-frame", mode) for mode in ("default", "preview", "published")]
    if HAS_SVMORPH and not quick:
        works.append(("svmorph", "svmorph-frame", "-"))
    interpreter = interpreter_seconds(rounds)
    rows = []
    with mesh_file(case) as mesh:
        fresh("first-frame", mesh, "preview")  # the files' first reading from the disk
        for name, work, mode in works:
            found = medians([fresh(work, mesh, mode) for _ in range(rounds)])
            parts = [found[part] for part in ("imports", "mesh", "first_state") if part in found]
            rows.append({"mode": name, "fresh": interpreter + sum(parts), **found})
    return {"triangles": len(case.triangles), "rounds": rounds, "rows": rows}


def table(found: Found) -> str:
    rows = [
        [
            row["mode"],
            duration(row["fresh"]),
            duration(row["imports"]),
            duration(row["first_state"]),
            duration(row["warm"]),
        ]
        for row in found["rows"]
    ]
    header = ["mode", "fresh process to first state", "imports", "first state", "warm"]
    caption = f"{found['triangles']:,} triangles; the first state imports `scipy.spatial`:"
    return f"{caption}\n\n{markdown(header, rows)}"


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
