"""The lumen that 6.0 mm stents leave in finely meshed phantoms.

python -m benchmarks.lumen [--quick]

Inscribed diameter (largest sphere that fits, free to move in the cross-section) at every
millimeter of the stent, both ends included.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.geometry import Surface
from SDFStentLib.lumen import inscribed_spheres

from . import phantoms
from .common import Found, aorta_case, markdown, progress, run_alone
from .phantoms import Phantom

DIAMETER = 6.0

MODES = {
    "default": DeploymentSettings(certify=False, untangle=False),
    "without facet compensation": DeploymentSettings(
        facet_compensation=False, certify=False, untangle=False
    ),
    "as published (k/4)": DeploymentSettings.published().with_changes(certify=False),
}


def fine_phantoms(edge_length: float) -> Iterator[tuple[str, Phantom, float]]:
    """Name, vessel, and beginning of the stent, mm."""
    made = phantoms.stenosed_tube(2.0, 1.2, 40, edge_length=edge_length)
    yield "straight, stenosed", made, 12.0
    yield "bend of radius 30", phantoms.bent_tube(2.0, 30, 60, edge_length=edge_length), 12.0
    yield "bend of radius 12", phantoms.bent_tube(2.0, 12, 120, edge_length=edge_length), 12.0
    yield "helix", phantoms.helix_tube(2.0, turns=0.8, edge_length=edge_length), 10.0


def diameters(
    surface: Surface, axis: np.ndarray, radius: float, settings: DeploymentSettings
) -> Found:
    """Diameters of the lumen after a deployment, mm."""
    deployment = Deployment(surface, settings.chain(axis), radius, settings)
    after = deployment.result.points
    inscribed = 2 * inscribed_spheres(after, surface.triangles, deployment.chain.nodes).radii
    return {
        "mean": float(inscribed.mean()),
        "sd": float(inscribed.std()),
        "min": float(inscribed.min()),
        "max": float(inscribed.max()),
    }


def measured(quick: bool, largest: int | None = None) -> Found:
    edge_length = 0.5 if quick else 0.2
    rows = []
    for name, made, start in fine_phantoms(edge_length):
        progress(name)
        axis = made.axis_at(np.linspace(start, start + 16.0, 400))
        for mode, settings in MODES.items():
            found = diameters(made.surface, axis, DIAMETER / 2, settings)
            rows.append({"case": name, "mode": mode, "prescribed": DIAMETER, **found})
        if quick:
            break
    for level in range(0 if quick else 1 + (2 if largest is None else min(largest, 2))):
        case = aorta_case(level)
        progress(f"aorta, {len(case.triangles)} triangles")
        for mode, settings in MODES.items():
            found = diameters(case.surface, case.axis, case.radius, settings)
            name = f"aorta, {len(case.triangles):,} triangles"
            rows.append({"case": name, "mode": mode, "prescribed": 2 * case.radius, **found})
    return {"edge_length_mm": edge_length, "rows": rows}


def table(found: Found) -> str:
    header = ["inscribed diameter, mm: mean, SD [min, max]", "prescribed", *MODES]
    lines: dict[tuple[str, float], list[str]] = {}
    for row in found["rows"]:
        text = f"{row['mean']:.3f}, {row['sd']:.3f} [{row['min']:.3f}, {row['max']:.3f}]"
        lines.setdefault((row["case"], row["prescribed"]), []).append(text)
    rows = [[name, prescribed, *cells] for (name, prescribed), cells in lines.items()]
    return f"Phantoms with edges of {found['edge_length_mm']} mm:\n\n{markdown(header, rows)}"


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
