"""Polygons as arrays, and two plain formats that are read into them: STL and OBJ."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...cautions import Caution
from ...validation import InputError, Points, Triangles
from .text_numbers import numbers_in


@dataclass(frozen=True)
class PlainMesh:
    """A mesh of polygons as a plain format has it.

    Attributes
    ----------
    points : (n, 3) array of float32 or float64
        Coordinates in the file's unit and precision.
    offsets : (m + 1,) array of int64
        Polygon i has the corners `corners[offsets[i]:offsets[i + 1]]`.
    corners : array of int64
        Indices into the points; not checked.
    point_arrays, cell_arrays : dict of str to array
        What else the file says of points and polygons.
    text : str
        Header or comments.
    warnings : tuple of Caution
        What the file has that is not kept.
    """

    points: NDArray[Any]
    offsets: NDArray[np.int64]
    corners: NDArray[np.int64]
    point_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    cell_arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    text: str = ""
    warnings: tuple[Caution, ...] = ()


Decoder = Callable[[bytes, str], PlainMesh]
"""Reads the whole of a plain file; the text is what to call it in messages.

`InputError` for bytes that are not of its format, or cut short.
"""


def not_kept(contents: Iterable[str], file_format: str, name: str) -> Caution:
    """What to say of contents of a file that are left behind."""
    numbers = {"contents": ", ".join(contents), "format": file_format}
    return Caution("contents-not-kept", numbers, label=f"{name}: ")


def offsets_of(sizes: ArrayLike) -> NDArray[np.int64]:
    """Offsets (m + 1,) of polygons with these numbers of corners (m,)."""
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, dtype=np.int64))]).astype(np.int64)


HEADER_SIZE = 80

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def decode_stl(data: bytes, name: str) -> PlainMesh:
    """Read STL, binary or ASCII; corners with equal coordinates become one point: a `Decoder`."""
    count_end = HEADER_SIZE + 4
    count = int.from_bytes(data[HEADER_SIZE:count_end], "little") if len(data) >= count_end else 0
    size = count_end + count * _FACET.itemsize
    # Some binary files begin with "solid" as well, so the size decides first.
    if len(data) != size and data.lstrip()[:5].lower() == b"solid":
        return _decode_ascii(data, name)
    if len(data) < max(size, count_end):
        raise InputError(
            f"{name}: expected an STL file of {size} bytes as its header says, got {len(data)}; "
            "it is cut short or no STL file, write it again."
        )
    if data[size:].strip(b"\0 \t\r\n"):
        raise InputError(
            f"{name}: expected an STL file of {size} bytes as its header says, got {len(data)}; "
            "its number of triangles is damaged, write it again."
        )
    facets = np.frombuffer(data, _FACET, count, count_end)
    points, corners = _merged(facets["corners"].reshape(-1, 3))
    attributes = {"Attribute": facets["attribute"].copy()} if facets["attribute"].any() else {}
    text = data[:HEADER_SIZE].decode("latin-1")
    return PlainMesh(points, offsets_of(np.full(count, 3)), corners, {}, attributes, text)


def encode_stl(points: Points, triangles: Triangles, attribute: Any, title: str) -> bytes:
    """Binary STL, single precision.

    Parameters
    ----------
    points, triangles : arrays, shapes (n, 3) and (m, 3)
    attribute : array, shape (m,), or None
        The two bytes that each facet has to spare.
    title : str
        Header, at most 80 characters, not beginning with "solid".
    """
    facets = np.zeros(len(triangles), _FACET)
    corners = points[triangles].astype(np.float32)
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    facets["normal"] = vectors / np.where(lengths > 0, lengths, 1)
    facets["corners"] = corners
    if attribute is not None:
        facets["attribute"] = attribute
    header = title.encode("latin-1", "replace")[:HEADER_SIZE].ljust(HEADER_SIZE, b"\0")
    return header + len(triangles).to_bytes(4, "little") + facets.tobytes()


def _decode_ascii(data: bytes, name: str) -> PlainMesh:
    rows = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)\s", data, re.IGNORECASE)
    facets = len(re.findall(rb"endfacet", data, re.IGNORECASE))
    ends = re.search(rb"endsolid[^\n]*\s*$", data, re.IGNORECASE)
    if len(rows) != 3 * facets or not ends:
        raise InputError(
            f"{name}: expected STL facets of three corners and a last line 'endsolid', got "
            f"{len(rows)} corners of {facets} facets; it is cut short, write it again."
        )
    try:
        coordinates = numbers_in(b" ".join(chain.from_iterable(rows)), np.float32).reshape(-1, 3)
    except ValueError as error:
        raise InputError(f"{name}: expected numbers as STL corners, got {error}.") from error
    points, corners = _merged(coordinates)
    text = data.lstrip().split(b"\n", 1)[0].decode("latin-1")
    return PlainMesh(points, offsets_of(np.full(facets, 3)), corners, text=text)


def _merged(corners: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Distinct points in the order of their first appearance, and the point of every corner."""
    if len(corners) == 0:
        return np.zeros((0, 3), np.float32), np.zeros(0, np.int64)
    order = np.lexsort(corners.T)  # -0 and 0 are equal, also here
    is_new = np.ones(len(corners), dtype=bool)
    is_new[1:] = (corners[order[1:]] != corners[order[:-1]]).any(axis=1)

    # lexsort is stable: the first of each group is the first in the file.
    first = order[is_new]
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    point_of = np.empty(len(corners), dtype=np.int64)
    point_of[order] = rank[np.cumsum(is_new) - 1]
    return corners[np.sort(first)], point_of


_LOST = {b"vt": "texture coordinates", b"vn": "normals", b"usemtl": "materials", b"g": "groups"}


def decode_obj(data: bytes, name: str) -> PlainMesh:
    """Read the points and polygons of an OBJ file, topology as its indices say.

    Corners are joined by point index alone, so that a surface with texture seams or sharp
    normals stays watertight; what is not kept is named in `warnings`.

    `InputError` for a number that is none; else see `Decoder`.
    """
    lines = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()
    point_rows = [line.split()[1:4] for line in lines if line[:2] in (b"v ", b"v\t")]
    face_lines = [line for line in lines if line[:2] in (b"f ", b"f\t")]
    if any(b"/" in line for line in face_lines):  # texture and normal after the point
        face_lines = re.sub(rb"/[^\s]*", b"", b"\n".join(face_lines)).split(b"\n")
    faces = [line.split()[1:] for line in face_lines]
    if not point_rows or data.find(b"\0") >= 0:
        raise InputError(f"{name}: expected an OBJ file with points (v x y z), found none.")
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
    text = "\n".join(line.decode("latin-1") for line in lines[:50] if line[:1] == b"#")
    return PlainMesh(points, offsets_of(sizes), corners, text=text, warnings=_lost(lines, name))


def encode_obj(points: NDArray[np.floating], triangles: Triangles, title: str) -> bytes:
    """OBJ text with all digits of the points' precision.

    Parameters
    ----------
    points : array, shape (n, 3), float32 or float64
    triangles : array, shape (m, 3)
    title : str
        First comment.
    """
    pattern = "v %.9g %.9g %.9g\n" if points.dtype == np.float32 else "v %r %r %r\n"
    parts = [f"# {title}\n"]
    parts.append((pattern * len(points)) % tuple(points.ravel().tolist()))
    parts.append(("f %d %d %d\n" * len(triangles)) % tuple((triangles + 1).ravel().tolist()))
    return "".join(parts).encode("ascii", "replace")


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


def _lost(lines: list[bytes], name: str) -> tuple[Caution, ...]:
    starts = {line[:7] for line in lines if line[:2] not in (b"v ", b"f ")}
    keys = {start.split()[0] for start in starts if start.strip()}
    lost = [words for key, words in _LOST.items() if key in keys]
    return (not_kept(lost, "OBJ", name),) if lost else ()
