"""The bytes of a VTP file's arrays: raw or as base64, compressed or not.

Source: VTK's file formats, "XML". No memory is allocated because a number in the file says so:
announced sizes are compared with the bytes that are there, and with what the mesh needs.
"""

from __future__ import annotations

import lzma
import zlib
from base64 import b64decode
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .stored_polydata import Damage
from .vtp_markup import Markup


@dataclass(frozen=True)
class Encoding:
    """Storage of the arrays of a file.

    Attributes
    ----------
    order : "<" or ">"
    word : numpy dtype
        Type of the numbers before an array.
    decompress : function of (bytes, size) or None
        Function that makes `size` bytes of one block, or raises `ValueError`.
    markup : Markup
        The parsed file, with the place of the appended bytes.
    data : bytes
        The whole file.
    """

    order: str
    word: np.dtype[Any]
    decompress: Callable[[bytes, int], bytes] | None
    markup: Markup
    data: bytes


class StoredBytes:
    """The bytes of one array, raw or as base64, read one part after the other."""

    def __init__(self, data: bytes, start: int, end: int | None, is_raw: bool) -> None:
        self._data, self._at, self._is_raw = data, start, is_raw
        self._end = len(data) if end is None else end

    def content(self, encoding: Encoding, size: int | None) -> bytes:
        """The contents of the array, after the words before it: `size` bytes if that is given."""
        word = encoding.word
        first = self._peek(word.itemsize)
        number = int(np.frombuffer(first, word)[0])
        if encoding.decompress is None:
            _compare(number, size)
            return self._plain(number, word.itemsize)
        if number == 0:
            _compare(0, size)
            return b""
        if number > (self._end - self._at) // word.itemsize:
            raise Damage(f"expected parts that fit into the file, got {number} of them")
        header = np.frombuffer(self._take((3 + number) * word.itemsize), word)
        full, last = int(header[1]), int(header[2])
        _compare(full * (number - 1) + (last or full), size)
        return self._unpacked(header, encoding.decompress)

    def _plain(self, size: int, before: int) -> bytes:
        """Uncompressed bytes; their size is coded on its own or together with them."""
        padding = b"=" * (-before % 3)
        end = self._at + 4 * -(-before // 3)
        if not self._is_raw and self._data[self._at : end].endswith(padding):
            self._take(before)
            return self._take(size)
        return self._take(before + size)[before:]

    def _unpacked(self, header: NDArray[Any], decompress: Callable[[bytes, int], bytes]) -> bytes:
        full, last, sizes = int(header[1]), int(header[2]), header[3:].astype(np.float64)
        total = float(sizes.sum())
        packed = self._take(int(total) if total < 2**62 else 2**62)
        parts, at = [], 0
        for number, size in enumerate(header[3:].tolist()):
            wanted = last if last and number == len(sizes) - 1 else full
            try:
                part = decompress(packed[at : at + size], wanted)
            except (ValueError, zlib.error, lzma.LZMAError, EOFError) as error:
                raise Damage(f"expected compressed data, got damaged ones ({error})") from error
            if len(part) != wanted:
                raise Damage(f"expected {wanted} bytes in a part, got {len(part)}")
            parts.append(part)
            at += size
        return b"".join(parts)

    def _peek(self, size: int) -> bytes:
        at = self._at
        found = self._take(size)
        self._at = at
        return found

    def _take(self, size: int) -> bytes:
        """The next bytes; base64 begins anew with each call, as VTK writes it."""
        length = size if self._is_raw else 4 * -(-size // 3)
        if length > self._end - self._at:
            raise Damage(f"expected {size} bytes, got the end of the data")
        coded = self._data[self._at : self._at + length]
        self._at += length
        if self._is_raw:
            return coded
        try:
            found = b64decode(coded, validate=True)
        except ValueError as error:
            raise Damage(f"expected base64, got other letters ({error})") from error
        if len(found) < size:
            raise Damage(f"expected {size} bytes of base64, got {len(found)}")
        return found[:size]


def _compare(announced: int, size: int | None) -> None:
    if size is not None and announced != size:
        raise Damage(f"expected {size} bytes, got {announced}")


def _from_zlib(packed: bytes, size: int) -> bytes:
    """Decompressed bytes, at most one more than announced, so that little data cannot fill the
    memory."""
    engine = zlib.decompressobj()
    found = engine.decompress(packed, size + 1)
    if not engine.eof and len(found) == size:
        engine.decompress(engine.unconsumed_tail, 1)
    if not engine.eof:
        raise ValueError("it does not end")
    return found


def _from_lzma(packed: bytes, size: int) -> bytes:
    engine = lzma.LZMADecompressor()
    found = engine.decompress(packed, size + 1)
    if not engine.eof and len(found) <= size:
        found += engine.decompress(b"", 1)
    return found


def _from_lz4(packed: bytes, size: int) -> bytes:
    """Decompressed bytes; imported late, as VTK has the only LZ4 at hand and few files need it."""
    from .vtk_quiet import from_lz4

    return from_lz4(packed, size)


DECOMPRESSORS: dict[str, Callable[[bytes, int], bytes] | None] = {
    "": None,
    "vtkZLibDataCompressor": _from_zlib,
    "vtkLZMADataCompressor": _from_lzma,
    "vtkLZ4DataCompressor": _from_lz4,
}
