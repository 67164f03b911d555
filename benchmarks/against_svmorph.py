"""Whole deployments against svmorph 0.1.2, in one process.

python -m benchmarks.against_svmorph [--quick] [--largest SUBDIVISIONS]

Needs svmorph (extra `bench`). Its first deployment, in which it compiles, is thrown away. Then
every round runs svmorph and each of our modes once; the table has medians and ratios of them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.field import CapsuleChain
from SDFStentLib.geometry import Surface

from .common import (
    Found,
    StentCase,
    aorta_case,
    duration,
    interleaved,
    markdown,
    progress,
    pulmonary_case,
    run_alone,
)
from .svmorph_peer import SvmorphPeer

CRIMPED = 0.4

MODES = {
    "exact": DeploymentSettings.published().with_changes(certify=False),
    "default, no certificate": DeploymentSettings(certify=False, untangle=False),
    "default": DeploymentSettings(),
    "default, first": DeploymentSettings(),
    "preview": DeploymentSettings.preview(),
}
"""`exact` is the published rule, 0.1 mm Euler; `first` looks at the triangles' topology anew."""


def touching_radius(case: StentCase) -> float:
    """Radius at which the stent is just short of the wall, mm."""
    return float(CapsuleChain.along(case.axis).field(case.points).distance.min()) - 0.01


def one_of_ours(case: StentCase, name: str, start: float) -> Callable[[], Deployment]:
    settings = MODES[name].with_changes(crimped_radius=start)
    is_first = name.endswith("first")

    def run() -> Deployment:
        # Nothing is known about a new surface, neither that it is sound nor its topology.
        surface = Surface(case.points, case.triangles) if is_first else case.surface
        deployment = Deployment(
            surface, settings.chain(case.axis), case.radius, settings, companions=case.centerline
        )
        for _ in deployment:
            pass
        return deployment

    return run


def compared(case: StentCase, start: float, rounds: int) -> Found:
    """Times, ratios and the largest difference between svmorph and our exact mode."""
    exact = one_of_ours(case, "exact", start)()
    peer = SvmorphPeer(case.points, case.centerline, case.axis, start, exact.target_level)
    theirs = peer.deployed()
    apart = np.linalg.norm(exact.result.points - theirs, axis=1)
    assert case.surface.topology
    runs: dict[str, Callable[[], object]] = {"svmorph": peer.deployed}
    runs |= {name: one_of_ours(case, name, start) for name in MODES}
    runs["default"]()  # imports
    times = interleaved(runs, rounds)
    return {
        "case": case.name,
        "triangles": len(case.triangles),
        "moved_points": len(exact.result.state.indices),
        "start_radius_mm": round(start, 3),
        "rounds": rounds,
        "seconds": times,
        "ratios": {name: times["svmorph"] / times[name] for name in MODES},
        "difference_to_svmorph_mm": {
            "median": float(np.median(apart[apart > 0])),
            "max": float(apart.max()),
        },
    }


def growth_exponents(rows: list[Found]) -> Found:
    """Slope of log time over log triangles, by least squares, sizes of one series."""
    if len(rows) < 2:
        return {}
    sizes = np.log([row["triangles"] for row in rows])
    return {
        name: float(np.polyfit(sizes, np.log([row["seconds"][name] for row in rows]), 1)[0])
        for name in rows[0]["seconds"]
    }


def measured(quick: bool, largest: int | None) -> Found:
    largest = (1 if quick else 4) if largest is None else largest
    crimped, near = [], []
    for level in range(largest + 1):
        case = aorta_case(level)
        rounds = 1 if quick else (7, 5, 5, 2, 1)[min(level, 4)]
        progress(f"{len(case.triangles)} triangles, {rounds} rounds")
        crimped.append(compared(case, CRIMPED, rounds))
        near.append(compared(case, touching_radius(case), rounds))
    case = pulmonary_case()
    rounds = 1 if quick else 5
    pulmonary = [compared(case, start, rounds) for start in (CRIMPED, touching_radius(case))]
    return {
        "from_crimped": [*crimped, pulmonary[0]],
        "from_the_wall": [*near, pulmonary[1]],
        "growth_exponents": {
            "from_crimped": growth_exponents(crimped),
            "from_the_wall": growth_exponents(near),
        },
    }


def _rows(found: list[Found]) -> list[list[str]]:
    return [
        [
            f"{row['case']} {row['triangles']:,}",
            f"{row['moved_points']:,}",
            duration(row["seconds"]["svmorph"]),
            *(f"{duration(row['seconds'][name])} ({row['ratios'][name]:.1f}x)" for name in MODES),
            "{median:.0e} / {max:.2f}".format(**row["difference_to_svmorph_mm"]),
        ]
        for row in found
    ]


def table(found: Found) -> str:
    header = [
        "triangles",
        "points moved",
        "svmorph, warm",
        *MODES,
        "exact to svmorph, mm: median / max",
    ]
    exponents = [
        [start.replace("_", " "), *(f"{value:.2f}" for value in exponents.values())]
        for start, exponents in found["growth_exponents"].items()
        if exponents
    ]
    series = [
        "Growth exponents (time ~ triangles^e) of the aorto-iliac series:",
        markdown(["start", "svmorph", *MODES], exponents),
    ]
    return "\n\n".join(
        [
            f"Whole deployment from a crimped radius of {CRIMPED} mm, centerline included; in "
            "brackets how many times faster than svmorph. `default` has the certificate, the "
            "topology of the triangles being known from a deployment before; `default, first` "
            "looks at it as well.",
            markdown(header, _rows(found["from_crimped"])),
            "The same from a radius just short of the wall: no steps without contact to skip.",
            markdown(header, _rows(found["from_the_wall"])),
            *(series if exponents else []),
        ]
    )


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
