"""The middle of the lumen on which the user has clicked."""

import numpy as np
from vtkmodules.vtkCommonCore import mutable, vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkGenericCell, vtkStaticCellLocator

ROUNDS = 4
"""The line from the nearest wall through the last middle soon passes through the center of a round lumen."""

LONGER = 1.5
"""Ratio of a line through a later middle to the first one beyond which it goes along the vessel: the wall nearest to a middle close to the vessel's end is the end."""

BEYOND = 1e-4
"""A line begins so far behind the wall on which it begins, mm."""


def middleOn(polyData, surface, ray):
    """The middle (3,) of the first lumen that a `Ray` meets, across from where it meets the wall; None without one.

    `polyData` and `surface` (`Surface`) are the same vessel.
    """
    locator = vtkStaticCellLocator()
    locator.SetDataSet(polyData)
    locator.BuildLocator()
    center = np.array(polyData.GetCenter())
    reach = 2.0 * polyData.GetLength()
    hits, cells = vtkPoints(), vtkIdList()
    far = ray.origin + (np.linalg.norm(center - ray.origin) + reach) * ray.direction
    locator.IntersectWithLine(ray.origin, far, 0.0, hits, cells)
    if not cells.GetNumberOfIds():
        return None
    wall, normal = np.array(hits.GetPoint(0)), _normal(polyData.GetCell(cells.GetId(0)))
    ways = np.stack([normal, -normal])
    inward = ways[surface.contains(wall + BEYOND * ways)]
    hit = _opposite(locator, wall, inward[0], reach) if len(inward) == 1 else None
    if hit is None:
        return None
    middle, longest = (wall + hit) / 2, LONGER * np.linalg.norm(hit - wall)
    for _ in range(ROUNDS):
        wall, distance = _nearest(locator, middle)
        hit = _opposite(locator, wall, (middle - wall) / distance, reach)
        if hit is None or np.linalg.norm(hit - wall) > longest:
            break
        middle = (wall + hit) / 2
    return middle


def _normal(triangle):
    corners = np.array([triangle.GetPoints().GetPoint(index) for index in range(3)])
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return normal / np.linalg.norm(normal)


def _nearest(locator, point):
    """Nearest point of the wall, and its distance."""
    closest, cell = [0.0] * 3, vtkGenericCell()
    cellID, subID, square = mutable(0), mutable(0), mutable(0.0)
    locator.FindClosestPoint(point, closest, cell, cellID, subID, square)
    return np.array(closest), float(square) ** 0.5


def _opposite(locator, wall, direction, reach):
    """Place where a line from the wall meets it next, None without one."""
    hits, cells = vtkPoints(), vtkIdList()
    ends = (wall + BEYOND * direction, wall + reach * direction)
    locator.IntersectWithLine(*ends, 0.0, hits, cells)
    return np.array(hits.GetPoint(0)) if hits.GetNumberOfPoints() else None
