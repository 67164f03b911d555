"""The seeded sweep of `sweep.py` in a length that fits among the benchmarks.

    python -m benchmarks.random_stents [--quick]

MeshLab judges every surface, TetGen those of the last series. For long sweeps run `sweep.py`.
"""

from __future__ import annotations

import importlib.util
from typing import NamedTuple

from . import sweep
from .common import Found, progress, run_alone


class Series(NamedTuple):
    ratios: tuple[float, float]
    """Stent radius over the widest local lumen."""
    count: int
    seed: int
    with_tetgen: bool


SERIES = {
    "1.05 to 1.6 x the widest local lumen": Series((1.05, 1.6), 60, 1, False),
    "1.6 to 2.6 x": Series((1.6, 2.6), 24, 5, False),
    "1.05 to 1.6 x, meshed by TetGen": Series((1.05, 1.6), 9, 2, True),
}


def measured(quick: bool, largest: int | None = None) -> Found:
    has_tetgen = importlib.util.find_spec("tetgen") is not None
    found: Found = {}
    for name, series in SERIES.items():
        if series.with_tetgen and (quick or not has_tetgen):
            continue
        progress(name)
        rows = list(
            sweep.rows(
                3 if quick else series.count,
                series.seed,
                series.ratios,
                with_tetgen=series.with_tetgen,
            )
        )
        found[name] = {
            **series._asdict(),
            "failed": [row._asdict() for row in rows if row.failed],
            "summary": sweep.summary(rows),
        }
    return {"series": found}


def table(found: Found) -> str:
    return "\n\n".join(
        f"{name}:\n\n```\n{series['summary']}\n```" for name, series in found["series"].items()
    )


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
