"""A centerline from a bare surface, by VMTK, in a process of its own."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..centerline import ExtractedLines
from ..geometry import Surface, median_edge, norm
from ..interpreter import own_program
from ..validation import DeploymentError, InputError, Points

OLDEST_PYTHON = (3, 12)
"""Oldest Python for which the package `vmtk` is made."""

SHAKEN = 1e-3
"""Share of the median edge by which every point is moved for VMTK: on a wall as regular as that of
a synthetic tube, with many points on one sphere, its lines stop on the way."""

INSTALL = 'pip install "vmtk>=1.5"'


REACHED = 0.1
"""Largest distance, mm, of a line's last point from the end that it leads to."""


def check_vmtk() -> None:
    """Raise an `InputError` that says how to install VMTK if it is missing."""
    if importlib.util.find_spec("vmtk") is not None:
        return
    if sys.version_info < OLDEST_PYTHON:
        raise InputError(
            "expected VMTK to extract a centerline, its package needs Python "
            f"{'.'.join(map(str, OLDEST_PYTHON))} or later, this is "
            f"{sys.version_info.major}.{sys.version_info.minor}; install sdfstent there, "
            f"then {INSTALL}, or extract the centerline in 3D Slicer."
        )
    raise InputError(
        f"expected VMTK to extract a centerline, it is not installed; {INSTALL}, or extract "
        "the centerline in 3D Slicer."
    )


def extract_lines(surface: Surface, inlet: int, outlets: Sequence[int]) -> ExtractedLines:
    """Centerlines from one place to others, along the largest inscribed spheres (VMTK).

    VMTK ends its process on some surfaces; it runs in one of its own, so this gives an error only.

    Parameters
    ----------
    surface : Surface
        Closed and manifold, mm; see `capped`.
    inlet : int
        A point of the surface at the proximal end.
    outlets : sequence of int
        A point of the surface at every distal end.

    Raises
    ------
    InputError
        VMTK is not installed, or the surface is open or not manifold.
    DeploymentError
        VMTK found no line to each of the outlets.
    """
    check_vmtk()
    if not surface.topology.is_watertight:
        raise InputError(
            f"surface: expected a watertight one to extract a centerline, it is "
            f"{surface.topology.in_words()}; see sdfstent check."
        )
    with tempfile.TemporaryDirectory(prefix="sdfstent-") as folder:
        question, answer = Path(folder, "surface.npz"), Path(folder, "lines.npz")
        np.savez(
            question,
            points=_shaken(surface),
            triangles=surface.triangles,
            inlet=inlet,
            outlets=np.asarray(outlets, dtype=np.int64),
        )
        program = f"{__package__}.vmtk_process"
        command, environment = own_program(program, str(question), str(answer))
        run = subprocess.run(command, capture_output=True, check=False, env=environment)
        if run.returncode or not answer.is_file():
            raise _failure(surface, inlet, f"VMTK ended with code {run.returncode}")
        with np.load(answer) as data:
            points, radius = data["points"], data["inscribed_radius"]
            lines = tuple(np.split(data["corners"], data["offsets"][1:-1]))
    found = ExtractedLines(points, lines, radius)
    _check_reached(found, surface, inlet, outlets)
    return found


def _shaken(surface: Surface) -> Points:
    """The points, each moved a little, in the same way in every run."""
    reach = SHAKEN * median_edge(surface.points, surface.triangles)
    return surface.points + reach * np.random.default_rng(0).uniform(-1, 1, surface.points.shape)


def _check_reached(
    found: ExtractedLines, surface: Surface, inlet: int, outlets: Sequence[int]
) -> None:
    """Raise an error for too few lines or lines that stop on the way: VMTK's failed searches."""
    if len(found.lines) != len(outlets):
        count = f"VMTK found {len(found.lines)} lines to {len(outlets)} ends"
        raise _failure(surface, inlet, count)
    for line, outlet in zip(found.lines, outlets, strict=True):
        ends = found.points[line[[0, -1]]]
        if norm(ends - surface.points[[inlet, outlet]]).max() > REACHED:
            raise _failure(surface, outlet, "VMTK's line stops before the end")


def _failure(surface: Surface, vertex: int, what: str) -> DeploymentError:
    x, y, z = surface.points[vertex]
    return DeploymentError(
        f"no centerline found ({what}, at {x:.1f} {y:.1f} {z:.1f} mm); "
        "look for holes and folds with sdfstent check."
    )
