"""Centerlines into files: the points moved, everything else as read."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..cautions import Caution
from ..centerline import ExtractedLines
from ..line_formats import LINE_SUFFIXES, VTK_LINE_SUFFIXES
from ..units import Frame, flipped, millimeters_per
from ..validation import InputError, Points, as_path, as_points, check_is_a
from .atomic import check_writable, write_bytes
from .centerline_files import LineFile
from .content import header_text
from .formats import encode_legacy, encode_markups, encode_vtp, new_markups
from .polydata import RADIUS_ARRAYS, add_arrays, polydata_from_lines, set_frame_of_polydata


def write_centerline(
    path: str | os.PathLike[str], line_file: LineFile, points: ArrayLike
) -> tuple[Caution, ...]:
    """Write lines with their points moved, whole or not at all.

    Unit, frame, data types, cells and arrays are those of the file that was read. A markups
    curve keeps its control points, moved; a curve of VTP or VTK becomes one when `path` ends
    with `.mrk.json`, if it is one line.

    Parameters
    ----------
    path : path
        File to write; the suffix sets the format: .vtp, .vtk or .mrk.json.
    line_file : LineFile
    points : array_like, shape (n, 3)
        Points in the order of `line_file.points`, mm.

    Returns
    -------
    tuple of Caution
        Contents that this format cannot keep.

    Raises
    ------
    InputError
        Unknown suffix, another number of points, several lines of another format for a markups
        file, or the file cannot be written.
    """
    check_is_a(line_file, LineFile, "line_file")
    target = check_line_output(path)
    moved = as_points(points, "points")
    if len(moved) != len(line_file.points):
        raise InputError(f"points: expected {len(line_file.points)}, got {len(moved)}.")
    if target.name.lower().endswith(".json"):
        write_bytes(target, _markups_bytes(path, line_file, _in_file(line_file, moved)))
        is_kept = line_file.markups is not None
        return () if is_kept else (Caution("line-arrays-not-kept", label=f"{path}: "),)
    _write_polydata(target, _polydata_with(line_file, moved), line_file.file_frame)
    return ()


def write_extracted_lines(
    path: str | os.PathLike[str], lines: ExtractedLines, units: str, frame: Frame | None
) -> None:
    """Write lines as VMTK does, with `MaximumInscribedSphereRadius`, whole or not at all.

    Parameters
    ----------
    path : path
        File to write; the suffix sets the format: .vtp or .vtk.
    lines : ExtractedLines
    units : {"mm", "cm", "m"}
        Unit of the file of the surface whose centerlines they are.
    frame : "RAS", "LPS" or None
        Patient frame of that file.

    Raises
    ------
    InputError
        Unknown suffix, or the file cannot be written.
    """
    target = check_line_output(path, VTK_LINE_SUFFIXES)
    scale = millimeters_per(units)
    polydata = polydata_from_lines(lines.points / scale, list(lines.lines))
    add_arrays(polydata, {RADIUS_ARRAYS[0]: lines.inscribed_radius / scale}, {})
    _write_polydata(target, polydata, frame)


def _write_polydata(target: Path, polydata: vtkPolyData, frame: Frame | None) -> None:
    set_frame_of_polydata(polydata, frame)
    if target.suffix.lower() == ".vtk":
        write_bytes(target, encode_legacy(polydata, header_text(frame)))
    else:
        write_bytes(target, encode_vtp(polydata))


def check_line_output(
    path: str | os.PathLike[str], suffixes: tuple[str, ...] = LINE_SUFFIXES
) -> Path:
    """The file that `write_centerline` would replace; `InputError` if it could not."""
    if not as_path(path).name.lower().endswith(suffixes):
        raise InputError(
            f"{path}: expected one of {', '.join(suffixes)} to write a centerline; rename it."
        )
    return check_writable(path)


def _in_file(line_file: LineFile, points: Points) -> Points:
    turned = flipped(points) if line_file.is_flipped else points
    return turned / millimeters_per(line_file.units)


def _markups_bytes(path: str | os.PathLike[str], line_file: LineFile, points: Points) -> bytes:
    if line_file.markups is not None:
        return encode_markups([points[line] for line in line_file.lines], line_file.markups)
    if len(line_file.lines) != 1:
        raise InputError(
            f"{path}: a markups file takes one line, the centerline has "
            f"{len(line_file.lines)}; write .vtp."
        )
    return new_markups(points[line_file.lines[0]], line_file.file_frame, line_file.units)


def _polydata_with(line_file: LineFile, points: Points) -> vtkPolyData:
    polydata = line_file.polydata()
    coordinates = vtk_to_numpy(polydata.GetPoints().GetData())
    # Only moved points are written, so that the others keep their bits whatever the unit is.
    moved = np.flatnonzero((points != line_file.points).any(axis=1))
    coordinates[moved] = _in_file(line_file, points[moved]).astype(coordinates.dtype)
    return polydata
