"""The preview on a proxy against the full preview and the full measurement, in seeded stents.

    python -m benchmarks.proxy [--quick]

Per anatomy, as it is and with four times the triangles: the distance, mm, of vertices to where the
full preview puts them, faces that look the other way than there, what the minimum lumen among the
proxy's points is off that of the finished deployment, and CPU times. Then what one of 60 places
down the aorto-iliac model costs, undrawn, at up to 1.2 million triangles.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np

from SDFStentLib.deformation import DeploymentSettings, Proxy, deploy
from SDFStentLib.geometry import Surface, dot, face_normals, resampled
from SDFStentLib.measure import diameter_profile, rough_radii
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.treatment import Preview

from . import sweep
from .bench_certificate import subdivided
from .common import Found, markdown, progress, run_alone

SEED = 77
RATIOS = ((1.05, 1.6), (1.6, 2.2))
ROUNDS = 3
PLACES = 60
LENGTHS = (6.0, 10.0, 14.0, 20.0)
AORTA = "aorta_iliac"


class Row(NamedTuple):
    """Of one stent."""

    points: int
    spacing: float
    largest: float
    most: float
    mean: float
    turned: int
    turned_in_full: int
    lumen_error: float
    milliseconds: float
    full_milliseconds: float


def compared(surface: Surface, proxy: Proxy, stent: sweep.RandomStent, *, with_lumen: bool) -> Row:
    settings = DeploymentSettings.preview()
    chain, before = settings.chain(stent.axis), surface.points
    seen, spent = _best(lambda: proxy.deployed(chain, stent.radius))
    full, spent_in_full = _best(lambda: deploy(surface, chain, stent.radius, settings))
    shown = seen.state.applied_to(before)
    distance = np.linalg.norm(shown - full.points, axis=1)
    moved = distance[full.state.indices]
    old, right, new = (face_normals(p, surface.triangles) for p in (before, full.points, shown))
    error = float("nan")
    if with_lumen:
        rough = 2 * rough_radii(seen.points, resampled(stent.axis, 1.0), seen.normals).min()
        after = deploy(surface, chain, stent.radius).surface
        error = float(rough - diameter_profile(after, stent.axis).minimum)
    return Row(
        len(seen.points),
        seen.spacing,
        float(distance.max()),
        float(np.percentile(moved, 99)),
        float(moved.mean()),
        int((dot(right, new) < 0).sum()),
        int((dot(old, right) < 0).sum()),
        error,
        spent,
        spent_in_full,
    )


def _best(function: Callable[[], Any]) -> tuple[Any, float]:
    """What a function returns, and the least CPU time, ms, of some rounds."""
    times = []
    for _ in range(ROUNDS):
        start = time.process_time()
        value = function()
        times.append(1e3 * (time.process_time() - start))
    return value, min(times)


def redeployments(subdivisions: int, count: int) -> Found:
    """What one costs along the longest branch, ms of CPU; the first round makes weights."""
    made = sweep.vessel(AORTA)
    surface, line = made.surface, made.centerline
    for _ in range(subdivisions):
        surface = Surface(*subdivided(surface.points, surface.triangles))
    chain = line.ancestry(line.leaves[np.argmax(line.arc_length[line.leaves])])
    way = chain[np.linspace(0.2 * len(chain), 0.8 * len(chain), count).astype(int)]
    diameter = round(2.4 * float(np.nanmedian(line.inscribed_radius[way])), 1)
    preview, rounds = Preview(surface, line), []
    preview.prepare()  # as the panel does when the vessel is chosen
    for _ in range(2):
        spent = []
        for place, length in zip(line.points[way], cycle(LENGTHS)):
            stent = Stent(diameter, placement=AtCenter(place), length=length)
            start = time.process_time()
            seen = preview.of([stent])
            spent.append(1e3 * (time.process_time() - start))
        rounds.append(spent)
    return {
        "triangles": len(surface.triangles),
        "points": len(seen.stents[0].state.points),
        "moved": len(seen.indices),
        "first": float(max(rounds[0])),
        "median": float(np.median(rounds[1])),
        "slowest": float(max(rounds[1])),
    }


def measured(quick: bool, largest: int | None = None) -> Found:
    found: Found = {}
    for name in sweep.ANATOMIES:
        vessel = sweep.vessel(name)
        fine = Surface(*subdivided(vessel.points, vessel.triangles))
        for surface, count in ((vessel.surface, 16), (fine, 8)):
            proxy = Proxy(surface, vessel.centerline.points)
            for ratios in RATIOS:
                progress(f"{name}, {len(surface.triangles):,} triangles, {ratios}")
                stents = (
                    sweep.random_stent(name, SEED, number, ratios)
                    for number in range(1 if quick else count)
                )
                is_given = surface is vessel.surface
                rows = [compared(surface, proxy, one, with_lumen=is_given) for one in stents]
                key = f"{name}, {len(surface.triangles):,}, {ratios[0]:g} to {ratios[1]:g} x"
                found[key] = [row._asdict() for row in rows]
    finer = (0, 1) if quick else (0, 2, 3)
    sizes = []
    for subdivisions in finer:
        progress(f"{AORTA}, {PLACES} places, {subdivisions} subdivisions")
        sizes.append(redeployments(subdivisions, 4 if quick else PLACES))
    return {"stents": found, "sizes": sizes}


def table(found: Found) -> str:
    lines = []
    for name, rows in found["stents"].items():
        values = {key: np.array([row[key] for row in rows]) for key in Row._fields}
        errors = np.abs(values["lumen_error"])
        lines.append(
            [
                name,
                len(rows),
                f"{values['points'].max()}",
                f"{np.median(values['largest']):.2f} / {values['largest'].max():.2f}",
                f"{np.median(values['most']):.2f} / {values['most'].max():.2f}",
                f"{np.median(values['mean']):.3f} / {values['mean'].max():.3f}",
                f"{values['turned'].max()} ({values['turned_in_full'].max()})",
                "" if np.isnan(errors).all() else f"{np.median(errors):.2f} / {errors.max():.2f}",
                f"{np.median(values['milliseconds']):.0f}",
                f"{np.median(values['full_milliseconds']):.0f}",
            ]
        )
    header = (
        "anatomy, triangles, stent over lumen",
        "stents",
        "points at most",
        "largest distance, median / most",
        "99th percentile",
        "mean",
        "faces turned (by the full preview)",
        "minimum lumen off by",
        "ms of CPU",
        "in full",
    )
    return f"{markdown(header, lines)}\n\n{sizes_table(found)}"


def sizes_table(found: Found) -> str:
    """What one redeployment costs at any size of mesh."""
    header = (
        "triangles, places down the aorto-iliac model in turn",
        "points deployed, last place",
        "points moved, last place",
        "ms of CPU, median",
        "slowest",
        "slowest of the first round",
    )
    rows = [
        [
            f"{one['triangles']:,}",
            f"{one['points']:,}",
            f"{one['moved']:,}",
            *(f"{one[key]:.0f}" for key in ("median", "slowest", "first")),
        ]
        for one in found["sizes"]
    ]
    return markdown(header, rows)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
