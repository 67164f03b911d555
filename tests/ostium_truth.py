"""Ostia found by plain ray casting with VTK, as a reference for the library's rule.

Rays, centers, expected wall and openings are all computed in another way than in the library; only
the definition is common. Slow on purpose.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import ndimage
from scipy.spatial import KDTree
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import mutable, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkStaticCellLocator

RAYS, FEW_RAYS, SPACING = 180, 60, 0.5


class Opening(NamedTuple):
    start: float
    end: float
    share: float
    depth: float


class RayCaster:
    def __init__(self, points, triangles):
        self.polydata = vtkPolyData()
        held = vtkPoints()
        held.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
        cells = vtkCellArray()
        rows = np.column_stack([np.full(len(triangles), 3), triangles]).astype(np.int64)
        cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
        self.polydata.SetPoints(held)
        self.polydata.SetPolys(cells)
        self.locator = vtkStaticCellLocator()
        self.locator.SetDataSet(self.polydata)
        self.locator.BuildLocator()
        low, high = np.reshape(self.polydata.GetBounds(), (3, 2)).T
        self.far = float(np.linalg.norm(high - low))

    def distance(self, start, direction):
        share, part, cell = mutable(0.0), mutable(0), mutable(0)
        end, met, inside = start + self.far * direction, [0.0] * 3, [0.0] * 3
        found = self.locator.IntersectWithLine(start, end, 1e-9, share, met, inside, part, cell)
        return float(share) * self.far if found else np.inf


def stations_of(axis, window):
    """Points every half millimeter of a polyline, and unit directions over a window."""
    at = np.r_[0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1))]
    positions = np.linspace(0, at[-1], max(2, round(at[-1] / SPACING) + 1))

    def place(s):
        return np.column_stack([np.interp(s, at, axis[:, k]) for k in range(3)])

    ahead = np.minimum(positions + window / 2, at[-1])
    behind = np.maximum(positions - window / 2, 0)
    directions = place(ahead) - place(behind)
    return positions, place(positions), directions / np.linalg.norm(directions, axis=1)[:, None]


def cast(caster, centers, directions, count=RAYS):
    """Ray lengths (n, count) and the directions of the rays (n, count, 3)."""
    angles = np.arange(count) * 2 * np.pi / count
    first = np.cross(directions[0], np.eye(3)[np.abs(directions[0]).argmin()])
    lengths, rays = [], []
    for center, direction in zip(centers, directions, strict=True):
        first = first - (first @ direction) * direction
        first /= np.linalg.norm(first)
        second = np.cross(direction, first)
        across = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
        rays.append(across)
        lengths.append([caster.distance(center, ray) for ray in across])
    return np.array(lengths), np.array(rays)


def opened(values, size):
    """The largest of the smallest values over all windows of `size` rows that contain a row."""
    padded = np.pad(values, ((size - 1, size - 1), (0, 0)), mode="edge")
    lowest = sliding_window_view(padded, size, axis=0).min(axis=-1)
    return sliding_window_view(lowest, size, axis=0).max(axis=-1)


def expected(lengths, radius):
    along = opened(lengths, int(6 * radius / SPACING))
    turns, count = np.tile(lengths, 3).T, lengths.shape[1]
    round_about = opened(turns, int(count * 240 / 360)).T[:, count : 2 * count]
    return np.maximum(along, round_about)


def leads_away(hits, centers, wall):
    """The distance of the rays' ends from the path, in widths of the vessel there.

    A ray that runs back along the vessel itself, in a sharp bend, ends near the path.
    """
    is_met = np.isfinite(hits).all(axis=2)
    distance, nearest = KDTree(centers).query(np.where(is_met[..., None], hits, 0.0))
    width = np.median(wall, axis=1)[nearest]  # zero where the path lies on the wall
    away = np.divide(distance, width, out=np.zeros_like(distance), where=width > 0)
    return np.where(is_met, away, 0.0)


def openings(points, triangles, axis, before, stent_length, leaves=1.15, depth=1.7):
    """The openings along an extended axis, positions from the proximal end of the stent."""
    return openings_at(points, triangles, axis, before, stent_length, [leaves], depth)[0]


def openings_at(points, triangles, axis, before, stent_length, thresholds, depth=1.7):
    """The openings for each of several thresholds of how far the wall must leave the vessel."""
    caster = RayCaster(points, triangles)
    _, centers, directions = stations_of(axis, 2.0)
    lengths, _ = cast(caster, centers[::4], directions[::4])
    sides = np.percentile(lengths, 30, axis=1, method="lower")
    radius = float(np.median(sides[np.isfinite(sides)]))
    positions, centers, directions = stations_of(axis, radius)
    for count in (FEW_RAYS, FEW_RAYS, RAYS):  # a few rays suffice to find the middle
        lengths, rays = cast(caster, centers, directions, count)
        wall = expected(lengths, radius)
        # Center of the expected section: the mean of its triangles, weighted by area.
        corners = np.where(np.isfinite(wall), wall, 0)[..., None] * rays
        following = np.roll(corners, -1, axis=1)
        area = np.linalg.norm(np.cross(corners, following), axis=2)
        middle = ((corners + following) / 3 * area[..., None]).sum(axis=1)
        middle /= np.maximum(area.sum(axis=1), 1e-9)[:, None]
        middle[~np.isfinite(wall).all(axis=1)] = 0
        sigma = radius / 2 / SPACING
        centers = centers + ndimage.gaussian_filter1d(middle, sigma, axis=0, mode="nearest")
    # If both are infinite, or neither is, the wall is where it is expected.
    ratio = np.divide(lengths, wall, out=np.ones_like(lengths), where=lengths != wall)
    away = leads_away(centers[:, None] + lengths[..., None] * rays, centers, wall)
    at = positions - before
    return [_openings(ratio > leaves, away, at, wall, stent_length, depth) for leaves in thresholds]


def _openings(is_open, away, at, wall, stent_length, depth):
    labels, _ = ndimage.label(np.tile(is_open, 3), structure=np.ones((3, 3)))
    found = []
    for number in np.unique(labels[:, RAYS : 2 * RAYS]):
        # A region across the seam is whole in one of the turns, or in two of them together.
        region = (labels == number).reshape(len(at), 3, RAYS).any(axis=1)
        if number == 0 or not away[region].max() > depth:
            continue
        rows = np.flatnonzero(region.any(axis=1))
        weight = np.where(region & np.isfinite(wall), wall, 0).sum(axis=1)
        half = SPACING / 2
        inside = np.clip(at + half, 0, stent_length) - np.clip(at - half, 0, stent_length)
        found.append(
            Opening(
                at[rows[0]], at[rows[-1]], (weight @ inside) / weight.sum() / SPACING,
                float(away[region].max()),
            )
        )  # fmt: skip
    return sorted({(o.start, o.end): o for o in found}.values())
