"""Painting in a process of its own: without OpenGL, VTK raises no error but ends the process."""

from __future__ import annotations

import pickle
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...interpreter import interpreter
from ...validation import DeploymentError
from .drawing import Drawing

if TYPE_CHECKING:
    from .shapes import Panel

PATIENCE = 600
"""Seconds after which the renderer counts as stuck."""

PACKAGES = "libegl1 libgl1 libgl1-mesa-dri"
"""Debian packages with which VTK renders in software, without a screen."""

PROGRAM = (
    "import sys; sys.path.insert(0, sys.argv[1]); "
    "from SDFStentLib.report.picture.painter import main; main()"
)


def painted(drawing: Drawing, panels: Sequence[Panel] = ()) -> bytes:
    """The PNG of a drawing, with the panels of a picture under it.

    Raises
    ------
    DeploymentError
        Nothing here can render; the message names what to install.
    """
    above = str(Path(__file__).resolve().parents[3])
    try:
        done = subprocess.run(
            [interpreter(), "-c", PROGRAM, above],
            input=pickle.dumps((drawing, tuple(panels))),
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DeploymentError(f"The picture could not be rendered: {error}.") from error
    if done.returncode or not done.stdout.startswith(b"\x89PNG"):
        raise DeploymentError(_no_renderer(done.returncode, done.stderr))
    return done.stdout


def check_rendering() -> None:
    """Raise the `DeploymentError` of `painted` now rather than after a long computation."""
    painted(Drawing(8, 8, ()))


def _no_renderer(code: int, said: bytes) -> str:
    last = said.decode(errors="replace").strip().splitlines()[-1:]
    ending = f" (it said: {last[0]})" if last and code > 0 else ""
    return (
        f"The picture could not be rendered: VTK's process ended with code {code}{ending}; it "
        f"needs an OpenGL library, on Debian and Ubuntu: apt install {PACKAGES}, and VTK 9.4 or "
        "later where there is no screen. Everything else works without pictures."
    )
