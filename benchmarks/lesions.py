"""Lesions of random vessels and of a tree of hundreds of branches: found, invented, how right.

    python -m benchmarks.lesions [--quick]

The vessels are those of `tests/lesion_cases.py`, with other seeds: unbranched ones that taper and
bend with up to three lesions in series, and bifurcations with a lesion in the trunk, at an ostium,
in a branch, or none. A lesion counts as found within a quarter of its length.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from time import process_time
from typing import NamedTuple

import numpy as np

from SDFStentLib.measure import Lesion, find_lesions
from SDFStentLib.phantoms import Phantom, vascular_tree

from .common import Found, duration, markdown, run_alone
from .sweep import PROJECT

PLACES = (None, "trunk", "ostium", "branch")


class Judged(NamedTuple):
    """Of one vessel: lesions built, missed and invented, and how far degrees are off, points."""

    built: int
    missed: int
    invented: int
    errors: list[float]


def judged(known: Sequence[tuple[np.ndarray, float, float]], lesions: Sequence[Lesion]) -> Judged:
    """`known`: place, percent by diameter and length of every lesion that was built."""
    left, errors = list(lesions), []
    for place, percent, length in known:
        away = [float(np.linalg.norm(np.subtract(one.point, place))) for one in left]
        if min(away, default=np.inf) < length / 4:
            one = left.pop(int(np.argmin(away)))
            errors.append(one.percent_diameter - percent)
    return Judged(len(known), len(known) - len(errors), len(left), errors)


def vessels(quick: bool) -> Iterator[tuple[str, Judged]]:
    """Random vessels by group."""
    sys.path.insert(0, str(PROJECT / "tests"))
    from lesion_cases import bifurcation_case, tube_case

    for seed in range(100, 104 if quick else 160):
        case = tube_case(seed, (1, 2, 3, 0)[seed % 4])
        yield "unbranched", judged(case.known, find_lesions(case.surface, case.centerline))
    for seed in range(100, 100 if quick else 110):
        for where in PLACES:
            case = bifurcation_case(seed, where)
            yield "bifurcation", judged(case.known, find_lesions(case.surface, case.centerline))


def built_in(tree: Phantom, lesions: dict[int, float]) -> list[tuple[np.ndarray, float, float]]:
    """What a tree was given; its lesions are 2.4 radii long."""
    found = []
    for number, depth in lesions.items():
        axis, radius = tree.vessels[number].axis, tree.vessels[number].radius(np.zeros(1))[0]
        found.append((axis.point(axis.length / 2)[0], 100 * depth, 2.4 * float(radius)))
    return found


def trees(quick: bool) -> Iterator[tuple[str, Judged, float]]:
    """A healthy tree and one with lesions in a tenth of its branches; seconds of CPU each."""
    outlets, edge = (4, 1.0) if quick else (150, 0.5)
    random = np.random.default_rng(7)
    # The narrowest branches leave no room for a lesion between edges of this length.
    wide = np.arange(3 if quick else 63)
    chosen = random.choice(wide, len(wide) // 3, replace=False)
    lesions = {int(n): float(random.uniform(0.2, 0.45)) for n in chosen}
    for name, given in (("healthy tree", {}), ("tree", lesions)):
        made = vascular_tree(outlets, edge, given)
        start = process_time()
        found = find_lesions(made.surface, made.centerline)
        branches = len(made.centerline.branches)
        yield (
            f"{name}, {branches} branches",
            judged(built_in(made, given), found),
            (process_time() - start),
        )


def measured(quick: bool, largest: int | None) -> Found:
    groups: dict[str, list[Judged]] = {}
    seconds: dict[str, float] = {}
    for name, one in vessels(quick):
        groups.setdefault(name, []).append(one)
    for name, one, spent in trees(quick):
        groups[name], seconds[name] = [one], spent
    return {
        "rows": [
            {
                "vessels": name,
                "count": len(some),
                "built": sum(one.built for one in some),
                "missed": sum(one.missed for one in some),
                "invented": sum(one.invented for one in some),
                "largest_error_points": max(
                    (abs(e) for one in some for e in one.errors), default=0
                ),
                "seconds": seconds.get(name),
            }
            for name, some in groups.items()
        ]
    }


def table(found: Found) -> str:
    rows = [
        [
            one["vessels"],
            str(one["count"]),
            str(one["built"]),
            str(one["missed"]),
            str(one["invented"]),
            f"{one['largest_error_points']:.1f}",
            "-" if one["seconds"] is None else duration(one["seconds"]),
        ]
        for one in found["rows"]
    ]
    header = ["vessels", "count", "lesions", "missed", "invented", "largest error", "CPU"]
    return markdown(header, rows)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
