"""The Python with which processes of our own are started."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from .validation import DeploymentError

IN_SLICER = "PythonSlicer"
"""The program on 3D Slicer's path that is its Python, with all that was installed there."""


def interpreter() -> str:
    """This Python; in an application that embeds it, the one that 3D Slicer brings along.

    Raises `DeploymentError` where there is none: the application itself is no Python to start.
    """
    is_embedded = "PythonQt" in sys.modules or "python" not in Path(sys.executable).stem.lower()
    found = shutil.which(IN_SLICER) if is_embedded else sys.executable
    if found is None:
        raise DeploymentError(
            f"expected the program {IN_SLICER} on the path to start a process, found none."
        )
    return found
