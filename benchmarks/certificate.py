"""Time of the certificate, on real deployments and on the bumps of `bench_certificate.py`.

    python -m benchmarks.certificate [--quick] [--largest SUBDIVISIONS]

`certificate` is what every deployment runs at its end, `first` when the topology of the triangles
has to be looked at as well. MeshLab's filter, where installed, tests the whole surface.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from SDFStentLib.certificate import certify, check_surface
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.geometry import Precision, Surface

from .bench_certificate import meshlab_seconds, row, seconds
from .common import Found, aorta_case, duration, markdown, progress, run_alone

BUMP_COLUMNS = (
    "triangles", "moved", "found", "moved_s", "certify_s", "first_s", "check_s", "peak_mb",
    "meshlab_s",
)  # fmt: skip
UNCERTIFIED = DeploymentSettings(certify=False, untangle=False)


def of_deployment(level: int) -> Found:
    """The certificate of a 36 mm x 24 mm stent in the subdivided aorta."""
    case = aorta_case(level)
    progress(f"{len(case.triangles)} triangles")
    chain = UNCERTIFIED.chain(case.axis)
    deployment = Deployment(case.surface, chain, case.radius, UNCERTIFIED)
    state, after = deployment.result.state, deployment.result.surface
    before, triangles = case.surface, deployment.outward_triangles
    assert before.topology.is_consistently_wound
    repeats = 5 if len(triangles) < 1e6 else 2

    def certified() -> object:
        return certify(before, after, state.indices)

    def first() -> object:
        return certify(Surface(before.points, triangles), after.points, state.indices)

    def whole() -> object:
        return check_surface(after, precision=Precision(np.float32))

    found = {
        "triangles": len(triangles),
        "moved_points": len(state.indices),
        "certificate_s": seconds(certified, repeats),
        "certificate_first_s": seconds(first, repeats),
        "check_surface_s": seconds(whole, 1),
    }
    if importlib.util.find_spec("pymeshlab") and len(triangles) < 2e6:
        found["meshlab_s"] = meshlab_seconds(after.points, triangles)
    return found


def of_bump(level: int) -> Found:
    """The row of `bench_certificate.py`: an eighth of the surface moved."""
    case = aorta_case(level)
    cells = row(case.points, case.triangles, False).split()
    return {
        name: float(cell) for name, cell in zip(BUMP_COLUMNS, cells, strict=True) if cell != "-"
    }


def measured(quick: bool, largest: int | None) -> Found:
    top = (0 if quick else 4) if largest is None else largest
    levels = sorted({min(2, top), top})
    return {
        "deployments": [of_deployment(level) for level in levels],
        "bumps": [of_bump(level) for level in levels],
    }


def table(found: Found) -> str:
    header = ["triangles", "points moved", "certificate", "first", "whole surface", "MeshLab"]
    rows = [
        [
            f"{one['triangles']:,}",
            f"{one['moved_points']:,}",
            duration(one["certificate_s"]),
            duration(one["certificate_first_s"]),
            duration(one["check_surface_s"]),
            duration(one["meshlab_s"]) if "meshlab_s" in one else "-",
        ]
        for one in found["deployments"]
    ]
    return markdown(header, rows)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
