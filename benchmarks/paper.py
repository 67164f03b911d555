"""The comparison of the SDFStent paper: a 6.0 mm stent in a patient's left pulmonary artery.

python -m benchmarks.paper [--quick]

The stent lies where the diameters before it are those of the paper. Its published values for XPBD,
RK and morphMan are listed beside ours; svmorph runs where it is installed.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.files import read_centerline, read_surface
from SDFStentLib.geometry import Line
from SDFStentLib.lumen import inscribed_spheres

from .common import Found, StentCase, duration, markdown, progress, run_alone, seconds_of
from .sweep import DATA_FOLDER

DIAMETER, START, LENGTH, CRIMPED = 6.0, 43.0, 24.0, 0.4
TOWARD = (29.5, -91.9, -52.3)
"""Place beside the outlet to which the path leads, mm."""

PUBLISHED = {
    "before": (1.96, 3.34, 2.56, 0.44, None),
    "SDFStent": (5.68, 6.00, 5.92, 0.08, 1.5),
    "XPBD": (4.80, 5.84, 5.48, 0.26, 160.5),
    "RK": (5.40, 6.44, 6.00, 0.22, 84.0),
    "morphMan": (4.14, 5.98, 5.06, 0.60, 861.0),
}
"""Smallest, largest and mean inscribed diameter with its standard deviation, mm, and seconds on the
authors' machine: their table of virtual stenting results."""

MODES = {
    "default": DeploymentSettings(),
    "as published (k/4)": DeploymentSettings.published().with_changes(certify=False),
}


def the_case() -> StentCase:
    surface = read_surface(DATA_FOLDER / "su0243_surface_mm.vtp").surface
    line = read_centerline(DATA_FOLDER / "su0243_centerline_mm.vtp")
    leaves = line.points[line.leaves]
    leaf = leaves[np.linalg.norm(leaves - TOWARD, axis=1).argmin()]
    path = line.path(line.points[line.roots[0]], leaf).points
    return StentCase(
        "su0243", surface, Line(path).cut(START, START + LENGTH).points, DIAMETER / 2, path
    )


def measured(quick: bool, _largest: int | None = None) -> Found:
    case = the_case()
    stations = Line(case.axis).resampled(1.0).points
    rows = []

    def added(name: str, points: np.ndarray, seconds: float | None) -> None:
        radii = inscribed_spheres(points, case.triangles, stations, Line(stations).directions).radii
        d = 2 * radii
        values = (d.min(), d.max(), d.mean(), d.std())
        rows.append({"name": name, "mm": [float(x) for x in values], "seconds": seconds})

    added("before", case.points, None)
    for name, settings in MODES.items():
        progress(name)
        chain = settings.chain(case.axis)
        deployment = Deployment(
            case.surface, chain, case.radius, settings, companions=case.centerline
        )
        seconds = seconds_of(lambda deployment=deployment: deployment.result)
        added(name, deployment.result.points, seconds)
    if not quick and importlib.util.find_spec("svmorph"):
        from .svmorph_peer import SvmorphPeer

        progress("svmorph 0.1.2")
        peer = SvmorphPeer(
            case.points, case.centerline, case.axis, CRIMPED, deployment.target_level
        )
        peer.deployed()
        added("svmorph 0.1.2, warm", peer.deployed(), seconds_of(peer.deployed))
    return {"rows": rows}


def table(found: Found) -> str:
    ours = [(row["name"], *row["mm"], row["seconds"]) for row in found["rows"]]
    rows = [[f"{name}, as published", *values] for name, values in PUBLISHED.items()]
    cells = [
        [name, *(f"{x:.2f}" for x in mm), "" if seconds is None else duration(seconds)]
        for name, *mm, seconds in [*ours, *rows]
    ]
    header = ["inscribed diameter, mm", "smallest", "largest", "mean", "SD", "time"]
    return markdown(header, cells)


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
