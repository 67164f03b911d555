"""PLY: points and polygons with any number of properties, ASCII or binary."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...cautions import Caution
from ...validation import InputError, Triangles
from ..recognized import in_words
from .plain_mesh import PlainMesh, not_kept
from .ply_rows import PlyElement, Property, read_element

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint",
          "f4": "float", "f8": "double"}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_NORMAL = ("nx", "ny", "nz")
_CORNERS = ("vertex_indices", "vertex_index", "n", "corners")  # PLY's and our own words


def decode_ply(data: bytes, name: str) -> PlainMesh:
    """Decode PLY; every scalar property becomes an array of its own name and type.

    `nx ny nz` become the array `Normals`. Strips of triangles (`tristrips`) are cut. Lists other
    than the corners are left out, with a warning, and so are elements other than these.

    `InputError` for a file without points; else see `Decoder`.
    """
    order, elements, comments, start = _header(data, name)
    columns: dict[str, dict[str, Any]] = {}
    try:
        body: Any = data[start:].split() if order == "" else memoryview(data)[start:]
        for element in elements:
            columns[element.name], body = read_element(element, body, order)
    except (ValueError, IndexError, OverflowError, MemoryError) as error:
        raise InputError(
            f"{name}: its data end before or do not fit its PLY header; it is cut short or "
            "damaged, write it again."
        ) from error

    vertex, face = columns.pop("vertex", {}), columns.pop("face", {})
    strips = columns.pop("tristrips", {})
    lost = _without_lists(vertex)
    if not {"x", "y", "z"} <= set(vertex):
        raise InputError(f"{name}: expected PLY vertices with x, y and z, found none.")
    points = np.stack([vertex.pop(axis) for axis in "xyz"], axis=1)
    if points.dtype.kind != "f":
        points = points.astype(np.float64)
    if set(_NORMAL) <= set(vertex):
        vertex["Normals"] = np.stack([vertex.pop(axis) for axis in _NORMAL], axis=1)
    offsets, corners = _lists(face, name)
    lost += _without_lists(face)
    cut: tuple[Caution, ...] = ()
    if strips:
        strip_offsets, strip_corners = _lists(strips, name)
        triangles, count = _cut_strips(strip_offsets, strip_corners)
        offsets = np.concatenate([offsets, offsets[-1] + 3 * np.arange(1, len(triangles) + 1)])
        corners = np.concatenate([corners, triangles.ravel()])
        counts: dict[str, float | str] = {"polygons": count, "triangles": len(triangles)}
        cut = (Caution("polygons-cut", counts, label=f"{name}: "),)
        lost += [*face, *_without_lists(strips), *strips]
        face = {}  # what is known of faces alone fits no triangle of a strip
    lost += [key for key, values in columns.items() if values]
    warnings = (*cut, not_kept(lost, "PLY", name)) if lost else cut
    text = "\n".join(comments)
    return PlainMesh(points, offsets, corners, vertex, face, text=text, warnings=warnings)


def _lists(element: dict[str, Any], name: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Offsets and corners of an element's polygons, taken out of it; empty if it has none."""
    for key in ("vertex_indices", "vertex_index"):
        if isinstance(element.get(key), tuple):
            offsets, corners = element.pop(key)
            if corners.dtype.kind == "f" and not (corners == np.rint(corners)).all():
                raise InputError(f"{name}: expected point indices in its faces, got fractions.")
            return offsets, corners.astype(np.int64)
    return np.zeros(1, np.int64), np.zeros(0, np.int64)


def _without_lists(element: dict[str, Any]) -> list[str]:
    """Names of an element's lists, which are taken out: they are no arrays of one number each."""
    lists = [key for key, values in element.items() if isinstance(values, tuple)]
    for key in lists:
        del element[key]
    return lists


def _cut_strips(offsets: NDArray[np.int64], corners: NDArray[np.int64]) -> tuple[Triangles, int]:
    """Triangles (m, 3) of strips, every second one turned, and the number of strips.

    A -1 ends a strip within its list. Triangles that only lead from one strip to the next repeat a
    corner and are left out.
    """
    is_start = np.zeros(len(corners) + 1, dtype=bool)
    is_start[offsets[:-1]] = True
    is_start[1:] |= corners == -1
    start = np.maximum.accumulate(np.where(is_start, np.arange(len(corners) + 1), 0))[:-1]
    windows = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    place = np.arange(len(windows)) - start[: len(windows)]
    is_whole = (start[: len(windows)] == start[2:]) & (windows != -1).all(axis=1)
    place, windows = place[is_whole], windows[is_whole]
    windows[place % 2 == 1] = windows[place % 2 == 1][:, [1, 0, 2]]
    a, b, c = windows.T
    count = len(np.unique(start[: len(is_whole)][is_whole]))
    return windows[(a != b) & (b != c) & (c != a)], count


def encode_ply(
    points: NDArray[Any],
    triangles: Triangles,
    point_arrays: dict[str, NDArray[Any]],
    cell_arrays: dict[str, NDArray[Any]],
    comment: str,
) -> bytes:
    """Encode binary little-endian PLY.

    Parameters
    ----------
    points : array, shape (n, 3), float32 or float64
    triangles : array, shape (m, 3)
    point_arrays, cell_arrays : dict of name to array, shapes (n,) and (m,)
        Arrays that `fits_ply` accepts; `Normals` (n, 3) of the points become `nx ny nz`.
    comment : str
    """
    vertex = dict(zip("xyz", points.T, strict=True))
    for key, values in point_arrays.items():
        vertex.update(zip(_NORMAL, values.T, strict=True) if values.ndim == 2 else [(key, values)])
    rows = _table(vertex, len(points))
    corners: dict[str, Any] = {"n": np.full(len(triangles), 3, np.uint8), "corners": triangles}
    faces = _table(corners | cell_arrays, len(triangles), {"corners": ("<i4", 3)})

    header = ["ply", "format binary_little_endian 1.0", f"comment {comment}"]
    header.append(f"element vertex {len(points)}")
    header += [f"property {_ply_name(vertex[key].dtype)} {key}" for key in vertex]
    header.append(f"element face {len(triangles)}")
    header.append("property list uchar int vertex_indices")
    header += [f"property {_ply_name(cell_arrays[key].dtype)} {key}" for key in cell_arrays]
    header.append("end_header\n")
    return "\n".join(header).encode("ascii", "replace") + rows.tobytes() + faces.tobytes()


def fits_ply(name: str, values: NDArray[Any], *, of_points: bool) -> bool:
    """Whether an array can be a property: a one-word name, and one number of a PLY type per row."""
    if values.dtype.kind not in "iuf" or values.dtype.str[1:] not in _NAMES:
        return False
    if of_points and name == "Normals" and values.shape[1:] == (3,):
        return True
    is_taken = name in (*"xyz", *_NORMAL) if of_points else name in _CORNERS
    return not is_taken and values.ndim == 1 and re.fullmatch(r"[!-~]+", name) is not None


def _table(
    columns: dict[str, Any], count: int, kinds: dict[str, tuple[str, int]] | None = None
) -> NDArray[Any]:
    fields: list[Any] = []
    for key, values in columns.items():
        special = (kinds or {}).get(key)
        fields.append((key, *special) if special else (key, values.dtype.newbyteorder("<")))
    table = np.empty(count, dtype=fields)
    for key, values in columns.items():
        table[key] = values
    return table


def _ply_name(dtype: np.dtype[Any]) -> str:
    return _NAMES[dtype.str[1:]]


def _header(data: bytes, name: str) -> tuple[str, list[PlyElement], list[str], int]:
    end = re.search(rb"^end_header[ \t]*\r?\n", data, re.MULTILINE)
    if not data.startswith(b"ply"):
        raise InputError(f"{name}: expected a PLY file, got {in_words(data)}.")
    if not end:
        raise InputError(f"{name}: expected a header that ends, got a part of one; save it again.")
    order, elements, comments = None, [], []
    for line in data[: end.start()].decode("latin-1").splitlines()[1:]:
        words = line.split()
        try:
            if not words or words[0] == "obj_info":
                continue
            if words[0] == "comment":
                comments.append(line)
            elif words[0] == "format":
                order = _ORDERS[words[1]]
            elif words[0] == "element":
                elements.append(PlyElement(words[1], _count(words[2]), []))
            elif words[0] == "property" and words[1] == "list":
                listed = Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
                elements[-1].properties.append(listed)
            else:
                elements[-1].properties.append(Property(words[2], _TYPES[words[1]], None))
        except (KeyError, IndexError, ValueError) as error:
            raise InputError(f"{name}: its PLY header has a line {line!r}, damaged.") from error
    if order is None:
        raise InputError(f"{name}: expected a line 'format' in its PLY header, found none.")
    return order, elements, comments, end.end()


def _count(word: str) -> int:
    count = int(word)
    if count < 0:
        raise ValueError("negative")
    return count
