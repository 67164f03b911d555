"""Surfaces into files: what moved is written, everything else is what was read."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataSetAttributes, vtkPolyData

from ..cautions import Caution
from ..units import millimeters_per
from ..validation import InputError, as_path, as_points, check_is_a
from .atomic import check_suffix, check_writable, write_bytes
from .content import header_text
from .formats import encode_legacy, encode_obj, encode_ply, encode_stl, encode_vtp, fits_ply
from .normal_arrays import refresh_normals
from .polydata import add_arrays, set_frame_of_polydata
from .surface_files import SURFACE_SUFFIXES, SurfaceFile


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
    text; STL is always single precision.

    Parameters
    ----------
    path : path
        The suffix says the format: .vtp, .vtk, .stl, .ply or .obj.
    surface : SurfaceFile
    points : array_like, shape (n, 3)
        Where its points are now, mm.
    point_arrays, cell_arrays : mapping of name to array, optional
        More arrays to write, replacing those of the same name.

    Returns
    -------
    tuple of Caution
        What this format cannot keep.

    Raises
    ------
    InputError
        Unknown suffix, points or arrays that do not fit, or the file cannot be written.
    """
    check_is_a(surface, SurfaceFile, "surface")
    target = check_surface_output(path)
    polydata = _with_points(surface, points)
    add_arrays(polydata, point_arrays, cell_arrays)
    encoded = _encode(polydata, Path(path).suffix.lower(), surface)
    write_bytes(target, encoded.data)
    if not encoded.lost:
        return ()
    lost = {"format": Path(path).suffix, "arrays": ", ".join(encoded.lost)}
    return (Caution("arrays-not-kept", lost, label=f"{path}: "),)


def check_surface_output(path: str | os.PathLike[str]) -> Path:
    """The file that `write_surface` would replace; `InputError` early where it could not."""
    check_suffix(as_path(path), "a surface", SURFACE_SUFFIXES)
    return check_writable(path)


def _with_points(surface: SurfaceFile, points: ArrayLike) -> vtkPolyData:
    """New polydata in the unit of the file: the surface with points moved, normals recomputed."""
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
    refresh_normals(polydata, before, values.astype(np.float64), surface.triangles)
    return polydata


def _encode(polydata: vtkPolyData, suffix: str, surface: SurfaceFile) -> _Encoded:
    title = header_text(surface.frame)
    if suffix == ".vtp":
        set_frame_of_polydata(polydata, surface.frame)
        return _Encoded(encode_vtp(polydata), [])
    if suffix == ".vtk":
        return _Encoded(encode_legacy(polydata, title), [])

    points = vtk_to_numpy(polydata.GetPoints().GetData())
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
        return _Encoded(encode_ply(points, surface.triangles, kept[0], kept[1], title), lost)
    lost += list(point_arrays) + list(cell_arrays)
    if suffix == ".obj":
        return _Encoded(encode_obj(points, surface.triangles, title), lost)
    attribute = cell_arrays.get("Attribute")
    if attribute is not None and attribute.dtype == np.uint16:
        lost.remove("Attribute")
    else:
        attribute = None
    return _Encoded(encode_stl(points, surface.triangles, attribute, title), lost)


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
