"""MMG, a remesher of the user's own installation (LGPL), in a process of its own.

It is given triangles or tetrahedra with the sizes that edges shall have at their points, in files
of Medit's format, and answers with others (https://www.mmgtools.org).
"""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from ..validation import DeploymentError, Floats, Indices, InputError, Points

INSTALL = "pip install 'sdfstent[mesh]'"

TIME_LIMIT = 1800.0
"""s, for programs that take about one for 20,000 cells."""


class MeditMesh(NamedTuple):
    """Points, triangles with the number of their face, and tetrahedra, if any."""

    points: Points
    """(n, 3) mm."""
    triangles: Indices
    """(m, 3)"""
    faces: Indices
    """(m,)"""
    tetrahedra: Indices
    """(t, 4)"""


def check_mmg() -> None:
    """`InputError` that says how to install MMG, where it is missing."""
    for name in ("mmgs", "mmg3d"):
        _program(name)


def by_mmg(name: str, mesh: MeditMesh, sizes: Floats, options: Sequence[str]) -> MeditMesh:
    """Remesh by MMG.

    Parameters
    ----------
    name : str
        `mmgs` for surfaces, `mmg3d` for tetrahedra.
    mesh : MeditMesh
    sizes : (n,) array
        Sizes of edges at the points, mm.
    options : sequence of str
        As its command line has them.

    Raises
    ------
    InputError
        MMG is not installed.
    DeploymentError
        It fails; with its last words.
    """
    program = _program(name)
    with TemporaryDirectory(prefix="sdfstent-mesh-") as folder:
        old, wanted, new = (Path(folder) / file for file in ("old.mesh", "old.sol", "new.mesh"))
        _write(old, mesh)
        rows = "\n".join(f"{size:.9g}" for size in sizes.tolist())
        text = f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(sizes)}\n1 1\n{rows}\n"
        wanted.write_text(f"{text}End\n", encoding="ascii")
        command = [program, "-v", "1", *options, "-in", str(old), "-sol", str(wanted)]
        run_mesher("MMG", [*command, "-out", str(new)], new)
        return _read(new)


def run_mesher(name: str, command: Sequence[str], answer: Path) -> None:
    """Run a mesher that writes a file; `DeploymentError` with its last words where it does not."""
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired as error:
        raise _failed(name, f"no answer in {TIME_LIMIT:g} s") from error
    if done.returncode or not answer.is_file():
        said = (done.stdout + done.stderr).decode("utf-8", "replace").splitlines()
        last = [line.strip() for line in said if line.strip()][-1:] or ["nothing"]
        raise _failed(name, f"exit code {done.returncode}, and it said: {last[0]}")


def _failed(name: str, words: str) -> DeploymentError:
    return DeploymentError(
        f"{name}: expected a mesh, got {words}. Look at the surfaces with sdfstent check, or "
        "choose other ends of the segment."
    )


def _program(name: str) -> str:
    """Path of MMG's program, of this Python's scripts or where the shell looks."""
    beside = sysconfig.get_path("scripts")
    for full in (f"{name}_O3", name):
        found = shutil.which(full, path=beside) or shutil.which(full)
        if found:
            return found
    raise InputError(f"expected MMG ({name}) to mesh a vessel, it is not installed; {INSTALL}.")


def _write(path: Path, mesh: MeditMesh) -> None:
    """Write a mesh for MMG, whose indices count from 1."""
    count = len(mesh.points)
    rows = [f"Vertices\n{count}"]
    rows += [f"{x!r} {y!r} {z!r} 0" for x, y, z in mesh.points.tolist()]
    rows.append(f"Triangles\n{len(mesh.triangles)}")
    numbered = np.column_stack([mesh.triangles + 1, mesh.faces]).tolist()
    rows += [f"{a} {b} {c} {face}" for a, b, c, face in numbered]
    if len(mesh.tetrahedra):
        rows.append(f"Tetrahedra\n{len(mesh.tetrahedra)}")
        rows += [f"{a} {b} {c} {d} 1" for a, b, c, d in (mesh.tetrahedra + 1).tolist()]
    text = "\n".join(["MeshVersionFormatted 2\nDimension 3", *rows, "End\n"])
    path.write_text(text, encoding="ascii")


def _read(path: Path) -> MeditMesh:
    words = path.read_text(encoding="ascii").split()
    triangles = _table(words, "Triangles", 4).astype(np.int64)
    tetrahedra = _table(words, "Tetrahedra", 5).astype(np.int64)
    points = _table(words, "Vertices", 4)[:, :3]
    return MeditMesh(points, triangles[:, :3] - 1, triangles[:, 3], tetrahedra[:, :4] - 1)


def _table(words: Sequence[str], name: str, width: int) -> Floats:
    """The rows (k, width) behind a word; none where it does not stand."""
    if name not in words:
        return np.zeros((0, width))
    start = words.index(name) + 2
    values = words[start : start + width * int(words[start - 1])]
    return np.array(values, dtype=np.float64).reshape(-1, width)
