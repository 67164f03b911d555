"""STL, binary or ASCII; the solids of an ASCII file are the faces of a model."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, Points, Triangles
from ..formats.text_numbers import numbers_in
from .plain_mesh import PlainMesh, offsets_of

HEADER_SIZE = 80

_ASCII = re.compile(
    rb"\s*solid([^\0]{,1000}?\b(facet|endsolid)\b|[^\0]*\Z)", re.IGNORECASE
)  # the header of a binary file ends, or is followed by a number, with a null character
_FACET_END = re.compile(rb"endfacet", re.IGNORECASE)
_CORNER = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)\s", re.IGNORECASE)
_PART = 2**23  # bytes
_SPACE = re.compile(r"\bSPACE\s*=\s*(RAS|LPS)\b")
_LONGEST_NAME = 10_000  # bytes of a line `endsolid`
_ASCII_FACET = (
    "facet normal %.9g %.9g %.9g\nouter loop\n"
    + 3 * "vertex %.9g %.9g %.9g\n"
    + "endloop\nendfacet\n"
)
_BLOCK = 10_000  # facets that are made text at a time: numbers take more room than text
_TAIL = b"\0 \t\r\n\x1a"  # what programs leave behind the last triangle

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def decode_stl(data: bytes, name: str) -> PlainMesh:
    """Decode STL, binary or ASCII; corners with equal coordinates become one point: a `Decoder`.

    Several solids are the faces of a model; solids of one name are one face, as in OpenFOAM. A
    single solid is the whole model, and its name is the header.
    """
    count_end = HEADER_SIZE + 4
    count = int.from_bytes(data[HEADER_SIZE:count_end], "little") if len(data) >= count_end else 0
    size = count_end + count * _FACET.itemsize
    # The size decides: some binary files begin with "solid" as well. The same four bytes of an
    # ASCII file are letters, and announce gigabytes.
    is_whole = count_end <= size <= len(data)
    if not is_whole and _ASCII.match(data):
        return _decode_ascii(data, name)
    if not is_whole:
        raise InputError(
            f"{name}: expected an STL file of {max(size, count_end)} bytes as its header says, got "
            f"{len(data)}; it is cut short or no STL file, write it again."
        )
    if data[size:].strip(_TAIL):
        raise InputError(
            f"{name}: expected an STL file of {size} bytes as its header says, got {len(data)}; "
            "its number of triangles is damaged, write it again."
        )
    facets = np.frombuffer(data, _FACET, count, count_end)
    points, corners = _merged(facets["corners"].reshape(-1, 3))
    attributes = {"Attribute": facets["attribute"].copy()} if facets["attribute"].any() else {}
    text = data[:HEADER_SIZE].decode("latin-1")
    return PlainMesh(points, offsets_of(np.full(count, 3)), corners, {}, attributes, text=text)


def encode_stl(points: Points, triangles: Triangles, attribute: Any, title: str) -> bytes:
    """Encode binary STL, in single precision.

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
    facets["normal"] = _normals(corners)
    facets["corners"] = corners
    if attribute is not None:
        facets["attribute"] = attribute
    header = title.encode("latin-1", "replace")[:HEADER_SIZE].ljust(HEADER_SIZE, b"\0")
    return header + len(triangles).to_bytes(4, "little") + facets.tobytes()


def encode_solids(
    points: Points, triangles: Triangles, ids: NDArray[Any], names: Mapping[int, str], title: str
) -> bytes:
    """Encode ASCII STL with a solid for each face and all digits of single precision.

    Parameters
    ----------
    points, triangles : arrays, shapes (n, 3) and (m, 3)
    ids : array of int, shape (m,)
        The face of every triangle; the solids come in the order in which these first appear.
    names : mapping of int to str
        Names of the faces that have one.
    title : str
        Text behind the name of the first solid, such as the frame; may be empty.
    """
    corners = points[triangles].astype(np.float32)
    normals = _normals(corners)
    _, first = np.unique(ids, return_index=True)
    parts: list[str] = []
    for number in ids[np.sort(first)].tolist():
        own = ids == number
        name = names.get(number, "")
        rows = np.concatenate([normals[own, None], corners[own]], axis=1)
        parts.append(f"solid {name} {'' if parts else title}".rstrip() + "\n")
        for start in range(0, len(rows), _BLOCK):
            block = rows[start : start + _BLOCK]
            parts.append((_ASCII_FACET * len(block)) % tuple(block.ravel().tolist()))
        parts.append(f"endsolid {name}".rstrip() + "\n")
    return "".join(parts).encode()


def _decode_ascii(data: bytes, name: str) -> PlainMesh:
    try:
        coordinates = np.concatenate(list(_coordinates(data))).reshape(-1, 3)
    except ValueError as error:
        raise InputError(f"{name}: expected numbers as STL corners, got {error}.") from error
    facets = len(_FACET_END.findall(data))
    ends = re.search(rb"endsolid[^\n]*\s*$", data[-_LONGEST_NAME:], re.IGNORECASE)
    if len(coordinates) != 3 * facets or not ends:
        raise InputError(
            f"{name}: expected STL facets of three corners and a last line 'endsolid', got "
            f"{len(coordinates)} corners of {facets} facets; it is cut short, write it again."
        )
    points, corners = _merged(coordinates)
    ids, names = _solids(data, facets)
    text = data.lstrip().split(b"\n", 1)[0].decode("latin-1")
    offsets = offsets_of(np.full(facets, 3))
    return PlainMesh(points, offsets, corners, face_ids=ids, face_names=names, text=text)


def _coordinates(data: bytes) -> Iterator[NDArray[np.float32]]:
    """Coordinates of all corners, a part of the text at a time: words take ten times its memory."""
    start = 0
    # Ends: every part is one byte long at least.
    while start < len(data):
        facet = _FACET_END.search(data, start + _PART)
        end = facet.end() if facet else len(data)
        yield numbers_in(b" ".join(chain.from_iterable(_CORNER.findall(data, start, end))), "f4")
        start = end


def _solids(data: bytes, facets: int) -> tuple[NDArray[np.int32] | None, dict[int, str]]:
    """The solid of every facet, counted from 1, and their names; `None` if there is only one."""
    heads = list(re.finditer(rb"^[ \t]*solid([^\r\n]*)", data, re.IGNORECASE | re.MULTILINE))
    if len(heads) < 2:
        return None, {}
    ends = [head.start() for head in heads[1:]] + [len(data)]
    number_of: dict[str, int] = {}
    numbers, counts = [], []
    for head, end in zip(heads, ends, strict=True):
        title = _SPACE.sub("", head[1].decode("utf-8", "replace"))
        called = " ".join(title.split())
        number = number_of.setdefault(called, len(number_of) + 1) if called else 0
        numbers.append(number)
        counts.append(len(_FACET_END.findall(data, head.end(), end)))
    # Solids without a name are parts of their own, behind those with one.
    nameless = iter(range(len(number_of) + 1, len(number_of) + len(numbers) + 1))
    numbers = [number or next(nameless) for number in numbers]
    names = {number: called for called, number in number_of.items()}
    with_facets = {number for number, count in zip(numbers, counts, strict=True) if count}
    if len(with_facets) < 2 or sum(counts) != facets:
        return None, {}
    ids = np.repeat(np.array(numbers, dtype=np.int32), counts)
    return ids, {number: names[number] for number in with_facets if number in names}


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


def _normals(corners: NDArray[np.float32]) -> NDArray[Any]:
    """Unit normals of facets (m, 3 corners, 3); zero for one without area."""
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)
