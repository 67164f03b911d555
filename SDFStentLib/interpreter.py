"""The Python with which this program starts processes of its own."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from .validation import DeploymentError

IN_SLICER = "PythonSlicer"
"""The program on 3D Slicer's path that is its Python, with all packages installed there."""


def interpreter() -> str:
    """The path of this Python; in an application that embeds Python, of the one that 3D Slicer has.

    Raises `DeploymentError` if there is none: the application itself cannot run as Python.
    """
    is_embedded = "PythonQt" in sys.modules or "python" not in Path(sys.executable).stem.lower()
    found = shutil.which(IN_SLICER) if is_embedded else sys.executable
    if found is None:
        raise DeploymentError(
            f"expected the program {IN_SLICER} on the path to start a process, found none."
        )
    return found
