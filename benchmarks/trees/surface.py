"""The wall of a tree as a triangle surface: the union of its spheres on a grid, with its ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import vtk
from scipy.spatial import cKDTree
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

from .layout import VesselTree

ENDS = ("round", "capped", "open")

_BAND = 3.0
"""Distance from the wall, in steps of the grid, within which the field is computed."""

_TAIL = 2.5
"""Length by which a vessel goes on beyond a flat end before it is cut, over the end's radius."""


class Wall(NamedTuple):
    """Points (n, 3), mm, triangles (m, 3) and face ids (m,): 1 for wall, 2 for inlet, then ends."""

    points: np.ndarray
    triangles: np.ndarray
    faces: np.ndarray


def wall_of(tree: VesselTree, step: float, ends: str) -> Wall:
    """The wall of a tree; `step` of the grid, mm, is about the length of its edges."""
    whole = tree if ends == "round" else _with_tails(tree)
    points, triangles = _marched(*_field(whole, step), step)
    points, triangles = _largest_part(points, triangles)
    if ends == "round":
        return Wall(points, triangles, np.ones(len(triangles), dtype=int))
    return _cut(tree, points, triangles, step, is_capped=ends == "capped")


def wall_near(tree: VesselTree, step: float, places: np.ndarray, margin: float = 12.0) -> Wall:
    """The part of the wall in a box round places (n, 3); it ends where the box does."""
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    points, triangles = _marched(*_field(tree, step, (low, high)), step)
    return Wall(points, triangles, np.ones(len(triangles), dtype=int))


def _with_tails(tree: VesselTree) -> VesselTree:
    """The tree with every end continued straight."""
    ends = [0, *tree.leaves]
    points = [tree.points]
    for end in ends:
        place, way = _end_plane(tree, end)
        points.append(place + np.outer([0.5, 1.0], way) * _TAIL * tree.radius[end])
    added = len(tree.points) + 2 * np.arange(len(ends))
    parent = np.stack([ends, added], axis=1).ravel()
    return VesselTree(
        np.vstack(points), np.r_[tree.radius, np.repeat(tree.radius[ends], 2)],
        np.r_[tree.parent, parent],
    )  # fmt: skip


def _end_plane(tree: VesselTree, end: int) -> tuple[np.ndarray, np.ndarray]:
    """A point of an end's plane and the direction (3,) out of the vessel."""
    inner = end
    while np.linalg.norm(tree.points[inner] - tree.points[end]) < tree.radius[end]:
        before = tree.children[inner][:1] if end == 0 else [int(tree.parent[inner])]
        if not before or before[0] < 0:
            break
        inner = before[0]
    way = tree.points[end] - tree.points[inner]
    return tree.points[end], way / np.linalg.norm(way)


def _field(
    tree: VesselTree, step: float, box: tuple[np.ndarray, np.ndarray] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the union of cones round the tree's edges on a grid (x, y, z), and its origin."""
    reach = (tree.radius + _BAND * step)[:, None]
    low, high = box or ((tree.points - reach).min(axis=0), (tree.points + reach).max(axis=0))
    low = low - 2 * step
    shape = np.ceil((high - low) / step).astype(int) + 3
    field = np.full(shape, _BAND * step, dtype=np.float32)
    for child in range(1, len(tree.points)):
        _carve(field, low, step, tree, int(tree.parent[child]), child)
    return field, low


def _carve(
    field: np.ndarray, low: np.ndarray, step: float, tree: VesselTree, first: int, last: int
) -> None:
    start, along = tree.points[first], tree.points[last] - tree.points[first]
    wide, wider = tree.radius[first], tree.radius[last] - tree.radius[first]
    reach = max(wide, wide + wider) + _BAND * step
    ends = np.stack([start, start + along])
    begin = np.floor((ends.min(axis=0) - reach - low) / step).astype(int).clip(0)
    stop = np.ceil((ends.max(axis=0) + reach - low) / step).astype(int) + 1
    stop = np.minimum(stop, field.shape)
    if (stop <= begin).any():
        return
    x, y, z = (
        (low[k] + step * np.arange(begin[k], stop[k]) - start[k]).astype(np.float32)
        for k in range(3)
    )
    x, y, z = x[:, None, None], y[None, :, None], z[None, None, :]
    square = float(along @ along)
    share = (x * along[0] + y * along[1] + z * along[2]) * np.float32(1 / max(square, 1e-12))
    np.clip(share, 0, 1, out=share)
    away = (x - share * along[0]) ** 2 + (y - share * along[1]) ** 2 + (z - share * along[2]) ** 2
    np.sqrt(away, out=away)
    away -= wide + share * wider
    part = field[tuple(slice(b, s) for b, s in zip(begin, stop, strict=True))]
    np.minimum(part, away, out=part)


def _marched(field: np.ndarray, low: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """The surface by marching cubes, smoothed so that no edge of the union and no
    sliver is left."""
    # A grid point exactly on the wall would make triangles without area.
    field[np.abs(field) < 0.02 * step] = 0.02 * step
    image = vtk.vtkImageData()
    image.SetDimensions(*field.shape)
    image.SetSpacing(step, step, step)
    image.SetOrigin(*low)
    values = numpy_to_vtk(field.ravel(order="F"))
    image.GetPointData().SetScalars(values)
    march = vtk.vtkFlyingEdges3D()
    march.SetInputData(image)
    march.SetValue(0, 0.0)
    march.ComputeNormalsOff()
    march.ComputeScalarsOff()
    smooth = vtk.vtkWindowedSincPolyDataFilter()
    smooth.SetInputConnection(march.GetOutputPort())
    smooth.SetNumberOfIterations(20)
    smooth.SetPassBand(0.1)
    smooth.NormalizeCoordinatesOn()
    smooth.Update()
    points, triangles = _arrays(smooth.GetOutput())
    # Values inside are below the level, which marching cubes take for outside.
    return points, triangles[:, ::-1].copy()


def _arrays(data: vtk.vtkPolyData) -> tuple[np.ndarray, np.ndarray]:
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    return points, vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).copy()


def _largest_part(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = np.vstack([triangles[:, :2], triangles[:, 1:]])
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2)
    _, label = connected_components(links, directed=False)
    keep = label[triangles[:, 0]] == np.bincount(label[triangles[:, 0]]).argmax()
    used, numbers = np.unique(triangles[keep], return_inverse=True)
    return points[used], numbers.reshape(-1, 3)


def _cut(
    tree: VesselTree, points: np.ndarray, triangles: np.ndarray, step: float, is_capped: bool
) -> Wall:
    """The wall without its tails; the ends are flat."""
    ends = [0, *tree.leaves]
    planes = [_end_plane(tree, end) for end in ends]
    beyond = np.full(len(points), -1.0)
    near_trunk, _ = cKDTree(tree.points).query(points)
    places, near = points.copy(), cKDTree(points)
    for end, (place, way) in zip(ends, planes, strict=True):
        about = np.array(near.query_ball_point(place, (_TAIL + 1.5) * tree.radius[end]), dtype=int)
        height = (points[about] - place) @ way
        aside = np.linalg.norm(points[about] - place - np.outer(height, way), axis=1)
        # A neighbor that passes by is nearer to its own line than to the tail's.
        is_tail = (aside < 1.4 * tree.radius[end]) & (height > -tree.radius[end])
        is_tail &= (aside <= near_trunk[about] + 1e-9) | (height < 0)
        flat = np.where(np.abs(height) < 0.2 * step, 0.0, height)
        places[about[is_tail]] += np.outer((flat - height)[is_tail], way)
        beyond[about[is_tail]] = np.maximum(beyond[about], flat)[is_tail]
    points = places
    return _closed(*_clipped(points, triangles, beyond), planes, is_capped)


def _clipped(
    points: np.ndarray, triangles: np.ndarray, beyond: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a surface where a value (n,) at its points is not above 0."""
    data = vtk.vtkPolyData()
    made = vtk.vtkPoints()
    made.SetDataTypeToDouble()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    data.SetPoints(made)
    cells = vtk.vtkCellArray()
    offsets = numpy_to_vtkIdTypeArray(np.arange(0, 3 * len(triangles) + 1, 3), deep=True)
    cells.SetData(offsets, numpy_to_vtkIdTypeArray(triangles.ravel().astype(np.int64), deep=True))
    data.SetPolys(cells)
    data.GetPointData().SetScalars(numpy_to_vtk(beyond, deep=True))
    clip = vtk.vtkClipPolyData()
    clip.SetInputData(data)
    clip.InsideOutOn()
    clip.SetValue(1e-9)
    clip.SetOutputPointsPrecision(1)
    clip.Update()
    whole = vtk.vtkTriangleFilter()
    whole.SetInputConnection(clip.GetOutputPort())
    clean = vtk.vtkCleanPolyData()
    clean.SetInputConnection(whole.GetOutputPort())
    clean.ToleranceIsAbsoluteOn()
    clean.SetAbsoluteTolerance(1e-6)
    clean.ConvertPolysToLinesOff()
    clean.Update()
    points, triangles = _arrays(clean.GetOutput())
    is_whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return _largest_part(points, triangles[is_whole])


def _closed(
    points: np.ndarray,
    triangles: np.ndarray,
    planes: list[tuple[np.ndarray, np.ndarray]],
    is_capped: bool,
) -> Wall:
    rims = rims_of(triangles)
    if len(rims) != len(planes):
        raise ValueError(f"{len(planes)} ends were cut, and {len(rims)} rims came out")
    if not is_capped:
        return Wall(points, triangles, np.ones(len(triangles), dtype=int))
    places = np.array([place for place, _ in planes])
    caps, centers, faces = [triangles], [points], [np.ones(len(triangles), dtype=int)]
    for number, rim in enumerate(rims):
        center = points[rim].mean(axis=0)
        centers.append(center[None])
        middle = np.full(len(rim), len(points) + number)
        caps.append(np.stack([np.roll(rim, -1), rim, middle], axis=1))
        face = 2 + int(np.argmin(np.linalg.norm(places - center, axis=1)))
        faces.append(np.full(len(rim), face))
    return Wall(np.vstack(centers), np.vstack(caps), np.concatenate(faces))


def rims_of(triangles: np.ndarray) -> list[np.ndarray]:
    """Numbers of points around every hole, in the direction of the triangles beside it.

    Raises
    ------
    ValueError
        Two rims meet in a point.
    """
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    key = np.sort(edges, axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    open_sides = edges[first[count == 1]]
    after = dict(open_sides.tolist())
    if len(after) < len(open_sides):
        raise ValueError("two rims meet in a point")
    rims = []
    while after:
        start, one = after.popitem()
        rim = [start]
        while one != start:
            rim.append(one)
            one = after.pop(one)
        rims.append(np.array(rim))
    return rims
