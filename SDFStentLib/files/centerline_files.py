"""Centerlines and axes from files, either raw as the file has them or as a tree."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import vtkPolyData

from ..cautions import Caution
from ..centerline import Centerline, Widths
from ..geometry import Line
from ..line_formats import LINES_IN_WORDS, VTK_LINE_SUFFIXES
from ..units import Frame, flipped, millimeters_per
from ..validation import InputError, Points, read_only
from .content import FileContent, read_content
from .formats import decode_fcsv, decode_markups, decode_pth, read_vtk_polydata
from .polydata import inscribed_radius_from_polydata, lines_from_polydata, polydata_from_lines

PLAIN_LINES = {".pth": decode_pth, ".fcsv": decode_fcsv}
"""Decoders of the formats that hold a single line of points."""


@dataclass(frozen=True)
class LineFile:
    """Lines as a file has them, with nothing merged or reordered.

    Attributes
    ----------
    points : (n, 3) array
        Coordinates, mm, in the frame `frame`, read-only.
    lines : tuple of arrays of int64
        Each line as point indices in the order of its cell.
    inscribed_radius : (n,) array or None
        Radius of the inscribed sphere, mm, NaN where unknown; `None` without such an array.
    units : str
        Unit of the file, in which it is written again.
    frame : "RAS", "LPS" or None
        Frame of `points`; `None` where the file does not say.
    path : Path
    sha256 : str
        Hash of the file's bytes, hexadecimal.
    warnings : tuple of Caution
        Changes that were made in reading.
    is_flipped : bool
        Whether `in_frame_of` turned `points` to the other frame; a file is written in the frame
        of the one that was read.
    markups : bytes or None
        The whole file if it is a markups file, kept for writing it again.
    """

    points: Points
    lines: tuple[NDArray[np.int64], ...]
    inscribed_radius: NDArray[np.float64] | None
    units: str
    frame: Frame | None
    path: Path
    sha256: str
    warnings: tuple[Caution, ...] = ()
    is_flipped: bool = False
    markups: bytes | None = field(default=None, repr=False)
    _polydata: vtkPolyData | None = field(default=None, repr=False, compare=False)

    def polydata(self) -> vtkPolyData:
        """A copy of the polydata in the unit and frame of the file, with all its arrays.

        For a markups file it is made of the curves.
        """
        if self._polydata is None:
            stored = flipped(self.points) if self.is_flipped else self.points
            return polydata_from_lines(stored / millimeters_per(self.units), list(self.lines))
        copy = vtkPolyData()
        copy.DeepCopy(self._polydata)
        return copy

    @property
    def drawn_points(self) -> Points:
        """The points (k, 3) through which the lines go, each once, mm."""
        return self.points[np.unique(np.concatenate(self.lines))]

    @property
    def ends(self) -> Points:
        """First and last place of every line, (n, 2, 3), mm."""
        return self.points[[[line[0], line[-1]] for line in self.lines if len(line)]]

    @property
    def file_frame(self) -> Frame | None:
        """Frame of the file, which is that of `points` unless these were turned."""
        if not self.is_flipped:
            return self.frame
        return "RAS" if self.frame == "LPS" else "LPS"

    def centerline(
        self,
        root: Points | None = None,
        wall: Points | None = None,
        widths: Widths | None = None,
    ) -> Centerline:
        """The tree of these lines; `InputError` that names the file where there is none.

        Its root is the end nearest to `root`, (3,) mm; without it, and with points of a `wall`
        (m, 3) and its `widths`, by the rules of `Centerline.from_lines`.
        """
        try:
            return Centerline.from_lines(
                self.points, self.lines, self.inscribed_radius, inlet=root, wall=wall, widths=widths
            )
        except InputError as error:
            raise error.labeled(f"{self.path}: ") from error


def read_lines(path: str | os.PathLike[str], units: str = "mm") -> LineFile:
    """Read lines from VTP, legacy VTK, Slicer's curves and point lists, or SimVascular's paths.

    Parameters
    ----------
    path : path
    units : {"mm", "cm", "m"}
        Unit of the coordinates in the file. The unit that a markups file names is that of the
        screen: its positions are in mm anyhow, unless they were written otherwise.

    Raises
    ------
    InputError
        Missing, empty, cut short, damaged, of another format, without a line of two points,
        NaN or infinite coordinates, unknown units.
    """
    scale = millimeters_per(units)
    content = read_content(path)
    if content.path.name.lower().endswith(".json"):
        return _from_markups(content, units)
    if content.suffix in PLAIN_LINES:
        return _from_plain(content, units)
    if content.suffix not in VTK_LINE_SUFFIXES:
        raise InputError(
            f"{path}: expected a centerline as {LINES_IN_WORDS}, got "
            f"{content.suffix or 'no suffix'!r}; convert it."
        )
    polydata, frame, warnings = read_vtk_polydata(content)
    name = str(content.path)
    points, lines = lines_from_polydata(polydata, name)
    radius = inscribed_radius_from_polydata(polydata)
    if radius is not None and len(radius) != len(points):
        raise InputError(
            f"{name}: expected {len(points)} radii, got {len(radius)}; the file is damaged."
        )
    _check_lines(points, lines, name)
    return LineFile(
        points=read_only(points * scale),
        lines=tuple(read_only(line) for line in lines),
        inscribed_radius=None if radius is None else read_only(radius * scale),
        units=units,
        frame=frame,
        path=content.path,
        sha256=content.sha256,
        warnings=warnings,
        _polydata=polydata,
    )


def read_centerline(path: str | os.PathLike[str], units: str = "mm") -> Centerline:
    """The centerline tree of a file; parameters and errors as `read_lines`.

    `read_lines` also keeps the frame, the warnings and all that is needed to write the file again.
    """
    return read_lines(path, units).centerline()


def read_axis(path: str | os.PathLike[str], units: str = "mm") -> Points:
    """The only line of a file, (n, 3), mm, in the order of its cell; see `axis_of`."""
    return axis_of(read_lines(path, units))


def axis_of(line_file: LineFile) -> Points:
    """The points (n, 3) of the only line of a file, mm, in the order of its cell.

    Raises
    ------
    InputError
        The file has several lines, even if they are pieces of one.
    """
    lines = [line for line in line_file.lines if len(line) > 1]
    if len(lines) != 1:
        raise InputError(
            f"{line_file.path}: expected one line as axis, got {len(lines)}; save one line, or "
            "give the file as centerline",
            "centerline",
            end=".",
        )
    return line_file.points[lines[0]]


def in_frame_of(line_file: LineFile, frame: Frame | None) -> LineFile:
    """Lines in the frame of a surface: x and y negated where both tags are known and differ.

    Without one of the tags the lines are returned unchanged.

    Parameters
    ----------
    line_file : LineFile
    frame : "RAS", "LPS" or None
        Frame of the surface, `SurfaceFile.frame`.
    """
    if line_file.frame is None or frame is None or line_file.frame == frame:
        return line_file
    frames: dict[str, float | str] = {"frame": line_file.frame, "wanted": frame}
    turned = Caution("frame-turned", frames, label=f"{line_file.path}: ")
    return replace(
        line_file,
        points=read_only(flipped(line_file.points)),
        frame=frame,
        warnings=(*line_file.warnings, turned),
        is_flipped=not line_file.is_flipped,
    )


def _from_markups(content: FileContent, units: str) -> LineFile:
    markups = decode_markups(content)
    warnings: tuple[Caution, ...] = ()
    if markups.units not in ("mm", units):
        said = {"unit": markups.units, "wanted": units}
        warnings = (Caution("unit-in-file", said, label=f"{content.path}: "),)
    ends = np.cumsum([len(curve) for curve in markups.curves])
    points = np.concatenate(markups.curves) * millimeters_per(units)
    lines = np.split(np.arange(len(points)), ends[:-1])
    return LineFile(
        points=read_only(points),
        lines=tuple(read_only(line) for line in lines),
        inscribed_radius=None,
        units=units,
        frame=markups.frame,
        path=content.path,
        sha256=content.sha256,
        warnings=warnings,
        markups=content.data,
    )


def _from_plain(content: FileContent, units: str) -> LineFile:
    points, frame = PLAIN_LINES[content.suffix](content)
    lines = (read_only(np.arange(len(points))),)
    _check_lines(points, lines, str(content.path))
    return LineFile(
        points=read_only(points * millimeters_per(units)),
        lines=lines,
        inscribed_radius=None,
        units=units,
        frame=frame,
        path=content.path,
        sha256=content.sha256,
    )


def _check_lines(points: Points, lines: Sequence[NDArray[np.int64]], name: str) -> None:
    if not lines:
        raise InputError(
            f"{name}: expected a centerline of lines, got {len(points)} points without a line; "
            "save the centerline, not its surface or its points."
        )
    if not any(len(line) > 1 and len(Line(points[line]).without_repeats()) > 1 for line in lines):
        raise InputError(
            f"{name}: expected a line of at least two different points, got one point; "
            "compute the centerline again."
        )
