"""Peak memory of a deployment above NumPy, scipy.spatial and the mesh itself.

    python -m benchmarks.memory [--quick] [--largest SUBDIVISIONS]

Each number from a fresh process; all states are kept, as the slider needs.
svmorph, where installed, starts from the wall; what it holds includes JAX.
"""

from __future__ import annotations

from .common import Found, aorta_case, markdown, run_alone
from .subprocesses import HAS_SVMORPH, fresh, medians, mesh_file


def measured(quick: bool, largest: int | None) -> Found:
    levels = [0] if quick else [2] if largest is None or largest < 3 else [2, 3]
    works = [(mode, "memory", mode) for mode in ("default", "preview", "published")]
    if HAS_SVMORPH and not quick:
        works.append(("svmorph", "svmorph-memory", "-"))
    rows = []
    for level in levels:
        case = aorta_case(level)
        with mesh_file(case) as mesh:
            for name, work, mode in works:
                found = medians([fresh(work, mesh, mode) for _ in range(1 if quick else 3)])
                rows.append({"triangles": len(case.triangles), "mode": name, **found})
    return {"rows": rows}


def table(found: Found) -> str:
    rows = [
        [
            f"{row['mode']} {row['triangles']:,}",
            f"{row['peak']:.0f}",
            f"{row['base']:.0f}",
            f"{row['above_base']:.0f}",
        ]
        for row in found["rows"]
    ]
    header = ["memory, MB", "peak of the process", "NumPy, scipy.spatial and mesh", "above that"]
    return markdown(header, rows)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
