"""Own centerlines of bare surfaces against VMTK's (Python 3.12 or later).

python -m benchmarks.against_vmtk [--surface NAME ...]

Both are made in turn, each once, the own ones in a thread per core, as the command does, VMTK's in
the one that it uses. VMTK is given its ends: the flat ones of a surface, else those of the own
line. That is made twice: of nothing but the surface, and of the same ends. Reading does not count.
Distances are those of VMTK's points, a radius or more from every end, to the nearest own line, in
radii. Lesions are those that the library finds with each; the same are within 1 mm and 1 percentage
point.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from SDFStentLib import extract_centerline
from SDFStentLib.centerline import Centerline
from SDFStentLib.files import extract_lines, read_surface
from SDFStentLib.geometry import Line, Surface
from SDFStentLib.threads import use_threads
from SDFStentLib.validation import InputError
from SDFStentLib.vessel import Lesion, LineSeeds, find_lesions, line_seeds

from .common import Found, markdown, progress
from .sweep import DATA_FOLDER

SURFACES = {
    "su0243_surface_mm": "mm",
    "pulmonary_surface_cm": "cm",
    "aorta_iliac_surface_cm": "cm",
    "vmtk_aorta_surface_mm": "mm",
}

SAME = (1.0, 1.0)
"""Largest distance, mm, and difference in percentage points of the same lesion by two lines."""


def timed(make: Callable[[], Centerline]) -> tuple[Centerline, float]:
    """A centerline and the seconds of the clock that it took."""
    start = time.perf_counter()
    made = make()
    return made, time.perf_counter() - start


def ends_of(surface: Surface, own: Centerline) -> LineSeeds:
    """The flat ends of a surface, or where there is none the own ends."""
    try:
        return line_seeds(surface)
    except InputError:
        return line_seeds(surface, own.points[own.roots[0]], list(own.points[own.leaves]))


def by_vmtk(seeds: LineSeeds) -> Centerline:
    """VMTK's centerline between some ends."""
    points, lines, radii = extract_lines(*seeds)
    return Centerline.from_lines(points, lines, radii, inlet=points[lines[0][0]])


def by_name(surface: Surface, seeds: LineSeeds) -> Centerline:
    """The own centerline between the same ends."""
    inlet, *outlets = seeds.surface.points[[seeds.inlet, *seeds.outlets]]
    return extract_centerline(surface, inlet, outlets).centerline


def finely(line: Centerline) -> np.ndarray:
    """Points (n, 3) of all lines, 0.1 mm apart."""
    ways = (line.points[branch] for branch in line.branches)
    return np.vstack([Line(way).resampled(0.1).points for way in ways])


def compared(name: str) -> Found:
    """The numbers of a surface."""
    surface = read_surface(DATA_FOLDER / f"{name}.vtp", SURFACES[name]).surface
    own, own_seconds = timed(lambda: extract_centerline(surface).centerline)
    seeds = ends_of(surface, own)
    _, named_seconds = timed(lambda: by_name(surface, seeds))
    vmtk, vmtk_seconds = timed(lambda: by_vmtk(seeds))
    ends = vmtk.points[vmtk.leaves]
    radii = vmtk.inscribed_radius
    near, _ = cKDTree(own.points[own.leaves]).query(ends)
    is_inner = cKDTree(np.vstack([ends, vmtk.points[vmtk.roots]])).query(vmtk.points)[0] > radii
    away = cKDTree(finely(own)).query(vmtk.points)[0][is_inner] / radii[is_inner]
    return {
        "surface": name,
        "ends": f"{np.count_nonzero(near <= radii[vmtk.leaves] + 0.5)} of {len(ends)}",
        "median": round(float(np.median(away)), 3),
        "95 %": round(float(np.quantile(away, 0.95)), 3),
        "lesions own, VMTK, the same": same_lesions(
            find_lesions(surface, own), find_lesions(surface, vmtk)
        ),
        "own, s": round(own_seconds, 1),
        "ends given, s": round(named_seconds, 1),
        "VMTK, ends given, s": round(vmtk_seconds, 1),
        "times as fast": round(vmtk_seconds / own_seconds, 1),
        "ends given to both": round(vmtk_seconds / named_seconds, 1),
    }


def same_lesions(own: Sequence[Lesion], vmtk: Sequence[Lesion]) -> str:
    """Numbers of lesions with both lines, and of those within 1 mm and 1 point of each other."""
    pairs = itertools.product(own, vmtk)
    same = [
        np.linalg.norm(np.subtract(one.point, other.point)) <= SAME[0]
        and abs(one.percent_diameter - other.percent_diameter) <= SAME[1]
        for one, other in pairs
    ]
    return f"{len(own)}, {len(vmtk)}, {sum(same)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--surface", nargs="+", choices=list(SURFACES), default=list(SURFACES))
    chosen, found = parser.parse_args(), []
    use_threads(None)
    for name in chosen.surface:
        found.append(compared(name))
        progress(str(found[-1]))
    print(markdown(list(found[0]), [list(one.values()) for one in found]))


if __name__ == "__main__":
    main()
