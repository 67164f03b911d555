"""VTK polydata to arrays and back, in memory; units, frames and files are left to others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPointSet, vtkPolyData

from ..geometry import Surface
from ..units import Frame, as_frame
from ..validation import InputError, Points, as_patient_points, as_points, as_triangles
from .composition import lumen_alone
from .ghosts import ghosts_of_polydata

RADIUS_ARRAYS = ("MaximumInscribedSphereRadius", "Radius")
"""Point arrays of centerlines that hold the inscribed radius: VMTK's name, then SlicerVMTK's."""

_SPACE = "SPACE"  # the field array by which Slicer marks the frame of a VTP file


class Cells(NamedTuple):
    """Cells of any size: cell i has the points `corners[offsets[i]:offsets[i + 1]]`."""

    offsets: NDArray[np.int64]
    corners: NDArray[np.int64]


def points_from_polydata(polydata: vtkPolyData, name: str = "polydata") -> Points:
    """Coordinates (n, 3) as a float64 copy; `InputError` for NaN or infinity."""
    return as_patient_points(_coordinates(polydata), name)


def surface_from_polydata(
    polydata: vtkPolyData, name: str = "surface", scale: float = 1.0
) -> Surface:
    """The surface of polydata that has nothing but triangles.

    Parameters
    ----------
    polydata : vtkPolyData
        Polydata, not modified; see `triangulated_polydata` for one with other cells.
    name : str
        Name of the surface in messages.
    scale : float
        mm per unit of the polydata.

    Returns
    -------
    Surface
        A copy made of the cells of the polydata, without ghosts and outer sides of walls; see its
        `cells`.

    Raises
    ------
    InputError
        Cells other than triangles, only ghosts, an index without a point, NaN or infinity.
    """
    cells = polygons_from_polydata(polydata, name)
    count = len(cells.offsets) - 1
    if count != polydata.GetNumberOfCells() or len(cells.corners) != 3 * count:
        raise InputError(f"{name}: expected nothing but triangles; triangulate it first.")
    if not count:
        raise InputError(f"{name}: expected at least one triangle, got none.")
    points = _coordinates(polydata)
    with np.errstate(invalid="ignore"):
        points *= scale
    triangles = cells.corners.reshape(-1, 3)
    is_ghost = ghosts_of_polydata(polydata, triangles)
    if is_ghost is not None and is_ghost.all():
        raise InputError(
            f"{name}: expected at least one triangle, got {count} ghost cells and nothing else; "
            "save the surface without ghosts, or the piece that it is of."
        )
    return lumen_alone(Surface(points, triangles, name, is_ghost))


def _coordinates(polydata: vtkPolyData) -> Points:
    if polydata.GetNumberOfPoints() == 0:
        return np.zeros((0, 3))
    with np.errstate(invalid="ignore"):  # a signaling NaN; who asks for points checks them
        return np.array(vtk_to_numpy(polydata.GetPoints().GetData()), dtype=np.float64)


def polygons_from_polydata(polydata: vtkPolyData, name: str = "surface") -> Cells:
    """The polygons as offsets and corners; `InputError` if they do not fit together."""
    return cells_from_array(polydata.GetPolys(), polydata.GetNumberOfPoints(), name)


def lines_from_polydata(
    polydata: vtkPolyData, name: str = "centerline"
) -> tuple[Points, tuple[NDArray[np.int64], ...]]:
    """Points (n, 3) and the lines, each as point indices in the order of its cell.

    The order of the stored points has no meaning: SlicerVMTK stores them against the direction of
    the line. Cells other than lines are left out.

    Raises
    ------
    InputError
        An index without a point, NaN or infinity.
    """
    cells = cells_from_array(polydata.GetLines(), polydata.GetNumberOfPoints(), name)
    lines = np.split(cells.corners, cells.offsets[1:-1]) if len(cells.offsets) > 1 else []
    return points_from_polydata(polydata, name), tuple(lines)


def inscribed_radius_from_polydata(polydata: vtkPolyData) -> NDArray[np.float64] | None:
    """Inscribed radius (n,) of a centerline's points in its own unit; `None` if it has no array.

    It is NaN where the array holds no positive number.
    """
    for array_name in RADIUS_ARRAYS:
        array = polydata.GetPointData().GetArray(array_name)
        if array is not None and array.GetNumberOfComponents() == 1:
            radius = np.array(vtk_to_numpy(array), dtype=np.float64)
            with np.errstate(invalid="ignore"):
                return np.where(np.isfinite(radius) & (radius > 0), radius, np.nan)
    return None


def polydata_from_arrays(
    points: ArrayLike,
    triangles: ArrayLike,
    point_arrays: Mapping[str, ArrayLike] | None = None,
    cell_arrays: Mapping[str, ArrayLike] | None = None,
) -> vtkPolyData:
    """New polydata of triangles; everything is copied.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        float32 stays float32, everything else becomes float64.
    triangles : array_like, shape (m, 3)
    point_arrays, cell_arrays : mapping of name to array, shapes (n,), (n, k) and (m,), (m, k)
        Numbers keep their type, booleans become uint8, text becomes a string array.

    Raises
    ------
    InputError
        Points, triangles or arrays that do not fit together.
    """
    points = _float_points(points)
    corners = as_triangles(triangles, len(points))
    polydata = polydata_from_polygons(points, 3 * np.arange(len(corners) + 1), corners.ravel())
    add_arrays(polydata, point_arrays, cell_arrays)
    return polydata


def polydata_from_polygons(
    points: NDArray[Any], offsets: NDArray[np.int64], corners: NDArray[np.int64]
) -> vtkPolyData:
    """New polydata of polygons; points keep their precision, indices are not checked."""
    polydata = _polydata_of(points)
    polydata.SetPolys(cell_array(offsets, corners))
    return polydata


def polydata_from_lines(points: ArrayLike, lines: list[ArrayLike]) -> vtkPolyData:
    """New polydata of poly-lines, each given as point indices in its order."""
    polydata = _polydata_of(_float_points(points))
    indices = [np.asarray(line, dtype=np.int64) for line in lines]
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in indices])])
    polydata.SetLines(cell_array(offsets, np.concatenate(indices)))
    return polydata


def add_arrays(
    data_set: vtkPointSet,
    point_arrays: Mapping[str, ArrayLike] | None,
    cell_arrays: Mapping[str, ArrayLike] | None,
) -> None:
    """Add copies of arrays in place, replacing those of the same name; `InputError` if unfit."""
    targets = (
        ("point", data_set.GetPointData(), data_set.GetNumberOfPoints(), point_arrays),
        ("cell", data_set.GetCellData(), data_set.GetNumberOfCells(), cell_arrays),
    )
    for kind, data, count, arrays in targets:
        for array_name, values in (arrays or {}).items():
            values = np.asarray(values)
            if values.ndim not in (1, 2) or len(values) != count:
                raise InputError(
                    f"{kind} array {array_name}: expected {count} rows, got {values.shape}."
                )
            data.AddArray(_vtk_array(values, array_name))


def frame_of_polydata(polydata: vtkPolyData) -> Frame | None:
    """The frame that the field array `SPACE` names, as Slicer writes it, or `None`."""
    array = polydata.GetFieldData().GetAbstractArray(_SPACE)
    if not isinstance(array, vtkStringArray) or array.GetNumberOfValues() == 0:
        return None
    return as_frame(array.GetValue(0))


def set_frame_of_polydata(polydata: vtkPolyData, frame: Frame | None) -> None:
    """Set the field array `SPACE` in place, or remove it."""
    polydata.GetFieldData().RemoveArray(_SPACE)
    if frame:
        array = vtkStringArray()
        array.SetName(_SPACE)
        array.InsertNextValue(frame)
        polydata.GetFieldData().AddArray(array)


def cells_from_array(array: vtkCellArray | None, point_count: int, name: str) -> Cells:
    """Cells as copied offsets and corners; `InputError` if they do not fit together."""
    if array is None or array.GetNumberOfCells() == 0:
        return Cells(np.zeros(1, np.int64), np.zeros(0, np.int64))
    # The copy, because newer VTK keeps cells of one size without an array of offsets.
    plain = vtkCellArray()
    plain.DeepCopy(array)
    plain.ConvertTo64BitStorage()
    offsets = np.array(vtk_to_numpy(plain.GetOffsetsArray()), dtype=np.int64)
    corners = np.array(vtk_to_numpy(plain.GetConnectivityArray()), dtype=np.int64)
    if offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets) < 0).any():
        raise InputError(f"{name}: its cells do not fit together; the file is damaged.")
    if len(corners) and (corners.min() < 0 or corners.max() >= point_count):
        raise InputError(
            f"{name}: expected point indices from 0 to {point_count - 1} in its cells, got "
            f"{corners.min()} to {corners.max()}; the file is damaged."
        )
    return Cells(offsets, corners)


def _polydata_of(points: NDArray[Any]) -> vtkPolyData:
    coordinates = vtkPoints()
    coordinates.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    polydata = vtkPolyData()
    polydata.SetPoints(coordinates)
    return polydata


def _float_points(points: ArrayLike) -> NDArray[Any]:
    single = getattr(points, "dtype", None) == np.float32
    return as_points(points).astype(np.float32 if single else np.float64)


def cell_array(offsets: NDArray[np.int64], corners: NDArray[np.int64]) -> vtkCellArray:
    """VTK cells from offsets and corners, copied and not checked; see `Cells`."""
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtk(np.ascontiguousarray(offsets, np.int64), deep=True, array_type=VTK_ID_TYPE),
        numpy_to_vtk(np.ascontiguousarray(corners, np.int64), deep=True, array_type=VTK_ID_TYPE),
    )
    return cells


def _vtk_array(values: NDArray[Any], name: str) -> Any:
    if values.dtype.kind in "US":
        array = vtkStringArray()
        array.SetNumberOfComponents(1 if values.ndim == 1 else values.shape[1])
        for value in values.ravel().tolist():
            array.InsertNextValue(value)
    elif values.dtype.kind in "biuf":
        kind = np.uint8 if values.dtype.kind == "b" else values.dtype
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=kind), deep=True)
    else:
        raise InputError(f"array {name}: expected numbers or text, got {values.dtype}.")
    array.SetName(name)
    return array
