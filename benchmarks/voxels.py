"""How well a surface from voxels has the diameters of the vessel that the voxels show.

python -m benchmarks.voxels [--quick] [--ways NAME ...] [--json FILE]

Bent tubes of known diameters, narrowed by half in the middle, are cut into voxels of 0.3 to 1.2 mm,
cubes or twice as long as wide, at a random turn; one border voxel in ten is flipped in half of
them. Inscribed diameters along the axis are held against those of the tubes. Errors are in voxels,
a voxel being the side of a cube as large.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import (
    vtkFlyingEdges3D,
    vtkSurfaceNets3D,
    vtkWindowedSincPolyDataFilter,
)
from vtkmodules.vtkFiltersGeneral import vtkDiscreteFlyingEdges3D

from SDFStentLib.geometry import Line, Surface, compacted
from SDFStentLib.lumen import inscribed_spheres
from SDFStentLib.scan import Labelmap, contoured, wall_distance

from .common import Found, markdown, progress

DIAMETERS = (5.0, 10.0, 20.0)
VOXELS = (0.3, 0.6, 1.2)
LARGEST = 40.0
"""Diameters of more voxels are left out: they take long, and say nothing new."""

FLIPPED = 0.1
"""Share of the voxels at the border that are on its wrong side, in half of the cases."""

NARROW = 6.0
"""Voxels across a vessel from which on its border is no mere staircase."""

ROOM = 8
"""Voxels round a tube."""


class VoxelTube(NamedTuple):
    """A tube as voxels; its axis and radii are known exactly, for it is a union of balls."""

    labelmap: Labelmap
    axis: np.ndarray
    """(n, 3) mm, along the axes of the voxels from the first one."""
    radii: np.ndarray


def voxel_tube(diameter: float, spacing: np.ndarray, flipped: float, seed: int) -> VoxelTube:
    """A quarter of a ring, narrowed by half over a diameter, in voxels."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0, np.pi / 2, 1200)
    bend = 3 * diameter
    flat = bend * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    axis = flat @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    along = bend * turn
    radii = diameter / 2 * (1 - 0.5 * np.exp(-(((along - along[-1] / 2) / diameter) ** 2)))
    low = axis.min(axis=0) - diameter / 2 - (ROOM + rng.random(3)) * spacing
    axis -= low
    high = axis.max(axis=0) + diameter / 2 + ROOM * spacing
    mask = _within(axis, radii, np.ceil(high / spacing).astype(int), spacing)
    if flipped:
        border = ndimage.binary_dilation(mask) & ~ndimage.binary_erosion(mask)
        mask ^= border & (rng.random(mask.shape) < flipped)
    return VoxelTube(Labelmap(mask, spacing, np.zeros(3), np.eye(3)), axis, radii)


def _within(axis: np.ndarray, radii: np.ndarray, size: np.ndarray, spacing: np.ndarray):
    """Whether the centers of voxels are in one of the balls along an axis."""
    grid = np.indices(tuple(size)).reshape(3, -1).T * spacing
    away, nearest = cKDTree(axis).query(grid, distance_upper_bound=1.2 * radii.max())
    near = np.flatnonzero(np.isfinite(away))
    found = np.zeros(len(grid), dtype=bool)
    # The ball that reaches farthest is one beside the nearest, as radii change by little.
    for step in range(-150, 151, 10):
        ball = np.clip(nearest[near] + step, 0, len(axis) - 1)
        found[near] |= np.linalg.norm(grid[near] - axis[ball], axis=1) < radii[ball]
    return found.reshape(size)


STATIONS = np.arange(200, 1001, 40)
"""Places of the axis off the ends."""


def errors(surface: Surface, tube: VoxelTube) -> np.ndarray:
    """Errors of the inscribed diameters at `STATIONS`, voxels."""
    ways = Line(tube.axis).directions[STATIONS]
    found = inscribed_spheres(surface.points, surface.triangles, tube.axis[STATIONS], ways)
    return 2 * (found.radii - tube.radii[STATIONS]) / tube.labelmap.voxel


def _image(values: np.ndarray, spacing: np.ndarray) -> vtkImageData:
    image = vtkImageData()
    image.SetDimensions(*values.shape)
    image.SetSpacing(*spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values.T).ravel(), deep=1))
    return image


def _surface(polydata) -> Surface:
    points = vtk_to_numpy(polydata.GetPoints().GetData()).astype(float)
    corners = vtk_to_numpy(polydata.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return Surface(*compacted(points, corners.astype(np.int64)))


def chosen(labelmap: Labelmap) -> Surface:
    return contoured(wall_distance(labelmap), labelmap.spacing)


def of_share(share: float) -> Callable[[Labelmap], Surface]:
    return lambda labelmap: contoured(wall_distance(labelmap, share), labelmap.spacing)


def gauss(labelmap: Labelmap) -> Surface:
    """Flying edges of the label after a Gauss filter of one voxel."""
    soft = ndimage.gaussian_filter(labelmap.mask.astype(np.float32), 1.0)
    contour = vtkFlyingEdges3D()
    contour.SetInputData(_image(0.5 - soft, labelmap.spacing))
    contour.SetValue(0, 0.0)
    contour.Update()
    return _surface(contour.GetOutput())


def nets(labelmap: Labelmap) -> Surface:
    """Surface nets as VTK sets them."""
    contour = vtkSurfaceNets3D()
    contour.SetInputData(_image(labelmap.mask.astype(np.uint8), labelmap.spacing))
    contour.SetValue(0, 1)
    contour.SetOutputMeshTypeToTriangles()
    contour.Update()
    return _surface(contour.GetOutput())


def sinc(labelmap: Labelmap) -> Surface:
    """Discrete flying edges, then a windowed sinc of 20 rounds with a pass band of 0.01."""
    contour, smooth = vtkDiscreteFlyingEdges3D(), vtkWindowedSincPolyDataFilter()
    contour.SetInputData(_image(labelmap.mask.astype(np.uint8), labelmap.spacing))
    contour.SetValue(0, 1)
    smooth.SetInputConnection(contour.GetOutputPort())
    smooth.SetPassBand(0.01)
    smooth.NormalizeCoordinatesOn()
    smooth.NonManifoldSmoothingOn()
    smooth.Update()
    return _surface(smooth.GetOutput())


WAYS: dict[str, Callable[[Labelmap], Surface]] = {
    "ours": chosen,
    "surface nets": nets,
    "flying edges, windowed sinc": sinc,
    "flying edges, Gauss 1 voxel": gauss,
    **{f"share {share:g}": of_share(share) for share in (0.3, 0.4, 0.6, 0.7)},
}
"""The way that `prepare` takes, what VTK offers, and other widths of the filter."""


def cases(quick: bool) -> list[tuple[float, float, bool, float]]:
    """Diameter and voxel, mm, whether voxels are twice as long, and the share flipped."""
    found = [
        (diameter, voxel, is_long, flipped)
        for diameter in (DIAMETERS[1:2] if quick else DIAMETERS)
        for voxel in (VOXELS[1:] if quick else VOXELS)
        for is_long in (False, True)
        for flipped in (0.0, FLIPPED)
    ]
    return [one for one in found if one[0] / one[1] <= LARGEST]


def measured(quick: bool, ways: list[str]) -> Found:
    rows = []
    for number, (diameter, voxel, is_long, flipped) in enumerate(cases(quick)):
        spacing = np.array([voxel, voxel, 2 * voxel if is_long else voxel])
        tube = voxel_tube(diameter, spacing, flipped, number)
        for way in ways:
            start = time.perf_counter()
            surface = WAYS[way](tube.labelmap)
            seconds = time.perf_counter() - start
            off = errors(surface, tube)
            wide = 2 * tube.radii[STATIONS] / tube.labelmap.voxel
            rows.append({"way": way, "diameter": diameter, "voxel": voxel, "is_long": is_long,
                         "flipped": flipped, "seconds": seconds, "voxels_wide": wide.tolist(),
                         "errors": off.tolist()})  # fmt: skip
            progress(f"{way}, {diameter:g} mm of {spacing} mm: {np.nanmean(np.abs(off)):.2f}")
    return {"rows": rows}


def table(found: Found) -> str:
    """Errors of every way: by width of the vessel in voxels, and by the kind of these."""
    header = ["way", "where", "mean error", "mean of its size", "95 % within", "seconds"]
    lines = []
    for way in dict.fromkeys(row["way"] for row in found["rows"]):
        own = [row for row in found["rows"] if row["way"] == way]
        wide, off = (np.concatenate([row[key] for row in own]) for key in ("voxels_wide", "errors"))
        is_long, flipped = (
            np.repeat([bool(row[key]) for row in own], len(STATIONS))
            for key in ("is_long", "flipped")
        )
        kinds = {
            f"{NARROW:g} voxels wide or more": wide >= NARROW,
            "of these, cubes": (wide >= NARROW) & ~is_long,
            "twice as long": (wide >= NARROW) & is_long,
            "flipped": (wide >= NARROW) & flipped,
            f"below {NARROW:g} voxels": wide < NARROW,
        }
        seconds = f"{max(row['seconds'] for row in own):.1f}"
        for kind, some in kinds.items():
            part = off[some & np.isfinite(off)]
            size = np.abs(part)
            numbers = (
                f"{part.mean():+.2f}",
                f"{size.mean():.2f}",
                f"{np.quantile(size, 0.95):.2f}",
            )
            lines.append([way, kind, *numbers, seconds])
    return markdown(header, lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one diameter, two sizes of voxels")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS)[:4], metavar="NAME")
    parser.add_argument("--largest", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers here")
    options = parser.parse_args()
    found = measured(options.quick, options.ways)
    print(table(found))
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
