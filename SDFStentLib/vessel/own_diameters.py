"""The vessels of a tree, measured: roughly all of them, exactly those with something to tell.

Which branch a vessel goes on in, and how wide vessels are beside each other, rough spheres tell as
well as exact ones; so they do where a vessel has no narrowing. Vessels that may have one are
measured exactly. Spheres that leave their vessel beside a throat count as what it is itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..centerline import Centerline
from ..geometry import Surface
from ..lumen import InscribedSpheres, LocalSurface, with_own_spheres
from ..validation import Indices
from .branch_lumen import tree_lumen
from .narrowings import narrowings
from .runs import VesselRun, vessel_runs
from .tree_around import limbs_of

_ROUGHLY = 0.05
"""Of the reference by which a narrowing may be deeper than rough spheres tell."""


def measured_runs(surface: Surface, centerline: Centerline) -> tuple[list[VesselRun], list[int]]:
    """The vessels of a tree as wide as they are themselves beside branches that leave at a throat.

    And the numbers of those that may have a narrowing. Errors as of `branch_lumens`.
    """
    tree = tree_lumen(surface, centerline)
    runs, wall = vessel_runs(tree.rough, limbs_of(centerline)), tree.spheres.surface
    stations = [tree.stations_of(run) for run in runs]
    own = own_runs(wall, runs, [tree.spheres.rough.at(which) for which in stations])
    asked = [number for number, run in enumerate(own) if narrowings(run, _ROUGHLY)]
    if asked:
        ends = np.cumsum([len(stations[number]) for number in asked])
        exact = tree.spheres.exact(np.concatenate([stations[number] for number in asked]))
        parts = [exact.at(part) for part in np.split(np.arange(ends[-1]), ends[:-1])]
        for number, run in zip(asked, own_runs(wall, [runs[n] for n in asked], parts), strict=True):
            own[number] = run
    return own, asked


def own_runs(
    wall: LocalSurface, runs: Sequence[VesselRun], spheres: Sequence[InscribedSpheres]
) -> list[VesselRun]:
    """Vessels with the spheres at their stations, but those that have left them.

    What is not known of a vessel stays so.
    """
    stations = np.concatenate([run.points for run in runs])
    ends = np.cumsum([len(run.along) for run in runs])
    lines: list[Indices] = np.split(np.arange(len(stations)), ends[:-1])
    centers = np.concatenate([found.centers for found in spheres])
    radii = np.concatenate([found.radii for found in spheres])
    is_known = np.isfinite(np.concatenate([run.diameter for run in runs]))
    found = InscribedSpheres(centers, np.where(is_known, radii, np.nan))
    ways = np.concatenate([run.line.directions for run in runs])
    diameter = 2 * with_own_spheres(wall, stations, ways, found, lines).radii
    return [run._replace(diameter=diameter[line]) for run, line in zip(runs, lines, strict=True)]
