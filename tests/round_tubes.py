"""Surfaces round tubes with round ends, which may part, touch and meet again."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from SDFStentLib.geometry import Surface


def chain(points, radius):
    """Pieces of a tube along a polyline: both ends and the radius at each."""
    return [(one, other, radius, radius) for one, other in pairwise(points)]


def circle(radius, count=40):
    """Points round the z axis, the last one the first."""
    angles = np.linspace(0.0, 2 * np.pi, count + 1)
    return radius * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])


def contoured(pieces, spacing, is_mask=False):
    """The surface of a union of pieces, contoured on a grid (mm); of a mask it has terraces."""
    widest = max(max(first, last) for _, _, first, last in pieces)
    corners = np.array([end for one, other, _, _ in pieces for end in (one, other)], dtype=float)
    margin = widest + 3 * spacing
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    counts = np.ceil((high - low) / spacing).astype(int) + 1
    axes = [first + spacing * np.arange(count) for first, count in zip(low, counts, strict=True)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    image = vtk.vtkImageData()
    image.SetDimensions(*counts.tolist())
    image.SetOrigin(*low)
    image.SetSpacing(spacing, spacing, spacing)
    values = away(places, pieces)
    values = np.where(values < 0, -0.5, 0.5) if is_mask else values
    image.GetPointData().SetScalars(numpy_to_vtk(values, deep=True))
    contour, clean = vtk.vtkFlyingEdges3D(), vtk.vtkCleanPolyData()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    clean.SetInputConnection(contour.GetOutputPort())
    clean.Update()
    made = clean.GetOutput()
    triangles = vtk_to_numpy(made.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return Surface(vtk_to_numpy(made.GetPoints().GetData()).astype(float), triangles.astype(int))


def away(places, pieces):
    found = np.full(len(places), np.inf)
    for one, other, first, last in pieces:
        one, way = np.asarray(one, float), np.subtract(other, one).astype(float)
        share = np.clip((places - one) @ way / max(way @ way, 1e-9), 0, 1)
        offset = places - one - share[:, None] * way
        np.minimum(
            found, np.linalg.norm(offset, axis=1) - first - share * (last - first), out=found
        )
    return found


def random_tree(seed, generations=2):
    """Pieces of a tree of tubes, and its ends: a middle and a radius each."""
    rng, pieces, ends = np.random.default_rng(seed), [], [(np.zeros(3), 4.0)]
    todo = [(np.zeros(3), np.array([0.0, 0, 1]), 4.0, generations)]
    for start, way, radius, left in todo:
        stop, last = start + rng.uniform(6, 12) * radius * way, radius * rng.uniform(0.8, 1)
        pieces.append((start, stop, radius, last))
        if not left:
            ends.append((stop, last))
            continue
        across = np.cross(way, rng.normal(size=3))
        across /= np.linalg.norm(across)
        for side, low in ((1, 0.7), (-1, 0.45)):
            angle = side * np.deg2rad(rng.uniform(25, 60))
            branch = way * np.cos(angle) + across * np.sin(angle)
            width = last * rng.uniform(low, 0.95)
            todo.append((stop, branch / np.linalg.norm(branch), width, left - 1))
    return pieces, ends
