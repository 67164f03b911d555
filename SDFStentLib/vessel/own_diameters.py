"""Vessels as wide as they are themselves beside branches that leave at a throat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..centerline import BranchLumen
from ..geometry import Surface, tangents
from ..lumen import InscribedSpheres, with_own_spheres
from ..validation import Points
from .runs import VesselRun


def with_own_diameters(
    surface: Surface, lumens: Sequence[BranchLumen], runs: Sequence[VesselRun]
) -> list[VesselRun]:
    """Vessels without the spheres that have left them; which vessel goes on where is as before.

    Parameters
    ----------
    surface : Surface
    lumens : sequence of BranchLumen
        With the spheres of all stations.
    runs : sequence of VesselRun
        Of these.
    """
    of_branch = {lumen.branch: lumen for lumen in lumens}
    stations = np.concatenate([run.points for run in runs])
    ends = np.cumsum([len(run.along) for run in runs])
    lines = np.split(np.arange(len(stations)), ends[:-1])
    found = InscribedSpheres(
        np.concatenate([_centers(run, of_branch) for run in runs]),
        np.concatenate([run.diameter / 2 for run in runs]),
    )
    ways = np.concatenate([tangents(run.points) for run in runs])
    wall = surface.points, surface.triangles
    diameter = 2 * with_own_spheres(wall, stations, ways, found, lines).radii
    return [run._replace(diameter=diameter[line]) for run, line in zip(runs, lines, strict=True)]


def _centers(run: VesselRun, of_branch: Mapping[int, BranchLumen]) -> Points:
    """Of the spheres at a vessel's stations, (n, 3) mm."""
    found = np.full((len(run.along), 3), np.nan)
    for branch in np.unique(run.branch).tolist():
        own, lumen = run.branch == branch, of_branch[branch]
        at = np.abs(lumen.along - run.branch_along[own, None]).argmin(axis=1)
        found[own] = lumen.centers[at]
    return found
