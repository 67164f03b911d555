"""How long measuring takes beside deploying.

    python -m benchmarks.measuring [--quick]

A deployment, the two profiles of it, before and after, and all that is measured of a stent (its
surroundings, ostia, neighbors and contact too). In turn in one process, so that the ratio holds on
a machine that does other work as well.
"""

from __future__ import annotations

from functools import partial

from SDFStentLib.deformation import DeploymentSettings, deploy
from SDFStentLib.measure import diameter_profile
from SDFStentLib.stent import AlongAxis, Stent
from SDFStentLib.treatment import Treatment

from .common import (
    Case,
    Found,
    aorta_case,
    duration,
    interleaved,
    markdown,
    pulmonary_case,
    run_alone,
    vmtk_aorta_case,
)
from .sweep import vessel


def row(case: Case, rounds: int) -> Found:
    settings = DeploymentSettings(certify=False)
    expand = partial(deploy, case.surface, settings.chain(case.axis), case.radius, settings)
    after = expand().surface

    def measure() -> None:
        for surface in (case.surface, after):
            diameter_profile(surface, case.axis)

    seconds = interleaved({"deploy": expand, "measure": measure}, rounds)
    tree = vessel(case.name.split()[0]).centerline
    stent = Stent(2 * case.radius, placement=AlongAxis(case.axis))
    treatments = (Treatment(case.surface, [stent], tree, settings) for _ in range(rounds))
    seconds["answer"] = min(one.result.timings["measure"] for one in treatments)
    return {"vessel": case.name, "triangles": len(case.triangles), **seconds}


def measured(quick: bool, largest: int | None) -> Found:
    cases = [pulmonary_case(), aorta_case(), vmtk_aorta_case()]
    if not quick:
        cases += [aorta_case(level) for level in (1, 2) if largest is None or level <= largest]
    return {"rows": [row(case, 1 if quick else 7) for case in cases]}


def table(found: Found) -> str:
    rows = [
        [
            one["vessel"],
            f"{one['triangles']:,}",
            duration(one["deploy"]),
            duration(one["measure"]),
            duration(one["answer"]),
            f"{one['answer'] / one['deploy']:.2f}",
        ]
        for one in found["rows"]
    ]
    return markdown(
        ["vessel", "triangles", "deploy", "two profiles", "all of a stent", "ratio"], rows
    )


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
