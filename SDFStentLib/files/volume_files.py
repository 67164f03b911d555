"""Volume meshes and what a solver has found at their points, from files in cm."""

from __future__ import annotations

import os

import numpy as np

from ..units import MILLIMETERS
from ..validation import Floats, InputError
from .content import read_content
from .formats import decode_vtu
from .mesh_complete import UNITS, VolumeMesh


def read_volume(path: str | os.PathLike[str]) -> tuple[VolumeMesh, dict[str, Floats]]:
    """Tetrahedra of a VTU file in cm, and the arrays (n,) or (n, k) at their points, by name.

    Raises
    ------
    InputError
        No such file, another kind of file, a damaged one, or coordinates that are no numbers.
    """
    content = read_content(path, "a volume mesh")
    points, tetrahedra, arrays = decode_vtu(content.data, str(content.path))
    if not np.isfinite(points).all():
        raise InputError(f"{content.path}: expected finite coordinates, got others; make it anew.")
    return VolumeMesh(MILLIMETERS[UNITS] * points, tetrahedra), arrays
