"""Where the time of a default deployment goes.

    python -m benchmarks.where_time_goes [--quick] [--largest SUBDIVISIONS]

Python's own profiler; it adds little, because nearly all time passes inside NumPy and SciPy.
The stages add up to the whole; the kinds of work cut across them.
"""

from __future__ import annotations

import cProfile
import pstats
from typing import Any
from unittest.mock import patch

import scipy.spatial

from SDFStentLib.deformation import Deployment
from SDFStentLib.field import CapsuleChain

from .common import Found, aorta_case, duration, markdown, run_alone

STAGES = {
    "find the active points, first field": "_active",
    "patch and topology of it": "around",
    "tissue gap": "_keep_tissue",
    "radius steps": "event_steps",
    "states for the caller": "state",
    "finish and facet compensation": "finish",
    "certificate of the surface": "_certificate",
    "certificate of the lumen": "lumen_checks",
}
KINDS = {
    "distance field": "folded",
    "true distance to the axis": "axis_distance",
    "nearest-contact queries": "query",
    "search trees": "_tree",
    "search for intersections": "intersecting_pairs",
}


class VisibleTree(scipy.spatial.cKDTree):
    """SciPy's tree with queries that the profiler can see."""

    def query(self, *arguments: Any, **options: Any) -> Any:
        return super().query(*arguments, **options)


def cumulative(stats: pstats.Stats, name: str) -> tuple[float, int]:
    """Time with everything called from there, s, and calls, of the functions of a name."""
    entries = [
        (entry[3], entry[1])
        for (_, _, function), entry in stats.stats.items()  # type: ignore[attr-defined]
        if function == name
    ]
    return sum(time for time, _ in entries), sum(calls for _, calls in entries)


def measured(quick: bool, largest: int | None) -> Found:
    levels = [0] if quick else [level for level in (0, 2) if largest is None or level <= largest]
    rows = []
    for level in levels:
        case = aorta_case(level)
        assert case.surface.topology  # looked at before the clock runs

        def run(case=case) -> None:
            deployment = Deployment(
                case.surface,
                CapsuleChain.along(case.axis),
                case.radius,
                companions=case.centerline,
            )
            for _ in deployment:
                pass

        run()
        profile = cProfile.Profile()
        with patch("scipy.spatial.cKDTree", VisibleTree):
            profile.runcall(run)
        stats = pstats.Stats(profile)
        whole = stats.total_tt  # type: ignore[attr-defined]
        for group, names in (("stage", STAGES), ("kind", KINDS)):
            for label, name in names.items():
                seconds, calls = cumulative(stats, name)
                rows.append(_row(len(case.triangles), group, label, seconds, whole, calls))
        staged = sum(row["seconds"] for row in rows if _is_stage(row, len(case.triangles)))
        rows.append(_row(len(case.triangles), "stage", "the rest", whole - staged, whole, 0))
    return {"rows": rows}


def _row(triangles: int, group: str, label: str, seconds: float, whole: float, calls: int) -> Found:
    return {
        "triangles": triangles,
        "group": group,
        "part": label,
        "seconds": seconds,
        "share": seconds / whole,
        "calls": calls,
    }


def _is_stage(row: Found, triangles: int) -> bool:
    return row["group"] == "stage" and row["triangles"] == triangles


def table(found: Found) -> str:
    sizes = sorted({row["triangles"] for row in found["rows"]})
    lines: dict[tuple[str, str], list[str]] = {}
    for row in sorted(found["rows"], key=lambda row: (row["group"] == "kind", row["triangles"])):
        cells = lines.setdefault((row["group"], row["part"]), [])
        cells.append(f"{duration(row['seconds'])} ({100 * row['share']:.0f} %)")
    rows = [[f"{group}: {part}", *cells] for (group, part), cells in lines.items()]
    return markdown(["part", *(f"{size:,} triangles" for size in sizes)], rows)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
