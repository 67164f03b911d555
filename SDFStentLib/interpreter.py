"""The Python with which this program starts processes of its own."""

from __future__ import annotations

import os
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


def own_program(module: str, *arguments: str) -> tuple[list[str], dict[str, str]]:
    """Command and environment of a process that runs a module of this library.

    The process finds the library where this one has found it, which an application may have done by
    paths that are not those of the environment. Errors as of `interpreter`.
    """
    library = str(Path(__file__).resolve().parents[1])
    paths = [library, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    return [interpreter(), "-m", module, *arguments], environment
