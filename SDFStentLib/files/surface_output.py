"""Surfaces into files: moved points are written, everything else is as it was read."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData

from ..cautions import Caution
from ..geometry import NamedFaces, Surface, dot, face_normals, used_points, vertex_normals
from ..surface_formats import WRITTEN_SUFFIXES
from ..units import Frame, millimeters_per
from ..validation import (
    Floats,
    InputError,
    Points,
    Triangles,
    as_path,
    as_points,
    check_is_a,
)
from .atomic import check_suffix, check_writable, write_bytes
from .content import header_text
from .formats import encode_legacy, encode_vtp
from .model_faces import ID_ARRAY, NAME_ARRAY, set_face_names
from .plain import encode_obj, encode_ply, encode_solids, encode_stl, fits_ply
from .polydata import (
    add_arrays,
    polydata_from_arrays,
    polygons_from_polydata,
    set_frame_of_polydata,
)
from .surface_files import VOXEL_ARRAY, SurfaceFile


class _Encoded(NamedTuple):
    data: bytes
    lost: list[str]  # names of arrays


def write_surface(
    path: str | os.PathLike[str],
    surface: SurfaceFile,
    points: ArrayLike,
    point_arrays: Mapping[str, ArrayLike] | None = None,
    cell_arrays: Mapping[str, ArrayLike] | None = None,
) -> tuple[Caution, ...]:
    """Write a surface with some of its points moved, whole or not at all.

    Unit, frame tag, data types, topology and every array are those of the file that was read;
    the coordinates of points that have not moved have the same bits. Normals are recomputed where
    the surface changed. VTP is written binary, appended and compressed, the others binary, OBJ as
    text; STL is always single precision, and ASCII where it was read with several
    solids, which it has again.

    Parameters
    ----------
    path : path
        File to write; the suffix sets the format: .vtp, .vtk, .stl, .ply or .obj.
    surface : SurfaceFile
    points : array_like, shape (n, 3)
        Current places of its points, mm.
    point_arrays, cell_arrays : mapping of name to array, optional
        Further arrays to write, replacing those of the same name. Cells that are no triangle of
        the surface, such as ghosts, get NaN, or 0.

    Returns
    -------
    tuple of Caution
        Contents that this format cannot keep.

    Raises
    ------
    InputError
        Unknown suffix, points or arrays that do not fit, or the file cannot be written.
    """
    check_is_a(surface, SurfaceFile, "surface")
    target = check_surface_output(path)
    polydata = _with_points(surface, points)
    add_arrays(polydata, point_arrays, _for_all_cells(surface.surface, cell_arrays))
    encoded = _encode(polydata, Path(path).suffix.lower(), surface)
    write_bytes(target, encoded.data)
    if not encoded.lost:
        return ()
    lost = {"format": Path(path).suffix, "arrays": ", ".join(encoded.lost)}
    return (Caution("arrays-not-kept", lost, label=f"{path}: "),)


def _for_all_cells(
    surface: Surface, arrays: Mapping[str, ArrayLike] | None
) -> dict[str, ArrayLike]:
    rows = {name: np.asarray(values) for name, values in (arrays or {}).items()}
    count = len(surface.triangles)
    return {
        name: surface.to_given(values) if values.shape[:1] == (count,) else values
        for name, values in rows.items()
    }


def _own_triangles(polydata: vtkPolyData) -> Triangles:
    """Triangles of the file, with seams as it has them."""
    return polygons_from_polydata(polydata).corners.reshape(-1, 3)


def check_surface_output(path: str | os.PathLike[str]) -> Path:
    """The file that `write_surface` would replace; `InputError` if it could not."""
    check_suffix(as_path(path), "a surface", WRITTEN_SUFFIXES)
    return check_writable(path)


def _with_points(surface: SurfaceFile, points: ArrayLike) -> vtkPolyData:
    """New polydata in the unit of the file, with points moved and normals recomputed."""
    after = as_points(points, "points")
    if len(after) != len(surface.points):
        raise InputError(
            f"points: expected the {len(surface.points)} of the surface, got {len(after)}."
        )
    moved = (after != surface.points).any(axis=1)
    polydata = surface.polydata()
    values = vtk_to_numpy(polydata.GetPoints().GetData())
    before = values.astype(np.float64)
    values[moved] = (after[moved] / millimeters_per(surface.units)).astype(values.dtype)
    polydata.GetPoints().GetData().Modified()
    refresh_normals(polydata, before, values.astype(np.float64), _own_triangles(polydata))
    return polydata


def _encode(polydata: vtkPolyData, suffix: str, surface: SurfaceFile) -> _Encoded:
    title = header_text(surface.frame)
    if suffix == ".vtp":
        set_frame_of_polydata(polydata, surface.frame)
        return _Encoded(encode_vtp(polydata), [])
    if suffix == ".vtk":
        return _Encoded(encode_legacy(polydata, title), [])

    points = vtk_to_numpy(polydata.GetPoints().GetData())
    triangles = _own_triangles(polydata)
    point_arrays, point_text = _arrays(polydata.GetPointData())
    cell_arrays, cell_text = _arrays(polydata.GetCellData())
    fields = polydata.GetFieldData()
    lost = [fields.GetArrayName(index) for index in range(fields.GetNumberOfArrays())]
    lost = point_text + cell_text + [name for name in lost if name != "SPACE"]
    if suffix == ".ply":
        lost += [
            key for key in point_arrays if not fits_ply(key, point_arrays[key], of_points=True)
        ]
        lost += [key for key in cell_arrays if not fits_ply(key, cell_arrays[key], of_points=False)]
        kept = [
            {key: values for key, values in arrays.items() if key not in lost}
            for arrays in (point_arrays, cell_arrays)
        ]
        return _Encoded(encode_ply(points, triangles, kept[0], kept[1], title), lost)
    lost += list(point_arrays) + list(cell_arrays)
    if suffix == ".obj":
        return _Encoded(encode_obj(points, triangles, title), lost)
    mesh = points, triangles
    return _encode_solids(*mesh, surface, cell_arrays, lost) or _encode_stl(
        *mesh, cell_arrays.get("Attribute"), lost, title
    )


def _encode_solids(
    points: Points,
    triangles: Triangles,
    surface: SurfaceFile,
    cell_arrays: dict[str, NDArray[Any]],
    lost: list[str],
) -> _Encoded | None:
    """STL with a solid for each face of the model, if it was read like that.

    Otherwise not: programs such as trimesh do not join parts that are in several solids.
    """
    faces, ids = surface.faces, cell_arrays.get(ID_ARRAY)
    if faces is None or ids is None or surface.path.suffix.lower() != ".stl":
        return None
    tag = f"SPACE={surface.frame}" if surface.frame else ""
    data = encode_solids(points, triangles, ids, faces.names, tag)
    return _Encoded(data, [name for name in lost if name not in (ID_ARRAY, NAME_ARRAY)])


def _encode_stl(
    points: Points,
    triangles: Triangles,
    attribute: NDArray[Any] | None,
    lost: list[str],
    title: str,
) -> _Encoded:
    if attribute is not None and attribute.dtype == np.uint16:
        lost = [name for name in lost if name != "Attribute"]
    else:
        attribute = None
    return _Encoded(encode_stl(points, triangles, attribute, title), lost)


def _arrays(data: vtkDataSetAttributes) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """The numeric arrays by name, and the names of the others."""
    numbers, others = {}, []
    for index in range(data.GetNumberOfArrays()):
        name = data.GetArrayName(index) or f"array {index}"
        array = data.GetArray(index)
        if array is None:
            others.append(name)
        else:
            numbers[name] = vtk_to_numpy(array)
    return numbers, others


_NAMES = ("normals", "normals_", "pointnormals", "cellnormals", "cell_normals", "point_normals")
_UNIT_LENGTH_TOLERANCE = 0.01  # of the usual length: normals may be stored with few digits


def refresh_normals(
    polydata: vtkPolyData, old_points: Points, new_points: Points, triangles: Triangles
) -> None:
    """Recompute, in place, the normals arrays of points and cells where the surface changed.

    Normals arrays are the active normals and three-component arrays of unit length that are
    called normals. Data type and side are those of the stored normals: a stored normal that
    pointed against the winding of its triangles still does. Rows that no moved triangle touches
    keep their bits; rows without a normal (no area around) keep what they had.

    Parameters
    ----------
    polydata : vtkPolyData
        Polydata whose arrays are modified. Cell i is triangle i.
    old_points, new_points : (n, 3) arrays
        Points before and after, in any one unit.
    triangles : (m, 3) array
    """
    point_normals = _normals_arrays(polydata.GetPointData())
    cell_normals = _normals_arrays(polydata.GetCellData())
    moved = (old_points != new_points).any(axis=1)
    if not (point_normals or cell_normals) or not moved.any():
        return
    changed = np.flatnonzero(moved[triangles].any(axis=1))
    if cell_normals and len(changed):
        before = face_normals(old_points, triangles[changed])
        after = face_normals(new_points, triangles[changed])
        for rows in cell_normals:
            _turn(rows, changed, before, after)
    if point_normals and len(changed):
        touched = used_points(triangles[changed])
        is_touched = np.zeros(len(old_points), dtype=bool)
        is_touched[touched] = True
        around = triangles[is_touched[triangles].any(axis=1)]
        before = vertex_normals(old_points, around)[touched]
        after = vertex_normals(new_points, around)[touched]
        for rows in point_normals:
            _turn(rows, touched, before, after)


def _normals_arrays(data: vtkDataSetAttributes) -> list[NDArray[Any]]:
    """Arrays that hold normals, as views on them."""
    active = data.GetNormals()
    found = []
    for index in range(data.GetNumberOfArrays()):
        array = data.GetArray(index)  # None for text
        if array is None or array.GetNumberOfComponents() != 3 or not array.GetNumberOfTuples():
            continue
        rows = vtk_to_numpy(array)
        if rows.dtype.kind != "f":
            continue
        is_named = (array.GetName() or "").lower() in _NAMES and _has_unit_length(rows)
        if is_named or (active is not None and array.GetName() == active.GetName()):
            found.append(rows)
    return found


def _has_unit_length(rows: NDArray[Any]) -> bool:
    usual = np.median(np.linalg.norm(rows.astype(np.float64), axis=1))
    return bool(abs(usual - 1) < _UNIT_LENGTH_TOLERANCE)


def _turn(rows: NDArray[Any], indices: NDArray[np.int64], before: Points, after: Points) -> None:
    stored = rows[indices].astype(np.float64)
    side = np.where(dot(stored, before) < 0, -1.0, 1.0)
    has_normal = after.any(axis=1)
    rows[indices[has_normal]] = (side[:, None] * after)[has_normal]


def write_new_surface(
    path: str | os.PathLike[str],
    surface: Surface,
    faces: NamedFaces,
    frame: Frame | None,
    voxels: Floats,
) -> None:
    """Write a surface of voxels as VTP, in mm, whole or not at all.

    Parameters
    ----------
    path : path
    surface : Surface
        mm.
    faces : NamedFaces
        `ModelFaceID` of its triangles, and the names.
    frame : "RAS", "LPS" or None
        Patient frame of its points.
    voxels : (3,) array
        Their sizes, mm: they say how exact the surface is.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    ids = {ID_ARRAY: faces.ids.astype(np.int32)}
    polydata = polydata_from_arrays(surface.points, surface.triangles, None, ids)
    set_face_names(polydata, faces.names)
    array = numpy_to_vtk(np.asarray(voxels, dtype=np.float64), deep=True)
    array.SetName(VOXEL_ARRAY)
    polydata.GetFieldData().AddArray(array)
    set_frame_of_polydata(polydata, frame)
    write_bytes(check_writable(path), encode_vtp(polydata))
