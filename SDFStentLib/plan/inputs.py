"""The files of a plan: read, and held to belong together and to the plan."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from ..cautions import Caution
from ..files import (
    LineFile,
    SurfaceFile,
    axis_of,
    check_joined,
    check_same_space,
    in_frame_of,
    read_lines,
    read_surface,
)
from ..lumen import LineEnds, loop_cautions, with_ends_in_middle
from ..stent import AlongAxis, InputFile
from ..treatment import Vessel
from ..units import Frame
from ..validation import InputError
from ..version import VERSION
from .plan import Marks, Plan


@dataclass(frozen=True)
class InputFiles:
    """A surface and a centerline that belong together, read.

    Attributes
    ----------
    surface : SurfaceFile
    line_file : LineFile or None
        The centerline as its file has it, in the frame of the surface.
    vessel : Vessel
        Wall and centerline, mm, in the frame of the surface.
    warnings : tuple of Caution
    seconds : float
        Time that reading took, s.
    frame : {"RAS", "LPS"} or None
        Patient frame of the surface, by its file, or by the giver of its marks; None if unknown.
    """

    surface: SurfaceFile
    line_file: LineFile | None
    vessel: Vessel
    warnings: tuple[Caution, ...]
    seconds: float
    frame: Frame | None


def read_input_files(
    surface: str | os.PathLike[str],
    centerline: str | os.PathLike[str] | None = None,
    units: str = "mm",
    marks: Marks = Marks(),  # noqa: B008
) -> InputFiles:
    """Read a surface and its centerline, and check that they are in the same space.

    Raises
    ------
    InputError
        As the readers; triangles that share no points; a centerline outside of the surface, in
        another unit or frame; names without a centerline, or as of `given_names`.
    """
    start = perf_counter()
    surface_file = read_surface(surface, units)
    check_joined(surface_file.surface, os.fspath(surface))
    line_file, tree = None, None
    warnings = surface_file.warnings
    frame = surface_file.frame or marks.frame
    marks = marks.in_frame(frame)
    if centerline is not None:
        line_file = in_frame_of(read_lines(centerline, units), frame)
        wall = surface_file.surface
        warnings += line_file.warnings
        # First: far from their wall, lines seem to run in one wide lumen, and no tree is left.
        warnings += in_same_space(surface_file, line_file.drawn_points, os.fspath(centerline))
        tree = line_file.centerline(marks.root, wall.points, LineEnds(wall).widths)
        tree, moved = with_ends_in_middle(wall, tree)
        warnings += (*moved, *loop_cautions(tree))
    elif marks.names:
        raise InputError(
            "names: expected a centerline, which tells one vessel from another, got none; give "
            "one, or leave the names out."
        )
    lines = None if line_file is None else line_file.ends
    faces, names = surface_file.faces, marks.names
    vessel = Vessel(surface_file.surface, tree, marks.reference, faces, names, lines)
    _ = vessel.given_names  # names that cannot be meant fail here rather than in the end
    seconds = perf_counter() - start
    return InputFiles(surface_file, line_file, vessel, warnings, seconds, frame)


def read_plan_inputs(plan: Plan, *, accept_changed_inputs: bool = False) -> InputFiles:
    """Read the surface and the centerline of a plan.

    Raises
    ------
    InputError
        As `read_input_files`; a plan without a surface file; a file whose hash is another.
    """
    return as_planned(plan, plan_files(plan), accept_changed_inputs=accept_changed_inputs)


def plan_files(plan: Plan) -> InputFiles:
    """Files of a plan, whatever they hold; errors as `read_plan_inputs`."""
    if plan.surface is None:
        raise InputError(
            "inputs.surface: expected a file, the plan names none; save the plan with its surface."
        )
    center = plan.centerline
    if plan.reference and center is None:
        raise InputError(
            "inputs.reference: expected a plan with a centerline, got one without; name the "
            "centerline, or leave the reference out."
        )
    return read_input_files(
        plan.surface.path,
        None if center is None else center.path,
        plan.units,
        plan.marks,
    )


def as_planned(
    plan: Plan, inputs: InputFiles, *, accept_changed_inputs: bool = False
) -> InputFiles:
    """Files that were read for a plan, with cautions where they are not its own.

    Raises
    ------
    InputError
        A file whose hash is another than the plan's, unless that is accepted.
    """
    named = ((plan.surface, inputs.surface), (plan.centerline, inputs.line_file))
    warnings = list(inputs.warnings)
    for file, read in named:
        if file is not None and read is not None and is_changed(file, read.sha256):
            if not accept_changed_inputs:
                raise changed_input(file, read.sha256)
            warnings.append(Caution("changed-input", label=f"{file.path}: "))
    if plan.sdfstent_version != VERSION:
        versions = {"version": plan.sdfstent_version, "current": VERSION}
        warnings.append(Caution("other-version", versions))
    return replace(inputs, warnings=tuple(warnings))


def input_file(read: SurfaceFile | LineFile) -> InputFile:
    """Path and hash of a file that was read, for a plan."""
    return InputFile(os.fspath(read.path), read.sha256)


def in_same_space(surface: SurfaceFile, points: np.ndarray, name: str) -> tuple[Caution, ...]:
    """`check_same_space` of points, such as a centerline's, by the name of their file."""
    return check_same_space(
        surface.surface,
        points,
        surface_name=os.fspath(surface.path),
        centerline_name=name,
    )


def read_axis_file(
    file: InputFile, units: str, frame: Frame | None, *, accept_changed: bool = False
) -> AlongAxis:
    """The curve of an axis file in the frame of a plan, with the hash of what was read.

    Raises
    ------
    InputError
        A file that cannot be read, that has not one line, or that is not the one of the plan.
    """
    line_file = in_frame_of(read_lines(file.path, units), frame)
    if is_changed(file, line_file.sha256) and not accept_changed:
        raise changed_input(file, line_file.sha256)
    return AlongAxis(axis_of(line_file), InputFile(file.path, line_file.sha256))


def is_changed(file: InputFile, sha256: str) -> bool:
    """Whether a file is another than the plan was made with; any will do where none is named."""
    return file.sha256 not in (None, sha256)


def changed_input(file: InputFile, sha256: str) -> InputError:
    """Error for another file than the plan was made with."""
    return InputError(
        f"{file.path}: expected the file that the plan was made with (sha256 {file.sha256}), got "
        f"another one (sha256 {sha256}); give the original, or accept the changed one ",
        "accept_changed_inputs",
        otherwise="(accept_changed_inputs)",
        end=".",
    )
