"""How far a radius-step rule is from the converged limit: the published rule with tiny steps.

    python -m benchmarks.step_rules [--quick]

Everything but the rule is as published (level of the paper, no finish, no tissue gap), and points
within 0.05 mm of the stent are left out: whatever the rule, they are put on the stent. So are those
that a cap might drag: by the published rule it does, by events it does not. What remains is the
transition zone. The reference has steps of 0.0125 mm.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from SDFStentLib import phantoms
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.geometry import nearest_distances
from SDFStentLib.measure import open_at_ends
from SDFStentLib.phantoms import Phantom

from .common import (
    Case,
    Found,
    aorta_case,
    markdown,
    progress,
    pulmonary_case,
    run_alone,
    vmtk_aorta_case,
)

# In the same field, so that only the steps differ.
PUBLISHED = DeploymentSettings.published().with_changes(certify=False, fold="both")
EVENTS = PUBLISHED.with_changes(rule="events")

RULES = {
    "published 0.1": PUBLISHED,
    "events 0.4": EVENTS.with_changes(step=0.4),
    "events 0.8 (default)": EVENTS,
    "events 1.6": EVENTS.with_changes(step=1.6),
    "events 1.6, tolerance 0.1 (preview)": EVENTS.with_changes(step=1.6, step_tolerance=0.1),
}

REFERENCE_STEP = 0.0125
CONTACT_ZONE = 0.05
"""Points nearer to the stent than this are in contact, mm."""


def _in_phantom(phantom: Phantom, start: float, length: float, radius: float) -> Case:
    axis = phantom.axis_at(np.linspace(start, start + length, 200))
    return Case(phantom.name, phantom.surface, axis, radius, phantom.centerline.points)


def phantom_cases(edge_length: float = 0.8) -> Iterator[Case]:
    """16 to 20 mm long stents that widen the lumen by 2 to 3 mm."""
    yield _in_phantom(phantoms.straight_tube(2.0, 40, edge_length), 12, 16, 3.5)
    yield _in_phantom(phantoms.bent_tube(2.0, 15, 90, edge_length), 12, 18, 3.5)
    yield _in_phantom(phantoms.helix_tube(2.0, edge_length=edge_length), 15, 20, 3.5)
    yield _in_phantom(phantoms.stenosed_tube(2.5, 1.5, 40, edge_length), 12, 16, 3.5)
    yield _in_phantom(phantoms.branching_pulmonary_artery(), 14, 20, 5.0)


def anatomy_cases() -> Iterator[Case]:
    yield aorta_case()
    yield pulmonary_case()
    yield vmtk_aorta_case()


def run(case: Case, settings: DeploymentSettings) -> tuple[Deployment, float]:
    """The deployment after its end, and its time, s."""
    deployment = Deployment(case.surface, settings.chain(case.axis), case.radius, settings)
    start = time.perf_counter()
    for _ in deployment:
        pass
    return deployment, time.perf_counter() - start


def _beside_caps(case: Case) -> NDArray[np.bool_]:
    """Points (n,) that a cap may drag, which it does by the published rule only."""
    caps = open_at_ends(case.surface, case.axis).caps
    corners = case.surface.points[np.unique(case.surface.triangles[caps])]
    reach = PUBLISHED.influence_distance
    if not len(corners):
        return np.zeros(len(case.surface.points), dtype=bool)
    return np.asarray(nearest_distances(case.surface.points, corners) <= reach)


def compared(case: Case, reference_step: float = REFERENCE_STEP) -> list[Found]:
    """A row per rule."""
    limit, _ = run(case, PUBLISHED.with_changes(step=reference_step))
    limit_points = limit.result.points
    free = limit.chain.field(limit_points).distance - limit.target_level > CONTACT_ZONE
    free &= ~_beside_caps(case)
    rows = []
    for name, settings in RULES.items():
        deployment, seconds = run(case, settings)
        error = np.linalg.norm(deployment.result.points - limit_points, axis=1)[free]
        moved = error[error > 0]
        rows.append(
            {
                "case": case.name,
                "rule": name,
                "max_mm": float(moved.max()),
                "percentile_99_mm": float(np.percentile(moved, 99)),
                "mean_mm": float(moved.mean()),
                "stated_mm": deployment.result.estimated_error or None,
                "steps": len(deployment.states) - 1,
                "seconds": seconds,
            }
        )
    return rows


def measured(quick: bool, largest: int | None = None) -> Found:
    if quick:
        cases: list[Case] = [next(phantom_cases(1.2))]
    else:
        cases = [*phantom_cases(), *anatomy_cases()]
    rows = []
    for case in cases:
        progress(case.name)
        rows += compared(case, 0.025 if quick else REFERENCE_STEP)
    return {"reference_step_mm": 0.025 if quick else REFERENCE_STEP, "rows": rows}


def table(found: Found) -> str:
    header = ["distance to the converged limit, mm: max / 99 % / mean (stated)", *RULES]
    lines: dict[str, list[str]] = {}
    for row in found["rows"]:
        stated = f" ({row['stated_mm']:.3f})" if row["stated_mm"] else ""
        text = f"{row['max_mm']:.3f} / {row['percentile_99_mm']:.3f} / {row['mean_mm']:.4f}{stated}"
        lines.setdefault(row["case"], []).append(text)
    return markdown(header, [[name, *cells] for name, cells in lines.items()])


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
