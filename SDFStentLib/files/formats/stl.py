"""STL: triangles without topology, which comes back by merging equal corners."""

from __future__ import annotations

import re
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError, Points, Triangles
from .plain_mesh import PlainMesh, offsets_of
from .text_numbers import numbers_in

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
