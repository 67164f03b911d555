"""OFF, the text of the Geometry Center: points and polygons, and comments.

Source: Geomview's manual, "OFF: Object File Format". What stands behind the coordinates of a point
is left out: programs write normals and colors in different orders under the same header.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError
from ..formats.text_numbers import numbers_in
from ..recognized import HEAD, in_words
from .plain_mesh import PlainMesh, not_kept, offsets_of

_HEADER = re.compile(rb"\s*((?:ST|C|N|4|n)*)OFF(?=\s|\Z)([ \t]+BINARY)?")
_COMMENT = re.compile(rb"#[^\r\n]*")
_LOST = {b"N": "normals", b"C": "colors", b"ST": "texture coordinates"}


def decode_off(data: bytes, name: str) -> PlainMesh:
    """Decode the points and polygons of an OFF file, also of COFF, NOFF and STOFF: a `Decoder`."""
    header = _HEADER.match(data)
    if header is None:
        raise InputError(f"{name}: expected an OFF file, got {in_words(data[:HEAD])}.")
    if header[2] or b"4" in header[1] or b"n" in header[1]:
        raise InputError(
            f"{name}: expected points of three numbers as text in its OFF data, got another kind; "
            "write it as plain OFF."
        )
    text = "\n".join(found.decode("latin-1") for found in _COMMENT.findall(data[:HEAD]))
    lines = [line for line in _COMMENT.sub(b"", data[header.end() :]).splitlines() if line.strip()]
    try:
        counts = numbers_in(lines[0], np.int64)
        if len(counts) not in (2, 3) or len(lines) != 1 + counts[:2].sum() or counts.min() < 0:
            raise ValueError("counts")
        points, point_extras = _points(lines[1 : 1 + counts[0]])
        sizes, corners, face_extras = _polygons(lines[1 + counts[0] :])
    except (ValueError, IndexError, OverflowError, MemoryError) as error:
        raise InputError(
            f"{name}: its data end before or do not fit its OFF header; it is cut short or "
            "damaged, write it again."
        ) from error
    lost = [words for letters, words in _LOST.items() if letters in header[1]]
    if point_extras and not lost:
        lost = ["colors"]  # written by some programs without a C
    lost += ["colors of faces"] if face_extras else []
    warnings = (not_kept(lost, "OFF", name),) if lost else ()
    return PlainMesh(points, offsets_of(sizes), corners, text=text, warnings=warnings)


def _points(rows: list[bytes]) -> tuple[NDArray[np.float64], bool]:
    """Coordinates (n, 3), and whether anything else stands behind them."""
    words = [row.split(None, 3) for row in rows]
    if any(len(row) < 3 for row in words):
        raise ValueError("a point of fewer numbers")
    coordinates = b" ".join(b" ".join(row[:3]) for row in words)
    points = numbers_in(coordinates, np.float64).reshape(-1, 3)
    return points, any(len(row) > 3 for row in words)


def _polygons(rows: list[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int64], bool]:
    """Numbers of corners (m,), the corners, and whether anything else stands behind them."""
    words = [row.split() for row in rows]
    sizes = numbers_in(b" ".join(row[0] for row in words), np.int64)
    if len(sizes) and sizes.min() < 3:
        raise ValueError("a face of fewer corners")
    counts = sizes.tolist()
    if any(len(row) <= size for row, size in zip(words, counts, strict=True)):
        raise ValueError("a face of fewer corners")
    parts = (b" ".join(row[1 : 1 + size]) for row, size in zip(words, counts, strict=True))
    corners = numbers_in(b" ".join(parts), np.int64)
    return sizes, corners, any(len(row) > 1 + size for row, size in zip(words, counts, strict=True))
