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

from .validation import InputError

_TAG = rb"(?:[^>\"']|\"[^\"]*\"|'[^']*')*"
_ARRAY = re.compile(rb"<(?:Data)?Array\b(" + _TAG + rb")>")
_ATTRIBUTE = re.compile(rb"([\w_]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
_APPENDED = re.compile(rb"<AppendedData\b(" + _TAG + rb")>\s*_")
_FILE = re.compile(rb"<VTKFile\b(" + _TAG + rb")>")

# Bytes that come out of one: zlib and lz4 stay below the first, LZMA below the other.
_LARGEST_EXPANSION, _LARGEST_EXPANSION_LZMA = 1100, 10_000


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
    for array in _ARRAY.finditer(data, 0, appended.start() if appended else len(data)):
        words = _attributes(array)
        if words.get(b"format") == b"binary":
            is_whole = _is_whole(data, array.end(), layout, is_raw=False)
        elif words.get(b"format") == b"appended":
            offset = words.get(b"offset", b"")
            is_whole = appended is not None and offset.isdigit()
            if appended and is_whole:
                is_whole = _is_whole(data, appended.end() + int(offset[:25]), layout, is_raw)
        else:
            continue
        if not is_whole:
            label = words.get(b"Name", b"without a name").decode("utf-8", "replace")
            raise InputError(
                f"{name}: its array {label} announces more than the file holds; the file is "
                "damaged, write it again."
            )


def _is_whole(data: bytes, start: int, layout: _Layout, is_raw: bool) -> bool:
    """Whether the array at this place fits into what follows it."""
    first = _words(data, start, 1, layout.word, is_raw)
    if len(first) == 0:
        return False
    left = max(len(data) - start, 0)  # base64 takes more than that, so that this bounds both
    if not layout.expansion or first[0] == 0:
        return int(first[0]) <= left
    blocks = int(first[0])
    if blocks * layout.word.itemsize > left:
        return False
    header = _words(data, start, 3 + blocks, layout.word, is_raw)
    if len(header) < 3 + blocks:
        return False
    compressed = float(header[3:].sum(dtype=np.float64))
    expanded = float(header[1]) * (blocks - 1) + float(header[2] or header[1])
    return compressed <= left and expanded <= layout.expansion * compressed


def _words(data: bytes, start: int, count: int, word: np.dtype[Any], is_raw: bool) -> NDArray[Any]:
    """The first words at a place, fewer where the file ends or is no base64."""
    size = count * word.itemsize
    if is_raw:
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
    return _Layout(word, _LARGEST_EXPANSION_LZMA if b"LZMA" in compressor else _LARGEST_EXPANSION)


def _attributes(tag: re.Match[bytes] | None) -> dict[bytes, bytes]:
    found = _ATTRIBUTE.findall(tag.group(1)) if tag else ()
    return {key: one or other for key, one, other in found}
