"""Whether the binary arrays of a VTP file have the bytes that the words before them announce.

One lost byte shifts all that follows, and VTK takes noise for numbers of blocks: it asks the
machine for gigabytes, or aborts the process. So those words are looked at before VTK gets the file.
Source: VTK's file formats, "XML", the layout of uncompressed and compressed arrays.
"""

from __future__ import annotations

import re
from base64 import b64decode
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...validation import InputError

_TAG = rb"(?:[^>\"']|\"[^\"]*\"|'[^']*')*"
_LISTS = (b"Verts", b"Lines", b"Strips", b"Polys")
_TAGS = re.compile(
    rb"<(Piece|Points|PointData|CellData|FieldData|" + b"|".join(_LISTS) + rb"|Array|DataArray)\b("
    + _TAG + rb")>"
)  # fmt: skip
_ATTRIBUTE = re.compile(rb"([\w_]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
_APPENDED = re.compile(rb"<AppendedData\b(" + _TAG + rb")>\s*_")
_FILE = re.compile(rb"<VTKFile\b(" + _TAG + rb")>")

_INDENT = b"\n  "  # VTK's before the end of appended arrays; as many lost bytes would hide in it

LARGEST_EXPANSION, _LARGEST_EXPANSION_LZMA = 1100, 10_000
"""Bytes that come out of one: zlib and lz4 stay below the first, LZMA below the other."""


class _Place(NamedTuple):
    start: int
    end: int  # of the element that it is in
    is_raw: bool


class _Layout(NamedTuple):
    word: np.dtype[Any]
    expansion: int  # 0 where arrays are not compressed


def check_arrays(data: bytes, name: str) -> None:
    """Check that every binary array of a VTP file fits into it.

    Parameters
    ----------
    data : bytes
        A whole VTP file.
    name : str
        What to call it in messages.

    Raises
    ------
    InputError
        An array that announces more bytes than follow, or more than they can expand to.
    """
    appended = _APPENDED.search(data)
    layout = _layout(_attributes(_FILE.search(data)))
    is_raw = _attributes(appended).get(b"encoding") == b"raw"
    last = data.rfind(b"</AppendedData")
    last -= len(_INDENT) if data.endswith(_INDENT, 0, max(last, 0)) else 0
    counts: dict[bytes, bytes] = {}
    section = b""
    for tag in _TAGS.finditer(data, 0, appended.start() if appended else len(data)):
        words = _attributes(tag, 2)
        if tag[1] == b"Piece":
            counts = words
        elif not tag[1].endswith(b"Array"):
            section = tag[1]
        elif words.get(b"format") in (b"binary", b"appended"):
            # An empty list of cells, where there are cells, makes VTK crash.
            number = counts.get(b"NumberOf" + section, b"")
            least = int(number[:25]) if number.isdigit() and section in _LISTS else 0
            place = _place(words.get(b"offset", b""), appended, last, is_raw)
            if words[b"format"] == b"binary":
                place = _Place(tag.end(), data.find(b"<", tag.end()), False)
            if not (place and least <= _size(data, place, layout)):
                label = words.get(b"Name", b"without a name").decode("utf-8", "replace")
                raise InputError(
                    f"{name}: its array {label} announces more than the file holds, or is empty; "
                    "the file is damaged, write it again."
                )


def _place(
    offset: bytes, appended: re.Match[bytes] | None, last: int, is_raw: bool
) -> _Place | None:
    """Where an appended array begins, and where all of them end; None without such a place."""
    if appended is None or not offset.isdigit():
        return None
    return _Place(appended.end() + int(offset[:25]), last, is_raw)


def _size(data: bytes, place: _Place, layout: _Layout) -> float:
    """Bytes of the array at this place once expanded; -1 when it cannot be whole."""
    first = _words(data, place, 1, layout.word)
    if len(first) == 0:
        return -1
    left = place.end - place.start
    left = (left if place.is_raw else left * 3 // 4) - layout.word.itemsize
    if not layout.expansion or first[0] == 0:
        return float(first[0]) if first[0] <= left else -1
    blocks = int(first[0])
    left -= (2 + blocks) * layout.word.itemsize
    if left < 0:
        return -1
    header = _words(data, place, 3 + blocks, layout.word)
    if len(header) < 3 + blocks:
        return -1
    compressed = float(header[3:].sum(dtype=np.float64))
    expanded = float(header[1]) * (blocks - 1) + float(header[2] or header[1])
    return expanded if compressed <= left and expanded <= layout.expansion * compressed else -1


def _words(data: bytes, place: _Place, count: int, word: np.dtype[Any]) -> NDArray[Any]:
    """The first words at a place, fewer where the file ends or is no base64."""
    size = count * word.itemsize
    start = place.start
    if place.is_raw:
        found = data[start : start + size]
    else:
        letters = 4 * -(-size // 3)
        text = b"".join(data[start : start + 2 * letters + 1000].split())[:letters]
        try:
            found = b64decode(text, validate=True)[:size]
        except ValueError:
            found = b""
    return np.frombuffer(found[: len(found) // word.itemsize * word.itemsize], word)


def _layout(words: dict[bytes, bytes]) -> _Layout:
    order = ">" if words.get(b"byte_order") == b"BigEndian" else "<"
    word = np.dtype(order + ("u8" if words.get(b"header_type") == b"UInt64" else "u4"))
    compressor = words.get(b"compressor", b"")
    if not compressor:
        return _Layout(word, 0)
    return _Layout(word, _LARGEST_EXPANSION_LZMA if b"LZMA" in compressor else LARGEST_EXPANSION)


def _attributes(tag: re.Match[bytes] | None, group: int = 1) -> dict[bytes, bytes]:
    found = _ATTRIBUTE.findall(tag[group]) if tag else ()
    return {key: one or other for key, one, other in found}
