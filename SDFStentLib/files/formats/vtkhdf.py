"""VTKHDF, read by VTK in a process of its own, which a damaged file may end without harm."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from ...interpreter import own_program
from ...validation import InputError
from ..content import FileContent
from ..recognized import HEAD, MODEL, in_words
from .stored_polydata import StoredPolydata, first_of_steps
from .vtp import decode_grid, decode_vtp

_HDF5 = b"\x89HDF\r\n\x1a\n"

TIME_LIMIT = 300.0
"""Time limit, s; 100 MB take about one second."""

ANSWER, FINDINGS = "surface.xml", "findings.json"
"""Files that the process writes: the surface as VTK's XML, and what the file holds."""


def decode_vtkhdf(content: FileContent) -> StoredPolydata:
    """The surface of a VTKHDF file.

    Raises
    ------
    InputError
        Damaged, cut short, or data other than polydata or a grid that is a surface.
    """
    name = str(content.path)
    if not content.data.startswith(_HDF5):
        raise InputError(f"{name}: expected a VTKHDF file, got {in_words(content.data[:HEAD])}.")
    with TemporaryDirectory(prefix="sdfstent-") as folder:
        program = f"{__package__.rpartition('.')[0]}.vtkhdf_process"
        command, environment = own_program(program, str(content.path.resolve()), folder)
        try:
            done = subprocess.run(
                command, capture_output=True, timeout=TIME_LIMIT, check=False, env=environment
            )
        except subprocess.TimeoutExpired as error:
            raise _unread(name, f"no answer in {TIME_LIMIT:g} s") from error
        findings, answer = Path(folder, FINDINGS), Path(folder, ANSWER)
        if done.returncode or not findings.is_file():
            raise _unread(name, f"VTK ended with code {done.returncode}")
        known = json.loads(findings.read_text(encoding="utf-8"))
        if known["errors"]:
            raise _unread(name, known["errors"])
        if not answer.is_file():
            is_image = known["kind"] == "vtkImageData"
            advice = MODEL if is_image else "extract its surface and save that as .vtp"
            kind = "an image" if is_image else known["kind"]
            raise InputError(f"{name}: expected a surface, got {kind}; {advice}.")
        data = answer.read_bytes()
    decode = decode_grid if known["kind"] == "vtkUnstructuredGrid" else decode_vtp
    stored = decode(data, name)
    if known["steps"] < 2:
        return stored
    return replace(stored, cautions=(first_of_steps(known["steps"], known["time"], name),))


def _unread(name: str, reason: str) -> InputError:
    return InputError(
        f"{name}: expected a VTKHDF file, VTK cannot read it ({reason}); it is cut short or "
        "damaged, write it again."
    )
