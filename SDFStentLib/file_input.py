"""What every reader of files needs: the bytes, their hash, the unit, the frame tag."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .validation import InputError

Frame = Literal["RAS", "LPS"]
"""Patient frames: RAS (x to the right) as Slicer has it in memory, LPS as it writes files."""

MILLIMETERS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Millimetres in the units that a file may use."""


@dataclass(frozen=True)
class FileContent:
    """A file as it was read: where it is, its bytes and their SHA-256 (hexadecimal)."""

    path: Path
    data: bytes
    sha256: str

    @property
    def suffix(self) -> str:
        """The suffix in lower case, with its dot."""
        return self.path.suffix.lower()


def read_content(path: str | os.PathLike[str]) -> FileContent:
    """The bytes of a file that exists and is not empty.

    Raises
    ------
    InputError
        Missing, a folder, a device, empty, or not readable.
    """
    try:
        path = Path(path)
        if path.is_dir():
            raise InputError(f"{path}: expected a file, got a folder; name a file in it.")
        if not path.exists():
            raise InputError(f"{path}: no such file; check the path.")
        if not path.is_file():
            raise InputError(f"{path}: expected a file, got a device or a pipe.")
        data = path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot be read ({reason}); check its permissions.") from error
    if not data:
        raise InputError(f"{path}: expected a mesh or a line, got an empty file; write it again.")
    return FileContent(path, data, hashlib.sha256(data).hexdigest())


_BEGINNINGS = {
    b"# vtk DataFile": "a legacy VTK file (name it .vtk)",
    b"ply": "a PLY file (name it .ply)",
    b"solid": "an STL file (name it .stl)",
    b"<?xml": "another XML file",
    b"PK": "a ZIP archive (unpack it)",
    b"\x1f\x8b": "a compressed file (unpack it)",
}


def kind_in_words(data: bytes) -> str:
    """What a file that is not what its name says seems to be: by its beginning, for a message."""
    if b"<VTKFile" in data[:4096]:
        return "a VTK XML file (name it .vtp)"
    for beginning, words in _BEGINNINGS.items():
        if data.startswith(beginning):
            return words
    return f"a file that begins with {data[:12]!r}"


def millimeters_per(units: str) -> float:
    """Millimetres in one of the file's units, `"mm"`, `"cm"` or `"m"`; `InputError` for others."""
    if not isinstance(units, str) or units not in MILLIMETERS:
        raise InputError(f"units: expected one of {', '.join(MILLIMETERS)}, got {units!r}.")
    return MILLIMETERS[units]


def as_frame(tag: str) -> Frame | None:
    """The frame that a tag names, in any case and also as Slicer's old numbers; `None` if unknown.

    Older markups files say `0` for RAS and `1` for LPS.
    """
    tag = tag.strip().upper()
    if tag in ("RAS", "0"):
        return "RAS"
    if tag in ("LPS", "1"):
        return "LPS"
    return None


def frame_in_text(text: str) -> Frame | None:
    """The frame that a header or a comment names as Slicer does, `SPACE=LPS`; `None` without."""
    found = re.search(r"SPACE\s*=\s*(RAS|LPS)\b", text)
    return as_frame(found.group(1)) if found else None


def header_text(frame: Frame | None) -> str:
    """The title of a written file, which names the frame as Slicer does where it is known."""
    return f"SDFStent output. SPACE={frame}" if frame else "SDFStent output."
