"""OFF, the text of the Geometry Center: points and polygons, with colors, normals and comments.

Source: Geomview's manual, "OFF: Object File Format".
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError
from ..formats.text_numbers import numbers_in
from ..recognized import in_words
from .plain_mesh import PlainMesh, not_kept, offsets_of

_HEADER = re.compile(rb"\s*(ST)?(C?)(N?)(4?)(n?)OFF(?=\s|\Z)([ \t]+BINARY)?")
_COMMENT = re.compile(rb"#[^\r\n]*")


class _Vertex(NamedTuple):
    """The words of a line of a point: behind coordinates come normal, color and texture."""

    has_normals: bool
    has_colors: bool
    has_texture: bool

    @property
    def lost(self) -> list[str]:
        return [
            words
            for words, has in zip(("colors", "texture coordinates"), self[1:], strict=True)
            if has
        ]


def decode_off(data: bytes, name: str) -> PlainMesh:
    """Read OFF, also COFF, NOFF and STOFF; normals become the array `Normals`: a `Decoder`."""
    header = _HEADER.match(data)
    if header is None:
        raise InputError(f"{name}: expected an OFF file, got {in_words(data)}.")
    if header[4] or header[5] or header[6]:
        raise InputError(
            f"{name}: expected points of three numbers as text in its OFF data, got another kind; "
            "write it as plain OFF."
        )
    vertex = _Vertex(bool(header[3]), bool(header[2]), bool(header[1]))
    text = "\n".join(found.decode("latin-1") for found in _COMMENT.findall(data[:4096]))
    lines = [line for line in _COMMENT.sub(b"", data[header.end() :]).splitlines() if line.strip()]
    try:
        return _mesh(lines, vertex, text, name)
    except (ValueError, IndexError, OverflowError, MemoryError) as error:
        raise InputError(
            f"{name}: its data end before or do not fit its OFF header; it is cut short or "
            "damaged, write it again."
        ) from error


def _mesh(lines: list[bytes], vertex: _Vertex, text: str, name: str) -> PlainMesh:
    """All of it; `ValueError` where lines are missing, or have too few words."""
    counts = numbers_in(lines[0], np.int64)
    point_count, face_count = int(counts[0]), int(counts[1])
    if len(counts) > 3 or min(point_count, face_count) < 0:
        raise ValueError("counts")
    rows, polygons = lines[1 : 1 + point_count], lines[1 + point_count :]
    if len(rows) != point_count or len(polygons) != face_count:
        raise ValueError("lines")
    widths = {len(row.split()) for row in rows}
    columns = _columns(rows, 6 if vertex.has_normals else 3)
    sizes, corners, has_colors = _polygons(polygons)
    # Some programs write colors of points without a C in the header.
    colored = vertex._replace(has_colors=vertex.has_colors or _is_colored(widths, vertex))
    lost = colored.lost + (["colors of faces"] if has_colors else [])
    arrays = {"Normals": columns[:, 3:]} if vertex.has_normals else {}
    return PlainMesh(
        columns[:, :3].copy(),
        offsets_of(sizes),
        corners,
        arrays,
        text=text,
        warnings=(not_kept(lost, "OFF", name),) if lost else (),
    )


def _is_colored(widths: set[int], vertex: _Vertex) -> bool:
    plain = 3 + 3 * vertex.has_normals + 2 * vertex.has_texture
    return bool(widths) and min(widths) >= plain + 3


def _columns(rows: list[bytes], count: int) -> NDArray[np.float64]:
    words = [row.split()[:count] for row in rows]
    if any(len(row) != count for row in words):
        raise ValueError("a point of fewer numbers")
    return numbers_in(b" ".join(b" ".join(row) for row in words), np.float64).reshape(-1, count)


def _polygons(rows: list[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int64], bool]:
    """Numbers of corners (m,), the corners, and whether more stands behind them."""
    words = [row.split() for row in rows]
    sizes = numbers_in(b" ".join(row[0] for row in words), np.int64)
    if len(sizes) and sizes.min() < 3:
        raise ValueError("a face of fewer corners")
    parts = [row[1 : 1 + size] for row, size in zip(words, sizes.tolist(), strict=True)]
    corners = numbers_in(b" ".join(b" ".join(part) for part in parts), np.int64)
    if len(corners) != sizes.sum():
        raise ValueError("a face of fewer corners")
    return sizes, corners, any(len(row) > 1 + size for row, size in zip(words, sizes, strict=True))
