"""OBJ: points and polygons, joined by the numbers of points alone."""

from __future__ import annotations

import re
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, Triangles
from ..formats.text_numbers import numbers_in
from .plain_mesh import PlainMesh, not_kept, offsets_of

_LOST = {
    b"vt": "texture coordinates", b"vn": "normals", b"usemtl": "materials", b"g": "groups",
    b"o": "objects", b"l": "lines", b"p": "points that are drawn", b"curv": "curves",
    b"surf": "free-form surfaces",
}  # fmt: skip
_COLORED = 7
"""Number of words of a line `v x y z r g b`; with five words, the last is a weight."""

_CONTINUED = re.compile(rb"\\\r?\n")
_COMMENT = re.compile(rb"#[^\r\n]*")
_INDENT = re.compile(rb"^[ \t]+", re.MULTILINE)
_HEADER_LINES = 50
"""Number of first lines in whose comments the frame is searched."""


def decode_obj(data: bytes, name: str) -> PlainMesh:
    """Decode the points and polygons of an OBJ file, with the topology of its indices.

    Corners are joined by point index alone, so that a surface with texture seams or sharp
    normals stays watertight; contents that are not kept are named in `warnings`.

    `InputError` for a number that is none; else see `Decoder`.
    """
    comments = [line for line in data.split(b"\n", _HEADER_LINES)[:_HEADER_LINES] if b"#" in line]
    text = "\n".join(line[line.index(b"#") :].decode("latin-1") for line in comments)
    data = _INDENT.sub(b"", _CONTINUED.sub(b" ", _COMMENT.sub(b"", data)))
    lines = data.splitlines()
    point_lines = [line for line in lines if line[:2] in (b"v ", b"v\t")]
    point_rows = [line.split()[1:4] for line in point_lines]
    face_lines = [line for line in lines if line[:2] in (b"f ", b"f\t")]
    if any(b"/" in line for line in face_lines):  # texture and normal after the point
        face_lines = re.sub(rb"/[^\s]*", b"", b"\n".join(face_lines)).split(b"\n")
    faces = [line.split()[1:] for line in face_lines]
    if not point_rows or data.find(b"\0") >= 0:
        raise InputError(f"{name}: expected an OBJ file with points (v x y z), found none.")
    is_colored = any(map(_has_color, point_lines))
    try:
        if any(len(row) != 3 for row in point_rows):
            raise ValueError("a point of fewer")
        points = numbers_in(b" ".join(chain.from_iterable(point_rows)), np.float64).reshape(-1, 3)
        corners = numbers_in(b" ".join(chain.from_iterable(faces)), np.int64)
    except ValueError as error:
        raise InputError(f"{name}: expected numbers after v and f, got {error}.") from error
    if (corners == 0).any():
        raise InputError(f"{name}: expected point numbers from 1 in its faces, got 0.")
    sizes = np.array([len(face) for face in faces], dtype=np.int64)
    if len(sizes) and sizes.min() < 3:
        raise InputError(
            f"{name}: expected faces of three corners or more, got one of {sizes.min()}; it may "
            "be cut short, write it again."
        )
    corners = _from_one_or_from_the_end(corners, sizes, lines)
    lost = (["colors"] if is_colored else []) + _lost(lines)
    warnings = (not_kept(lost, "OBJ", name),) if lost else ()
    return PlainMesh(points, offsets_of(sizes), corners, text=text, warnings=warnings)


def encode_obj(points: NDArray[np.floating], triangles: Triangles, title: str) -> bytes:
    """Encode OBJ text with all digits of the points' precision.

    Parameters
    ----------
    points : array, shape (n, 3), float32 or float64
    triangles : array, shape (m, 3)
    title : str
        Text of the first comment.
    """
    pattern = "v %.9g %.9g %.9g\n" if points.dtype == np.float32 else "v %r %r %r\n"
    parts = [f"# {title}\n"]
    parts.append((pattern * len(points)) % tuple(points.ravel().tolist()))
    parts.append(("f %d %d %d\n" * len(triangles)) % tuple((triangles + 1).ravel().tolist()))
    return "".join(parts).encode("ascii", "replace")


def _has_color(line: bytes) -> bool:
    blanks = line.count(b" ") + line.count(b"\t")
    return blanks + 1 >= _COLORED and len(line.split()) >= _COLORED


def _from_one_or_from_the_end(
    corners: NDArray[np.int64], sizes: NDArray[np.int64], lines: list[bytes]
) -> NDArray[np.int64]:
    """Indices from 0; a negative number counts back from the points read so far."""
    if not (corners < 0).any():
        return corners - 1
    kinds = np.array([line[:2] for line in lines], dtype="S2")
    is_face = (kinds == b"f ") | (kinds == b"f\t")
    seen = np.cumsum((kinds == b"v ") | (kinds == b"v\t"))[is_face]
    return np.where(corners < 0, corners + np.repeat(seen, sizes), corners - 1)


def _lost(lines: list[bytes]) -> list[str]:
    starts = {line[:7] for line in lines if line[:2] not in (b"v ", b"f ")}
    keys = {start.split()[0] for start in starts if start.strip()}
    return [words for key, words in _LOST.items() if key in keys]
