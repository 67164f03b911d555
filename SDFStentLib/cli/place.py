"""The placement that the options of the command line say."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..cautions import Caution
from ..files import axis_of, in_frame_of, read_lines
from ..plan import (
    POINT_PLACEMENTS,
    InputFiles,
    Marks,
    Plan,
    input_file,
    load_names,
    read_input_files,
    scaled,
)
from ..report import LEAST
from ..stent import AlongAxis, AtLesion, BetweenPoints, InputFile, OnBranch, Placement, Stent
from ..treatment import VesselName
from ..units import MILLIMETERS, Frame, are_apart, as_frame
from ..validation import InputError


class Place(NamedTuple):
    """A placement, and cautions from reading it."""

    placement: Placement
    warnings: tuple[Caution, ...]


def check_place(
    options: argparse.Namespace, *, needed: bool, has_length: bool | None = None
) -> str | None:
    """The way in which the options give the place, checked before any file is read.

    Parameters
    ----------
    options : argparse.Namespace
    needed : bool
        Whether there has to be a place.
    has_length : bool, optional
        Whether a length is known; by default whether the options have one.

    Returns
    -------
    str or None
        center, distal, proximal, from, axis, or None if no option gives a place.

    Raises
    ------
    InputError
        No place although one is needed, several places, or one without what belongs to it.
    """
    for name in ("root", "reference", "names"):
        if getattr(options, name) and options.centerline is None:
            raise InputError(f"expected --centerline FILE with --{name}, got none; give one.")
    given = [name for name in POINT_PLACEMENTS if getattr(options, name) is not None]
    if (options.from_point is None) != (options.to is None):
        raise InputError("expected both --from and --to, got one of them; give the other end.")
    given += ["from"] if options.to is not None else []
    others = ("axis", "at_lesion", "branch")
    given += [name for name in others if getattr(options, name, None) is not None]
    _check_along(options)
    if len(given) > 1:
        raise InputError(
            f"expected one place, got {' and '.join(map(option_of, given))}; leave one out."
        )
    if not given:
        if needed:
            raise InputError(
                "expected where the stent goes, got nothing; give --axis, or --centerline with "
                "--center, --distal, --proximal, --at-lesion, --branch, or --from and --to."
            )
        return None
    way = given[0]
    if way != "axis" and options.centerline is None:
        raise InputError(f"expected --centerline FILE with {option_of(way)}, got none; give one.")
    has_length = options.length is not None if has_length is None else has_length
    if way in (*POINT_PLACEMENTS, "at_lesion", "branch") and not has_length:
        raise InputError(f"expected --length L (mm) with {option_of(way)}, got none; give one.")
    if way == "from" and options.length is not None:
        raise InputError(
            "expected no --length between two points, which determine it; leave it or one of "
            "--from and --to out."
        )
    return way


def _check_along(options: argparse.Namespace) -> None:
    """Refuse what says where along a vessel without the vessel, and a branch without it."""
    for name, of in (("offset", "at_lesion"), ("distance", "branch"), ("fraction", "branch")):
        if getattr(options, name, None) is not None and getattr(options, of) is None:
            raise InputError(f"expected {option_of(of)} with --{name}, got none; give one.")
    has_branch = getattr(options, "branch", None) is not None
    if has_branch and (options.distance is None) == (options.fraction is None):
        got = "neither" if options.distance is None else "both"
        raise InputError(
            f"expected --distance MM or --fraction S with --branch, got {got}; give one."
        )


def place_of(options: argparse.Namespace, way: str, inputs: InputFiles) -> Place:
    """The placement, mm, in the frame of the surface.

    Raises
    ------
    InputError
        An axis file that cannot be read, points that are not finite, a lesion that is not there.
    """
    if way == "at_lesion":
        check_lesion_number(options.at_lesion, inputs, "--at-lesion", "place the stent by points")
        return Place(AtLesion(options.at_lesion, options.offset), ())
    if way == "branch":
        number = int(options.branch) if options.branch.isdecimal() else options.branch
        return Place(OnBranch(number, options.distance, options.fraction), ())
    if way == "axis":
        line_file = in_frame_of(read_lines(options.axis, options.units), inputs.frame)
        file = InputFile(options.axis, line_file.sha256)
        return Place(AlongAxis(axis_of(line_file), file), line_file.warnings)
    if way == "from":
        return Place(BetweenPoints(*ends_of(options)), ())
    point = in_mm(getattr(options, way), options.units, option_of(way))
    return Place(POINT_PLACEMENTS[way](point), ())


def check_lesion_number(number: int, inputs: InputFiles, option: str, otherwise: str) -> None:
    """Refuse the number of a lesion that the vessel has not.

    Raises
    ------
    InputError
        With what to do `otherwise` where there is no lesion at all.
    """
    count = len(inputs.vessel.lesions or ())
    if not count:
        raise InputError(
            f"{option}: expected a vessel with a lesion, got one in which none of {LEAST} was "
            f"found; {otherwise}."
        )
    if not 1 <= number <= count:
        there = f"a number from 1 to {count}" if count > 1 else "1"
        has = f"{count} lesions" if count > 1 else "one lesion"
        raise InputError(
            f"{option}: expected {there}, as the vessel has {has}, got {number}; see "
            "`sdfstent measure` for the list."
        )


def plan_of(
    options: argparse.Namespace, method: Plan, stents: tuple[Stent, ...], inputs: InputFiles
) -> Plan:
    """A plan of stents in what was read, with the settings of another plan."""
    root = root_of(options)
    return replace(
        method,
        stents=stents,
        surface=input_file(inputs.surface),
        centerline=None if inputs.line_file is None else input_file(inputs.line_file),
        units=options.units,
        frame=inputs.frame,
        root=None if root is None else tuple(root.tolist()),
        reference=tuple(tuple(place.tolist()) for place in reference_of(options)),
        names=inputs.vessel.names,
    )


def inputs_of(options: argparse.Namespace) -> InputFiles:
    """Surface, and centerline with its root and reference, as read from the options' files.

    `InputError` where another frame is named than the file says.
    """
    frame = frame_of(options)
    read = read_input_files(
        options.surface,
        options.centerline,
        options.units,
        Marks(root_of(options), reference_of(options), names_of(options), frame),
    )
    check_frame(frame, read.surface.frame, options.surface)
    return read


def frame_of(options: argparse.Namespace) -> Frame | None:
    """The frame that the options name, where the command has such an option."""
    named = getattr(options, "frame", None)
    return None if named is None else as_frame(named)


def check_frame(named: Frame | None, known: Frame | None, said_by: str) -> None:
    """Refuse a frame other than the known one."""
    if are_apart(named, known):
        raise InputError(
            f"--frame: expected {known}, which {said_by} says, got {named}; leave it out."
        )


def treated_of(options: argparse.Namespace, before: InputFiles) -> InputFiles:
    """The vessel after treatment; `InputError` where it is in another frame."""
    after = read_input_files(options.after, units=options.units)
    frames = [one.surface.frame for one in (before, after)]
    if are_apart(*frames):
        raise InputError(
            f"{options.after}: expected the frame of {options.surface}, {frames[0]}, got "
            f"{frames[1]}; write both in one frame."
        )
    return after


def ends_of(options: argparse.Namespace) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The two ends of a segment, mm."""
    return (
        in_mm(options.from_point, options.units, "--from"),
        in_mm(options.to, options.units, "--to"),
    )


def root_of(options: argparse.Namespace) -> NDArray[np.float64] | None:
    """Point (3,) near the root of the centerline, mm, where one was given."""
    return None if options.root is None else in_mm(options.root, options.units, "--root")


def reference_of(options: argparse.Namespace) -> tuple[NDArray[np.float64], ...]:
    """The places where the user marked healthy vessel, mm."""
    return tuple(in_mm(point, options.units, "--reference") for point in options.reference)


def names_of(options: argparse.Namespace) -> tuple[VesselName, ...]:
    """Names of the vessels by the user."""
    return () if options.names is None else load_names(options.names, options.units)


def option_of(name: str) -> str:
    """Spelling of an option of the namespace on the command line."""
    return "--" + name.replace("_", "-")


def in_mm(point: Sequence[float], units: str, option: str) -> NDArray[np.float64]:
    """Point (3,) of an option in mm; `InputError` where it is not finite."""
    for value in point:
        if not abs(value) < 1e300:
            raise InputError(f"{option}: expected three finite numbers, got {value}; correct it.")
    return np.array([scaled(value, MILLIMETERS[units]) for value in point])


def half_voxel_of(options: argparse.Namespace, inputs: InputFiles) -> float | None:
    """Half a voxel, mm, where its range is asked for; `InputError` where voxels are not known."""
    half = inputs.surface.half_voxel
    if not options.voxel_range:
        return None
    if half is None or inputs.vessel.centerline is None:
        raise InputError(
            f"{inputs.surface.path}: expected a surface that knows its voxels, and a centerline, "
            "for --voxel-range, as `sdfstent prepare` writes them, got others; leave this out."
        )
    return half
