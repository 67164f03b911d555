"""The surface on which a field is zero, of triangles that are nearly alike."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from ..certificate import self_intersecting_triangles
from ..geometry import (
    Surface,
    compacted,
    component_labels,
    dot,
    edges,
    faces_at,
    oriented_triangles,
    search_tree,
    signed_volume,
    used_points,
)
from ..threads import side_by_side
from ..validation import Floats, Indices, Points, Triangles
from .labelmap import Grid

OFF = 0.2
"""Share of a voxel by which values are kept off zero for the contour: it has no triangle that is
thinner. Points move onto the wall itself afterward."""

ROUNDS = 5
"""Number of moves of points toward the middle of their neighbors, along the wall."""

PART = 0.7
"""Share of the way to the middle of the neighbors."""

BULGE = 1 / 3
"""Share of the way from the middle of its neighbors by which a point moves out: the middles of
triangles, and not their corners, then lie on a round wall. Of equilateral triangles with sides a on
a sphere of radius R, middles lie a^2 / (6 R) within it, and the middle of a corner's neighbors a^2
/ (2 R) below that."""


LEAST = 0.1
"""Share of its way below which a point goes back altogether."""


class _Field(NamedTuple):
    """A field by the coefficients of its spline, on a grid that begins at zero."""

    values: Grid
    slopes: tuple[Grid, ...]
    spacing: Floats

    def at(self, coefficients: Grid, points: Points) -> Floats:
        from scipy.ndimage import map_coordinates

        places = (points / self.spacing).T
        return np.asarray(
            map_coordinates(coefficients, places, order=2, mode="nearest", prefilter=False)
        )

    def directions(self, points: Points) -> Points:
        """Slopes (n, 3) of the field."""
        return np.stack(side_by_side(partial(self.at, points=points), self.slopes), axis=1)


def contoured(field: Grid, spacing: Floats) -> Surface:
    """The surface on which a field is zero; closed where its border is positive.

    Flying edges (Schroeder, Maynard and Geveci 2015, doi 10.1109/LDAV.2015.7348069) give the
    triangles; points then even out along the wall and stay on it.

    Parameters
    ----------
    field : (i, j, k) array
        About a distance, negative inside.
    spacing : (3,) array
        Spacing of the grid, whose first value is at the origin, mm.
    """
    from scipy.ndimage import spline_filter

    voxel = float(spacing.min())
    sound, triangles = _flying_edges(_off_zero(field, OFF * voxel), spacing)
    splines = partial(spline_filter, order=2, output=np.float32)
    values, *slopes = side_by_side(splines, (field, *np.gradient(field, *spacing)))
    smooth = _Field(values, tuple(slopes), spacing)
    points, normals = _onto(sound, smooth, voxel)
    links = edges(triangles).vertices
    for _ in range(ROUNDS):
        points = points - PART * _along(_off_middle(points, links), normals)
        points, normals = _onto(points, smooth, voxel)
    off = _off_middle(points, links)
    points = points + BULGE * (off - _along(off, normals))
    points = unfolded(points, sound, triangles, links)
    return Surface(points, oriented_triangles(points, triangles))


def unfolded(points: Points, sound: Points, triangles: Triangles, links: Indices) -> Points:
    """The points, those of triangles that intersect each other halfway back to where none do, again
    and again, with their neighbors: in a narrow cleft one wall may go through the other."""
    share, among = np.ones(len(points)), None
    # Ends: a point is back after some halves, and triangles of such points do not intersect.
    while True:
        found = sound + share[:, None] * (points - sound)
        folded = used_points(triangles[self_intersecting_triangles(found, triangles, among)])
        if not share[folded].any():
            return found
        is_near = np.zeros(len(points), dtype=bool)
        is_near[folded] = True
        is_near[links[is_near[links].any(axis=1)]] = True
        share[is_near] *= np.where(share[is_near] > LEAST, 0.5, 0.0)
        among = faces_at(is_near, triangles)


def _off_zero(field: Grid, least: float) -> Grid:
    return np.where(np.abs(field) < least, np.where(field < 0, -least, least), field)


def _flying_edges(field: Grid, spacing: Floats) -> tuple[Points, Triangles]:
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    image = vtkImageData()
    image.SetDimensions(*field.shape)
    image.SetSpacing(*spacing)
    values = np.ascontiguousarray(field.T).ravel()  # x runs fastest
    image.GetPointData().SetScalars(numpy_to_vtk(values))
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    contour.ComputeNormalsOff()
    contour.ComputeScalarsOff()
    contour.Update()
    made = contour.GetOutput()
    points = vtk_to_numpy(made.GetPoints().GetData()).astype(np.float64)
    corners = vtk_to_numpy(made.GetPolys().GetConnectivityArray()).astype(np.int64)
    return compacted(points, corners.reshape(-1, 3))


def _onto(points: Points, field: _Field, voxel: float) -> tuple[Points, Points]:
    """Points moved onto the wall by two steps of Newton, and its unit normals there."""
    for _ in range(2):
        slopes = field.directions(points)
        steep = np.maximum(dot(slopes, slopes), np.finfo(float).tiny)
        step = np.clip(field.at(field.values, points) / np.sqrt(steep), -voxel, voxel)
        points = points - (step / np.sqrt(steep))[:, None] * slopes
    return points, slopes / np.sqrt(steep)[:, None]


def _off_middle(points: Points, links: Triangles) -> Points:
    """Vectors from the middle of its neighbors to every point (n, 3)."""
    first, second = links.T
    count = np.bincount(links.ravel(), minlength=len(points))
    sums = [
        np.bincount(first, column[second], len(points))
        + np.bincount(second, column[first], len(points))
        for column in points.T
    ]
    return points - np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]


def _along(ways: Points, normals: Points) -> Points:
    """Part of ways (n, 3) along the wall."""
    return ways - dot(ways, normals)[:, None] * normals


class LargestPart(NamedTuple):
    """The part of a surface that has the largest volume, and what was left out beside it."""

    surface: Surface
    left_out: Points | None = None
    """(3,) place of other parts that is next to the largest one, mm; None without others."""
    left_volume: float = 0.0
    """Volume of other parts, mm^3."""


def largest_part(surface: Surface) -> LargestPart:
    """The part of a surface that has the largest volume, and none within it."""
    links = edges(surface.triangles).vertices
    label = component_labels(len(surface.points), links[:, 0], links[:, 1])
    part = label[surface.triangles[:, 0]]
    if part.max(initial=0) == 0:
        return LargestPart(surface)
    numbers = np.unique(part)
    volumes = np.abs([signed_volume(surface.points, surface.triangles[part == n]) for n in numbers])
    most = int(np.argmax(volumes))
    kept = Surface(*compacted(surface.points, surface.triangles[part == numbers[most]]))
    others = surface.points[label != numbers[most]]
    beside = others[search_tree(kept.points).query(others)[0].argmin()]
    return LargestPart(kept, beside, float(volumes.sum() - volumes[most]))
