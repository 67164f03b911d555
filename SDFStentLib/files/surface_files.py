"""Surfaces from files, with everything else that the files hold."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..cautions import Caution
from ..geometry import NO_HEIGHT, NamedFaces, Precision, Surface, dot, in_blocks
from ..surface_formats import READ_SUFFIXES
from ..units import Frame, millimeters_per
from ..validation import Floats, InputError, Points, Triangles, as_points
from .composition import composition_warnings
from .content import FileContent, frame_in_text
from .formats import read_vtk_polydata
from .model_faces import ID_ARRAY, faces_of_polydata, names_beside, set_face_names
from .parallel import read_with_pieces
from .plain import Decoder, decode_obj, decode_off, decode_ply, decode_stl
from .polydata import add_arrays, polydata_from_polygons, surface_from_polydata
from .recognized import HEAD, recognized
from .same_space import size_warnings
from .triangulation import triangulated_polydata

VOXEL_ARRAY = "VoxelSpacing"
"""Field array of a surface that was made of voxels: their sizes along three axes, in its unit."""

_PLAIN_DECODERS: dict[str, Decoder] = {
    ".stl": decode_stl,
    ".ply": decode_ply,
    ".obj": decode_obj,
    ".off": decode_off,
}


def half_voxel(sides: ArrayLike) -> float | None:
    """Half the side of a cube as large as a voxel of three sides, in their unit.

    None for another number of sides, or for a voxel without size.
    """
    found = np.asarray(sides, dtype=float).ravel()
    volume = float(np.prod(found))
    return volume ** (1 / 3) / 2 if len(found) == 3 and volume > 0 else None


@dataclass(frozen=True)
class SurfaceFile:
    """A surface as its file has it.

    Attributes
    ----------
    surface : Surface
        The surface in mm and in the frame of the file.
    units : str
        Unit of the file, `"mm"`, `"cm"` or `"m"`, in which it is written again.
    frame : "RAS", "LPS" or None
        Frame that the file's SPACE tag names; `None` without one.
    path : Path
    sha256 : str
        Hash of the file's bytes, hexadecimal.
    coordinate_type : numpy dtype
        Precision of the coordinates in the file, float32 or float64.
    warnings : tuple of Caution
        Changes that were made in reading, and what looks wrong.
    face_names : mapping of int to str
        Names from the SimVascular model (.mdl) of the same name beside the file.
    """

    surface: Surface
    units: str
    frame: Frame | None
    path: Path
    sha256: str
    coordinate_type: np.dtype[Any]
    warnings: tuple[Caution, ...]
    _polydata: vtkPolyData = field(repr=False, compare=False)
    face_names: Mapping[int, str] = field(default_factory=dict)

    @property
    def points(self) -> Points:
        """Points (n, 3) of the surface, mm."""
        return self.surface.points

    @property
    def triangles(self) -> Triangles:
        """Triangles (m, 3) of the surface."""
        return self.surface.triangles

    @property
    def precision(self) -> Precision:
        """Type and unit of the coordinates in the file."""
        return Precision(self.coordinate_type, 1 / millimeters_per(self.units))

    @property
    def faces(self) -> NamedFaces | None:
        """The parts of the model, if the file names them."""
        return faces_of_polydata(self._polydata, self.surface, self.face_names)

    @property
    def half_voxel(self) -> float | None:
        """Half the side of a cube as large as a voxel, mm, of a surface from voxels; else None."""
        sides = self._polydata.GetFieldData().GetArray(VOXEL_ARRAY)
        half = half_voxel(() if sides is None else vtk_to_numpy(sides))
        return None if half is None else millimeters_per(self.units) * half

    def polydata(self) -> vtkPolyData:
        """A copy of the polydata in the unit of the file, with all its arrays."""
        copy = vtkPolyData()
        copy.DeepCopy(self._polydata)
        return copy

    def as_stored(self, coordinates: ArrayLike) -> Points:
        """Coordinates (k, 3), mm, as they come back from a file of this unit and precision."""
        scale = millimeters_per(self.units)
        stored = (as_points(coordinates) / scale).astype(self.coordinate_type)
        return stored.astype(np.float64) * scale


def read_surface(path: str | os.PathLike[str], units: str = "mm") -> SurfaceFile:
    """Read a surface in one of `SURFACE_FORMATS`; legacy VTK and VTU may be unstructured grids.

    Polygons and strips are cut into triangles, vertices and lines dropped, each with a warning;
    points without a triangle and degenerate triangles stay. In STL equal corners become one point,
    and several solids become the faces of the model. In other formats points that lie on each other
    at a seam count as one; they are written as they were, and so are ghost cells. The first of
    several time steps is read.

    Parameters
    ----------
    path : path
    units : {"mm", "cm", "m"}
        Unit of the coordinates in the file.

    Raises
    ------
    InputError
        Missing, empty, cut short, damaged, of another format, without triangles, NaN or
        infinite coordinates, unknown units.
    """
    scale = millimeters_per(units)
    content = read_with_pieces(path)
    polydata, frame, warnings = _read_polydata(content)
    name = str(content.path)
    template, changes = triangulated_polydata(polydata, name)
    warnings += changes
    if template.GetPoints().GetData().GetDataTypeAsString() not in ("float", "double"):
        template = _with_double_points(template)
        warnings += (Caution("integer-coordinates", label=f"{name}: "),)
    surface = surface_from_polydata(template, name, scale)
    _check_arrays(template, name)
    warnings += _degenerate(surface, name)
    warnings += composition_warnings(surface, name)
    warnings += size_warnings(surface, name, units)
    has_faces = template.GetCellData().HasArray(ID_ARRAY)
    face_names, unread = names_beside(content.path) if has_faces else ({}, ())
    return SurfaceFile(
        surface=surface,
        units=units,
        frame=frame,
        path=content.path,
        sha256=content.sha256,
        coordinate_type=vtk_to_numpy(template.GetPoints().GetData()).dtype,
        warnings=warnings + unread,
        _polydata=template,
        face_names=face_names,
    )


def _read_polydata(content: FileContent) -> tuple[vtkPolyData, Frame | None, tuple[Caution, ...]]:
    kind = recognized(content.data[:HEAD])
    if content.suffix not in READ_SUFFIXES:
        found = f"{content.suffix or 'no suffix'!r}" + (f", {kind.words}" if kind else "")
        advice = kind.advice if kind else "convert it"
        raise InputError(
            f"{content.path}: expected a surface as {', '.join(READ_SUFFIXES)}, got {found}; "
            f"{advice}."
        )
    try:
        return _decoded(content)
    except InputError as error:
        if kind is None or kind.suffix == content.suffix:
            raise
        # A file that can be read is what its name says, whatever its first bytes resemble.
        raise InputError(
            f"{content.path}: expected what its name says, got {kind.words}; {kind.advice}."
        ) from error


def _decoded(content: FileContent) -> tuple[vtkPolyData, Frame | None, tuple[Caution, ...]]:
    if content.suffix not in _PLAIN_DECODERS:
        return read_vtk_polydata(content)
    name = str(content.path)
    mesh = _PLAIN_DECODERS[content.suffix](content.data, name)
    if len(mesh.corners) and (mesh.corners.min() < 0 or mesh.corners.max() >= len(mesh.points)):
        raise InputError(
            f"{name}: expected point indices from 0 to {len(mesh.points) - 1} in its faces, got "
            f"{mesh.corners.min()} to {mesh.corners.max()}; the file is damaged."
        )
    polydata = polydata_from_polygons(mesh.points, mesh.offsets, mesh.corners)
    add_arrays(polydata, mesh.point_arrays, mesh.cell_arrays)
    if mesh.face_ids is not None:
        add_arrays(polydata, None, {ID_ARRAY: mesh.face_ids})
        set_face_names(polydata, mesh.face_names)
    if "Normals" in mesh.point_arrays:
        polydata.GetPointData().SetActiveNormals("Normals")
    return polydata, frame_in_text(mesh.text), mesh.warnings


def _with_double_points(polydata: vtkPolyData) -> vtkPolyData:
    points = vtkPoints()
    points.SetDataTypeToDouble()
    points.DeepCopy(polydata.GetPoints())
    result = vtkPolyData()
    result.ShallowCopy(polydata)
    result.SetPoints(points)
    return result


def _check_arrays(polydata: vtkPolyData, name: str) -> None:
    for kind, data, count in (
        ("point", polydata.GetPointData(), polydata.GetNumberOfPoints()),
        ("cell", polydata.GetCellData(), polydata.GetNumberOfCells()),
    ):
        for index in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(index)
            if array.GetNumberOfTuples() != count:
                raise InputError(
                    f"{name}: expected {count} rows in its {kind} array {array.GetName()}, got "
                    f"{array.GetNumberOfTuples()}; the file is damaged."
                )


def _degenerate(surface: Surface, name: str) -> tuple[Caution, ...]:
    def longest_squared(triangles: Triangles) -> Floats:
        corners = [surface.points.take(corner, axis=0) for corner in triangles.T]
        edges = [corners[k] - corners[k - 1] for k in range(3)]
        return np.maximum.reduce([dot(edge, edge) for edge in edges])

    longest = in_blocks(longest_squared, surface.triangles)
    count = int((2 * surface.face_areas <= NO_HEIGHT * longest).sum())
    found = Caution("degenerate-triangles", {"triangles": count}, label=f"{name}: ")
    return (found,) if count else ()
