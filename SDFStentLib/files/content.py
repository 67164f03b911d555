"""Common to every reader of files: the bytes, their hash, and the frame in the header."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path

from ..units import Frame, as_frame
from ..validation import InputError, as_path
from .recognized import HEAD, MODEL, has_images, image_in


@dataclass(frozen=True)
class FileContent:
    """A file as it was read: its path, its bytes and their SHA-256 (hexadecimal).

    A file that lists others has these as `pieces`, see `parallel`.
    """

    path: Path
    data: bytes
    sha256: str
    pieces: tuple[FileContent, ...] = ()

    @property
    def suffix(self) -> str:
        """The suffix in lower case, with its dot."""
        return self.path.suffix.lower()


def read_content(path: str | os.PathLike[str], wanted: str = "a mesh or a line") -> FileContent:
    """The bytes of a file that exists and is not empty; `wanted` says what it should hold.

    Raises
    ------
    InputError
        Missing, a folder, a device, empty, an image, or not readable.
    """
    try:
        path = as_path(path)
        if path.is_dir():
            if has_images(path):
                raise InputError(f"{path}: expected {wanted}, got a folder of images; {MODEL}.")
            raise InputError(f"{path}: expected a file, got a folder; name a file in it.")
        if not path.exists():
            raise InputError(f"{path}: no such file; check the path.")
        if not path.is_file():
            raise InputError(f"{path}: expected a file, got a device or a pipe.")
        _refuse_image(path, wanted)
        data = path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path}: cannot be read ({reason}); check its permissions.") from error
    if not data:
        raise InputError(f"{path}: expected {wanted}, got an empty file; write it again.")
    return FileContent(path, data, hashlib.sha256(data).hexdigest())


def _refuse_image(path: Path, wanted: str) -> None:
    """Refuse images before reading all of them: they are large, and nothing here reads them."""
    with path.open("rb") as file:
        image = image_in(path, file.read(HEAD))
    if image:
        raise InputError(f"{path}: expected {wanted}, got {image}.")


def read_text(path: str | os.PathLike[str], wanted: str) -> str:
    """The UTF-8 text of a file; `InputError` as for `read_content`, and for a file
    that is no text."""
    try:
        return read_content(path, wanted).data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: expected {wanted}, got no text in UTF-8; save it as that."
        ) from error


def frame_in_text(text: str) -> Frame | None:
    """The frame that a header or a comment names as Slicer does, `SPACE=LPS`, or `None`."""
    found = re.search(r"SPACE\s*=\s*(RAS|LPS)\b", text)
    return as_frame(found.group(1)) if found else None


def header_text(frame: Frame | None) -> str:
    """The title of a written file, which names the frame, if known, as Slicer does."""
    return f"SDFStent output. SPACE={frame}" if frame else "SDFStent output."
