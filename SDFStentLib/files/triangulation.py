"""Polygons and strips of polydata cut into triangles, with every array carried along."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkPolygon

from ..cautions import Caution
from ..geometry import dot
from ..validation import InputError, Points, Triangles
from .polydata import cell_array, cells_from_array, points_from_polydata, polygons_from_polydata

MOST_CORNERS = 1000
"""Most corners of a polygon: caps of vessels have some hundred at most. The thin triangles of a
polygon all lie beside each other, so that the work of checking them grows with the square of their
number."""


class Triangulated(NamedTuple):
    """Polydata of nothing but triangles, and cautions about the changes made."""

    polydata: vtkPolyData
    warnings: tuple[Caution, ...]


def triangulated_polydata(polydata: vtkPolyData, name: str = "surface") -> Triangulated:
    """The surface with its polygons and strips cut into triangles.

    Vertices and lines are dropped, points without a cell stay. Every array is kept: the value of a
    polygon goes to each of its triangles. Polydata that has only triangles is returned as it is.

    Parameters
    ----------
    polydata : vtkPolyData
        Polydata; it is not modified.
    name : str
        Name of the polydata in messages.

    Raises
    ------
    InputError
        No polygon at all, one with more than `MOST_CORNERS`, or an index without a point.
    """
    warnings = []
    sizes = np.diff(polygons_from_polydata(polydata, name).offsets)
    strips = cells_from_array(polydata.GetStrips(), polydata.GetNumberOfPoints(), name)
    others = polydata.GetNumberOfVerts() + polydata.GetNumberOfLines()
    if len(sizes) + len(strips.offsets) - 1 == 0:
        raise InputError(f"{name}: expected a surface of triangles, got none; save the surface.")
    if (sizes == 3).all() and others == 0 and polydata.GetNumberOfStrips() == 0:
        return Triangulated(polydata, ())

    if sizes.max(initial=0) > MOST_CORNERS:
        raise InputError(
            f"{name}: expected polygons of at most {MOST_CORNERS:,} corners, got one of "
            f"{sizes.max():,}; cut it into triangles in the program that made it."
        )
    result = _cut_into_triangles(polydata, name)
    polygons = int((sizes != 3).sum()) + polydata.GetNumberOfStrips()
    if polygons:
        counts = {"polygons": polygons, "triangles": result.GetNumberOfCells()}
        warnings.append(Caution("polygons-cut", counts, label=f"{name}: "))
    if others:
        warnings.append(Caution("cells-dropped", {"cells": others}, label=f"{name}: "))
    return Triangulated(result, tuple(warnings))


def _cut_into_triangles(polydata: vtkPolyData, name: str) -> vtkPolyData:
    polygons, source = _cut_polygons(polydata, name)
    first_polygon = polydata.GetNumberOfVerts() + polydata.GetNumberOfLines()
    strips, strip_of = _cut_strips(polydata)
    first_strip = first_polygon + polydata.GetNumberOfPolys()
    triangles = np.concatenate([polygons, strips])
    source = np.concatenate([source + first_polygon, strip_of + first_strip])

    result = vtkPolyData()
    result.SetPoints(polydata.GetPoints())
    result.SetPolys(cell_array(3 * np.arange(len(triangles) + 1), triangles.ravel()))
    result.GetPointData().ShallowCopy(polydata.GetPointData())
    result.GetFieldData().ShallowCopy(polydata.GetFieldData())
    data = result.GetCellData()
    data.CopyAllOn()  # ids as well, which VTK leaves out by default
    data.CopyAllocate(polydata.GetCellData(), len(source))
    data.CopyData(polydata.GetCellData(), _id_list(source), _id_list(np.arange(len(source))))
    return result


def _cut_polygons(polydata: vtkPolyData, name: str) -> tuple[Triangles, NDArray[np.int64]]:
    """Triangles of the polygons, concave ones too, and the polygon of each.

    VTK's filter is not used: that of 9.6 mixes up cell data where it drops cells.
    """
    points = points_from_polydata(polydata, name)
    offsets, corners = polygons_from_polydata(polydata)
    sizes = np.diff(offsets)
    three, four = np.flatnonzero(sizes == 3), np.flatnonzero(sizes == 4)
    triangles = [corners[offsets[three, None] + np.arange(3)]]
    triangles.append(_cut_quads(points, corners[offsets[four, None] + np.arange(4)]))
    source = [three, np.repeat(four, 2)]
    for number in np.flatnonzero(sizes > 4):
        cut = _cut_polygon(points, corners[offsets[number] : offsets[number + 1]])
        triangles.append(cut)
        source.append(np.full(len(cut), number))
    order = np.argsort(np.concatenate(source), kind="stable")
    return np.concatenate(triangles)[order], np.concatenate(source)[order]


def _cut_quads(points: Points, quads: NDArray[np.int64]) -> Triangles:
    """Two triangles for each quad, along the shorter diagonal that lies inside of it."""
    halves = [quads[:, [0, 1, 2, 0, 2, 3]], quads[:, [0, 1, 3, 1, 2, 3]]]
    is_inside, length = [], []
    for half, (start, end) in zip(halves, ((0, 2), (1, 3)), strict=True):
        first, second = (_area_vectors(points, half[:, part]) for part in (slice(3), slice(3, 6)))
        is_inside.append(dot(first, second) > 0)
        length.append(np.linalg.norm(points[quads[:, end]] - points[quads[:, start]], axis=1))
    is_second = np.where(is_inside[0] == is_inside[1], length[1] < length[0], is_inside[1])
    return np.where(is_second[:, None], halves[1], halves[0]).reshape(-1, 3)


def _area_vectors(points: Points, triangles: Triangles) -> Points:
    a, b, c = points[triangles].swapaxes(0, 1)
    return np.cross(b - a, c - a)


def _cut_polygon(points: Points, corners: NDArray[np.int64]) -> Triangles:
    polygon, found = vtkPolygon(), vtkIdList()
    for corner in corners.tolist():
        polygon.GetPointIds().InsertNextId(corner)
        polygon.GetPoints().InsertNextPoint(points[corner].tolist())
    if polygon.EarCutTriangulation(found) and found.GetNumberOfIds() == 3 * (len(corners) - 2):
        ids = [found.GetId(position) for position in range(found.GetNumberOfIds())]
        return corners[np.array(ids, dtype=np.int64)].reshape(-1, 3)
    # This is no plane polygon without crossings: a fan at least keeps the surface closed.
    first = np.full(len(corners) - 2, corners[0])
    return np.stack([first, corners[1:-1], corners[2:]], axis=1)


def _cut_strips(polydata: vtkPolyData) -> tuple[Triangles, NDArray[np.int64]]:
    """Triangles of the strips, every second one turned, and the strip of each."""
    cells = cells_from_array(polydata.GetStrips(), polydata.GetNumberOfPoints(), "strips")
    triangles, source = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for number, start in enumerate(cells.offsets[:-1]):
        strip = cells.corners[start : cells.offsets[number + 1]]
        faces = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
        faces[1::2] = faces[1::2, [1, 0, 2]]
        triangles.append(faces)
        source.append(np.full(len(faces), number))
    return np.concatenate(triangles), np.concatenate(source)


def _id_list(values: NDArray[np.integer]) -> vtkIdList:
    ids = vtkIdList()
    ids.SetNumberOfIds(len(values))
    for position, value in enumerate(values.tolist()):
        ids.SetId(position, value)
    return ids
