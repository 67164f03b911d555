"""PLY: points and polygons with any number of properties, ASCII or binary."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, Triangles
from ..content import kind_in_words
from .plain_mesh import PlainMesh, not_kept, offsets_of
from .text_numbers import numbers_in

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


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    count_kind: str | None  # of a list


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property]


def decode_ply(data: bytes, name: str) -> PlainMesh:
    """Read PLY; every scalar property becomes an array of its own name and type.

    `nx ny nz` become the array `Normals`. Lists other than the faces' corners are left out,
    with a warning; so are elements other than vertex and face.

    `InputError` for a file without points; else see `Decoder`.
    """
    order, elements, comments, start = _header(data, name)
    columns: dict[str, dict[str, Any]] = {}
    try:
        body: Any = data[start:].split() if order == "" else memoryview(data)[start:]
        for element in elements:
            columns[element.name], body = _read_element(element, body, order)
    except (ValueError, IndexError, OverflowError, MemoryError) as error:
        raise InputError(
            f"{name}: its data end before or do not fit its PLY header; it is cut short or "
            "damaged, write it again."
        ) from error

    vertex, face = columns.get("vertex", {}), columns.get("face", {})
    if not {"x", "y", "z"} <= set(vertex):
        raise InputError(f"{name}: expected PLY vertices with x, y and z, found none.")
    points = np.stack([vertex.pop(axis) for axis in "xyz"], axis=1)
    if points.dtype.kind != "f":
        points = points.astype(np.float64)
    corners = face.pop("vertex_indices", face.pop("vertex_index", None))
    offsets, corners = corners or (np.zeros(1, np.int64), np.zeros(0, np.int64))
    lost = [key for key, values in face.items() if isinstance(values, tuple)]
    lost += [key for key in columns if key not in ("vertex", "face")]
    warnings = (not_kept(lost, "PLY", name),) if lost else ()
    if set(_NORMAL) <= set(vertex):
        vertex["Normals"] = np.stack([vertex.pop(axis) for axis in _NORMAL], axis=1)
    cells = {key: values for key, values in face.items() if not isinstance(values, tuple)}
    return PlainMesh(points, offsets, corners, vertex, cells, "\n".join(comments), warnings)


def encode_ply(
    points: NDArray[Any],
    triangles: Triangles,
    point_arrays: dict[str, NDArray[Any]],
    cell_arrays: dict[str, NDArray[Any]],
    comment: str,
) -> bytes:
    """Binary little-endian PLY.

    Parameters
    ----------
    points : array, shape (n, 3), float32 or float64
    triangles : array, shape (m, 3)
    point_arrays, cell_arrays : dict of name to array, shapes (n,) and (m,)
        Only what `fits_ply` accepts; `Normals` (n, 3) of the points is written as `nx ny nz`.
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
    """Whether an array can be a property: one number of a PLY type each, a name of one word."""
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


def _header(data: bytes, name: str) -> tuple[str, list[_Element], list[str], int]:
    end = re.search(rb"^end_header[ \t]*\r?\n", data, re.MULTILINE)
    if not data.startswith(b"ply"):
        raise InputError(f"{name}: expected a PLY file, got {kind_in_words(data)}.")
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
                elements.append(_Element(words[1], _count(words[2]), []))
            elif words[0] == "property" and words[1] == "list":
                listed = _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
                elements[-1].properties.append(listed)
            else:
                elements[-1].properties.append(_Property(words[2], _TYPES[words[1]], None))
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


def _read_element(element: _Element, body: Any, order: str) -> tuple[dict[str, Any], Any]:
    """The columns of one element and what follows it; lists become (offsets, values)."""
    if element.count == 0 or not element.properties:
        return {}, body
    # The usual case: every row has lists as long as those of the first one.
    first = _read_rows(element, body, order, 1)[0]
    sizes = [len(first[p.name][1]) if p.count_kind else 1 for p in element.properties]
    if order == "":
        return _ascii_columns(element, body, sizes) or _read_rows(element, body, order)
    return _binary_columns(element, body, order, sizes) or _read_rows(element, body, order)


def _ascii_columns(element: _Element, tokens: list[bytes], sizes: list[int]) -> Any:
    widths = [s + bool(p.count_kind) for p, s in zip(element.properties, sizes, strict=True)]
    needed = element.count * sum(widths)
    if len(tokens) < needed:
        return None
    columns: dict[str, Any] = {}
    at, row = 0, sum(widths)
    for listed, size, width in zip(element.properties, sizes, widths, strict=True):
        if listed.count_kind:
            if set(tokens[at:needed:row]) != {b"%d" % size}:
                return None
            # One column of tokens after the other, then as rows again.
            parts = [tokens[at + part : needed : row] for part in range(1, width)]
            values = [numbers_in(b" ".join(part), listed.kind) for part in parts]
            corners = np.stack(values, axis=1) if values else np.zeros(0)
            offsets = size * np.arange(element.count + 1)
            columns[listed.name] = (offsets, corners.ravel().astype(np.int64))
        else:
            columns[listed.name] = numbers_in(b" ".join(tokens[at:needed:row]), listed.kind)
        at += width
    return columns, tokens[needed:]


def _binary_columns(element: _Element, body: memoryview, order: str, sizes: list[int]) -> Any:
    fields: list[Any] = []
    for position, (listed, size) in enumerate(zip(element.properties, sizes, strict=True)):
        if listed.count_kind:
            fields.append((f"count {position}", order + listed.count_kind))
        fields.append((f"{position}", order + listed.kind, (size,) if listed.count_kind else ()))
    row = np.dtype(fields)
    if len(body) < element.count * row.itemsize:
        return None
    table = np.frombuffer(body, row, element.count)
    columns: dict[str, Any] = {}
    for position, (listed, size) in enumerate(zip(element.properties, sizes, strict=True)):
        values = table[f"{position}"]
        if not listed.count_kind:
            columns[listed.name] = values.astype(listed.kind)
        elif (table[f"count {position}"] != size).any():
            return None
        else:
            offsets = size * np.arange(element.count + 1)
            columns[listed.name] = (offsets, values.ravel().astype(np.int64))
    return columns, body[element.count * row.itemsize :]


def _read_rows(
    element: _Element, body: Any, order: str, count: int | None = None
) -> tuple[dict[str, Any], Any]:
    """Row by row, for lists of different lengths; `ValueError` where the data end."""
    at = 0

    def take(kind: str, number: int) -> NDArray[Any]:
        nonlocal at
        if number < 0:
            raise ValueError("negative length of a list")
        if order == "":
            found = numbers_in(b" ".join(body[at : at + number]), kind)
            at += number
        else:
            dtype = np.dtype(order + kind)
            found = np.frombuffer(body[at : at + number * dtype.itemsize], dtype)
            at += number * dtype.itemsize
        if len(found) != number or at > len(body):
            raise ValueError("data end")
        return found

    rows = element.count if count is None else count
    values: dict[str, list[Any]] = {listed.name: [] for listed in element.properties}
    for _ in range(rows):
        for listed in element.properties:
            number = int(take(listed.count_kind, 1)[0]) if listed.count_kind else 1
            values[listed.name].append(take(listed.kind, number))
    columns: dict[str, Any] = {}
    for listed in element.properties:
        joined = np.concatenate(values[listed.name])
        if listed.count_kind:
            sizes = [len(part) for part in values[listed.name]]
            columns[listed.name] = (offsets_of(sizes), joined.astype(np.int64))
        else:
            columns[listed.name] = joined.astype(listed.kind)
    return columns, body[at:]
