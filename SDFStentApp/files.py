"""Files that a page may open: those in the folders named at the start, and those
named themselves."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import slicer
from vtkmodules.vtkCommonCore import vtkPoints

from SDFStentLib.files import (
    ID_ARRAY,
    NAME_ARRAY,
    LineFile,
    SurfaceFile,
    read_lines,
    set_face_names,
)
from SDFStentLib.line_formats import LINE_INPUTS
from SDFStentLib.plan import load_plan, read_input_files
from SDFStentLib.scan_formats import SCAN_SUFFIXES
from SDFStentLib.surface_formats import READ_SUFFIXES, WHOLE_SUFFIXES, WRITTEN_SUFFIXES
from SDFStentLib.units import Frame
from SDFStentLib.validation import InputError

from .chunks import LARGEST_UPLOAD

SURFACES = READ_SUFFIXES
CENTERLINES = LINE_INPUTS
PLANS = (".json",)
SCANS = SCAN_SUFFIXES
SENT = tuple(dict.fromkeys((*WHOLE_SUFFIXES, *CENTERLINES, *PLANS, *SCANS)))
"""Suffixes of files that a browser may send, without repetitions."""

DEEPEST, MOST = 4, 400
"""Largest depth of folders below a named one, and largest number of files, that are listed."""


class Opened(NamedTuple):
    """The nodes of a vessel and its centerline, a plan to load, if there is one, and the cautions
    about the files."""

    vessel: Any
    centerline: Any
    plan: Path | None = None
    warnings: str = ""


class Uploads:
    """The files that a browser has sent, in a folder of the page."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def kept(self, name: Any, content: Any) -> Path:
        """Keep a file under its own name. Raises `InputError` for a file that a page
        cannot open."""
        path = self.folder / Path(str(name)).name
        if not ends_in(path, (*SENT, ".csv")):
            raise InputError(
                f"{path.name}: expected a file that ends in {', '.join(SENT)}, got another; convert it."
            )
        if not isinstance(content, bytes) or not 0 < len(content) <= LARGEST_UPLOAD:
            raise InputError(
                f"{path.name}: expected a file of at most {LARGEST_UPLOAD // 2**20} MB with something in it, got another; "
                "name its folder with --folder instead."
            )
        self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        path.write_bytes(content)
        return path


def ends_in(path: Path, suffixes: tuple[str, ...]) -> bool:
    """Whether the name of a file ends in one of some suffixes, which may have several dots."""
    return path.name.lower().endswith(suffixes)


def has_lines(path: Path) -> bool:
    """Whether a file is a centerline: by its name or, if that may be a surface's, by
    its content."""
    if not ends_in(path, CENTERLINES):
        return False
    try:
        return not ends_in(path, SURFACES) or bool(read_lines(path))
    except InputError:
        return False


class Folders:
    """The named folders; a link in them that leads elsewhere does not count as inside."""

    def __init__(self, folders: Iterable[str | Path]) -> None:
        self.folders = [Path(folder).resolve() for folder in folders]

    def checked(self, path: str | Path) -> Path:
        """The resolved path of a file that may be opened. Raises `InputError` for a file elsewhere,
        whether it exists or not."""
        try:
            found = Path(path).resolve()
            isInside = any(found.is_relative_to(folder) for folder in self.folders)
        except (OSError, ValueError, RuntimeError):
            isInside = False
        if not isInside:
            raise InputError(
                f"{path}: expected a file in a folder that was named at the start, got one elsewhere; "
                "start sdfstent app with --folder to name its folder."
            )
        return found

    def existing(self, path: str | Path) -> Path:
        """The resolved path of a file that may be opened and exists; otherwise
        raises `InputError`."""
        found = self.checked(path)
        if not found.is_file():
            raise InputError(f"{path}: expected a file, got none; check the path.")
        return found

    def listing(self, suffixes: tuple[str, ...]) -> list[str]:
        """The files with one of these suffixes that are not too deep, in order."""
        found = sorted(
            str(path)
            for folder in self.folders
            for path in _files(folder, DEEPEST)
            if ends_in(path, suffixes)
        )
        return found[:MOST]


def _files(folder: Path, depth: int) -> Iterator[Path]:
    try:
        entries = list(os.scandir(folder))
    except OSError:
        return  # gone, or not ours to read
    for entry in entries:
        if entry.name.startswith("."):
            continue
        if entry.is_dir(follow_symlinks=False) and depth > 0:
            yield from _files(Path(entry.path), depth - 1)
        elif entry.is_file(follow_symlinks=False):
            yield Path(entry.path)


def open_vessel(scene: Any, surface: Path, centerline: Path | None, units: str = "mm") -> Opened:
    """Read a surface and its centerline into the scene, in mm. Raises the library's `InputError`
    for files that it cannot use."""
    files = read_input_files(surface, centerline, units)
    warnings = "\n".join(caution.sentence() for caution in files.warnings)
    vessel = _model(scene, surface, units, files.surface, files.surface.frame)
    if centerline is None:
        return Opened(vessel, None, warnings=warnings)
    lines = _model(scene, centerline, units, files.line_file, files.surface.frame)
    return Opened(vessel, lines, warnings=warnings)


def open_plan(scene: Any, path: Path, folders: Folders | None) -> Opened:
    """Read the files that a plan names; if `folders` are given, these files have to be in them."""
    plan = load_plan(path)
    if plan.surface is None:
        raise InputError(
            f"{path}: expected a plan that names its surface, got one that does not; open the surface first, then load the plan."
        )
    files = [file and Path(file.path) for file in (plan.surface, plan.centerline)]
    if folders is not None:
        files = [file and folders.checked(file) for file in files]
    opened = open_vessel(scene, files[0], files[1], plan.units)
    return opened._replace(plan=path)


def _model(
    scene: Any, path: Path, units: str, file: SurfaceFile | LineFile, frame: Frame | None
) -> Any:
    """A model as Slicer reads it, completed from `file` by what Slicer does not read.

    The `frame` is that of the surface; lines are in it, too, if one of the two files names no
    frame.
    """
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", scene.GenerateUniqueName(path.stem))
    storage = scene.AddNewNodeByClass("vtkMRMLModelStorageNode")
    node.SetAndObserveStorageNodeID(storage.GetID())
    storage.SetFileName(str(path))
    isRead = ends_in(path, WRITTEN_SUFFIXES) and storage.ReadData(node)
    if isinstance(file, SurfaceFile):
        _complete(node, storage, file, isRead)
    elif not isRead:
        _take(node, storage, file.polydata(), (frame and file.file_frame) or frame)
    node.CreateDefaultDisplayNodes()
    if units != "mm":
        from SDFStentSlicer import Conversion

        Conversion.bringToMillimeters(node, units)
    return node


def _complete(node: Any, storage: Any, surface: SurfaceFile, isRead: bool) -> None:
    """Give a model the surface as the library has read it if Slicer has read none, or not its faces
    or their names."""
    from SDFStentSlicer import Conversion

    faces, polyData = surface.faces, node.GetPolyData() if isRead else None
    hasFaces = polyData is not None and (faces is None or polyData.GetCellData().HasArray(ID_ARRAY))
    hasNames = (
        faces is None
        or not faces.names
        or (hasFaces and polyData.GetFieldData().HasArray(NAME_ARRAY))
    )
    if hasFaces and hasNames:
        return
    polyData = polyData if hasFaces else surface.polydata()
    if not hasNames:
        set_face_names(polyData, faces.names)
    if hasFaces:
        Conversion.takeAsInFile(node)
    else:
        _take(node, storage, polyData, surface.frame)


def _take(node: Any, storage: Any, polyData: Any, frame: Frame | None) -> None:
    """Give a model the polydata that was read from its file, in this frame; without a frame in LPS,
    as Slicer takes it."""
    from SDFStentSlicer import Conversion

    frame = frame or "LPS"
    node.SetAndObservePolyData(polyData if frame == "RAS" else _turned(polyData))
    storage.SetCoordinateSystem(storage.GetCoordinateSystemTypeFromString(frame))
    Conversion.takeAsInFile(node)


def _turned(polyData: Any) -> Any:
    # Imported late: a page that shows no such model does not need these modules.
    from vtkmodules.vtkCommonTransforms import vtkTransform
    from vtkmodules.vtkFiltersGeneral import vtkTransformPolyDataFilter

    turn, turned = vtkTransform(), vtkTransformPolyDataFilter()
    turn.Scale(-1, -1, 1)
    turned.SetTransform(turn)
    turned.SetInputData(polyData)
    turned.Update()
    return turned.GetOutput()


def save_model(node: Any, path: Path) -> None:
    """Write a model to a file, in double precision, and set the file as that of its
    storage node."""
    points = vtkPoints()
    points.SetDataTypeToDouble()
    points.DeepCopy(node.GetPolyData().GetPoints())
    node.GetPolyData().SetPoints(points)
    storage = slicer.vtkMRMLModelStorageNode()
    node.GetScene().AddNode(storage)
    node.SetAndObserveStorageNodeID(storage.GetID())
    storage.SetFileName(str(path))
    if not storage.WriteData(node):
        raise InputError(f"{path}: expected to write a model there, could not; is the disk full?")
