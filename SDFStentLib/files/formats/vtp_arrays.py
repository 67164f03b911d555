"""The arrays of a VTP file: text, base64 or raw bytes, compressed or not.

Source: VTK's file formats, "XML". Nothing is allocated because a number in the file says so: what
is announced is compared with the bytes that are there, and with what the mesh needs.
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

from ...validation import in_short
from .stored_polydata import Kind, StoredArray
from .text_numbers import numbers_in
from .vtp_markup import Element, Markup

STRING, BIT, ID_TYPE = Kind("vtkStringArray", "u1"), Kind("vtkBitArray", "u1"), "vtkIdTypeArray"
_KINDS = {
    "Int8": Kind("vtkSignedCharArray", "i1"), "UInt8": Kind("vtkUnsignedCharArray", "u1"),
    "Int16": Kind("vtkShortArray", "i2"), "UInt16": Kind("vtkUnsignedShortArray", "u2"),
    "Int32": Kind("vtkIntArray", "i4"), "UInt32": Kind("vtkUnsignedIntArray", "u4"),
    "Int64": Kind("vtkTypeInt64Array", "i8"), "UInt64": Kind("vtkTypeUInt64Array", "u8"),
    "Float32": Kind("vtkFloatArray", "f4"), "Float64": Kind("vtkDoubleArray", "f8"),
    "String": STRING, "Bit": BIT,
}  # fmt: skip

_MOST_COMPONENTS = 10_000
_MOST_DIGITS = 15


class Damage(ValueError):
    """What is wrong with an array, as the second half of a sentence."""


@dataclass(frozen=True)
class Encoding:
    """How a file stores its arrays.

    Attributes
    ----------
    order : "<" or ">"
    word : numpy dtype
        Of the numbers before an array.
    decompress : function of (bytes, size) or None
        Makes `size` bytes of one block, or raises `ValueError`.
    markup : Markup
        Where the appended bytes are.
    data : bytes
        The whole file.
    """

    order: str
    word: np.dtype[Any]
    decompress: Callable[[bytes, int], bytes] | None
    markup: Markup
    data: bytes


def encoding_of(markup: Markup, data: bytes) -> Encoding:
    """The encoding that the root element names; `Damage` for an unknown one."""
    attributes = markup.root.attributes
    order = _choice(
        attributes, "byte_order", {"LittleEndian": "<", "BigEndian": ">"}, "LittleEndian"
    )
    word = _choice(attributes, "header_type", {"UInt32": "u4", "UInt64": "u8"}, "UInt32")
    decompress = _choice(attributes, "compressor", _DECOMPRESSORS, "")
    return Encoding(order, np.dtype(order + word), decompress, markup, data)


def read_array(element: Element, count: int | None, encoding: Encoding) -> StoredArray:
    """One array.

    Parameters
    ----------
    element : Element
        `DataArray` or `Array`.
    count : int or None
        Rows that it must have; `None` where the file may choose.
    encoding : Encoding

    Raises
    ------
    Damage
        Unknown type or format, or other data than announced.
    """
    words = element.attributes
    kind = _kind(words)
    components = whole_number(words, "NumberOfComponents", 1)
    if not 1 <= components <= _MOST_COMPONENTS:
        raise Damage(f"expected 1 to {_MOST_COMPONENTS} components, got {components}")
    if count is None and "NumberOfTuples" in words:
        count = whole_number(words, "NumberOfTuples", 0)
    needed = None if count is None else count * components
    values: Any = _values(element, kind, needed, encoding)
    if len(values) % components or (needed is not None and len(values) != needed):
        raise Damage(f"expected {needed or components} values, got {len(values)}")
    names = {
        number: words[f"ComponentName{number}"]
        for number in range(components)
        if f"ComponentName{number}" in words
    }
    if not kind.is_text:
        values = values.reshape(-1, components)
    return StoredArray(words.get("Name"), kind, values, components, names)


def whole_number(words: dict[str, str], key: str, default: int) -> int:
    """A number of the markup that is no less than 0; `Damage` for anything else."""
    text = words.get(key, "").strip() or str(default)
    if not (text.isascii() and text.isdigit() and len(text) <= _MOST_DIGITS):
        raise Damage(f"expected a number from 0 as {key}, got {in_short(text)}")
    return int(text)


def _choice(words: dict[str, str], key: str, known: dict[str, Any], default: str) -> Any:
    value = words.get(key, default)
    if value not in known:
        wanted = ", ".join(filter(None, known))
        raise Damage(f"expected {wanted} as {key}, got {in_short(value)}")
    return known[value]


def _kind(words: dict[str, str]) -> Kind:
    kind: Kind = _choice(words, "type", _KINDS, "")
    if kind.dtype == "i8" and words.get("IdType") == "1":
        return Kind(ID_TYPE, "i8")
    return Kind(ID_TYPE, "i4") if kind.dtype == "i4" and words.get("IdType") == "1" else kind


def _values(
    element: Element, kind: Kind, needed: int | None, encoding: Encoding
) -> NDArray[Any] | list[bytes]:
    """All values of an array in a row."""
    form = element.attributes.get("format", "ascii")
    if form == "ascii":
        return _from_text("".join(element.texts), kind)
    if form == "binary":
        text = "".join(element.texts).encode("ascii", "replace")
        found = _Bytes(b"".join(text.split()), 0, None, False)
    elif form == "appended":
        found = _appended(element, encoding)
    else:
        raise Damage(f"expected ascii, binary or appended as format, got {in_short(form)}")
    if kind.is_text:
        return _strings(found.content(encoding, None))
    if kind.is_bit:
        content = found.content(encoding, None if needed is None else -(-needed // 8))
        return np.unpackbits(np.frombuffer(content, np.uint8))[:needed]
    size = np.dtype(kind.dtype).itemsize
    content = found.content(encoding, None if needed is None else needed * size)
    if len(content) % size:
        raise Damage(f"expected numbers of {size} bytes, got {len(content)} bytes")
    values = np.frombuffer(content, encoding.order + kind.dtype)
    return values.astype(kind.dtype, copy=False)


def _from_text(text: str, kind: Kind) -> NDArray[Any] | list[bytes]:
    try:
        if kind.is_text:  # VTK writes the codes of the letters, some of them as signed ones
            codes = numbers_in(text.encode("ascii", "replace"), np.int16)
            if len(codes) and (codes.min() < -128 or codes.max() > 255):
                raise Damage("expected codes of letters, got larger numbers")
            return _strings((codes % 256).astype(np.uint8).tobytes())
        values = numbers_in(text.encode("ascii", "replace"), kind.dtype)
    except ValueError as error:
        raise (
            error if isinstance(error, Damage) else Damage(f"expected numbers, got {error}")
        ) from error
    return _checked_bits(values) if kind.is_bit else values


def _strings(content: bytes) -> list[bytes]:
    if content and not content.endswith(b"\0"):
        raise Damage("expected texts that end with a null character, got another end")
    return content.split(b"\0")[:-1]


def _checked_bits(values: NDArray[Any]) -> NDArray[Any]:
    if len(values) and values.max() > 1:
        raise Damage(f"expected bits 0 and 1, got {values.max()}")
    return values


def _appended(element: Element, encoding: Encoding) -> _Bytes:
    markup = encoding.markup
    start = markup.start + whole_number(element.attributes, "offset", 0)
    if not markup.start or "offset" not in element.attributes or start >= markup.end:
        raise Damage("expected a place in the appended data, got none")
    return _Bytes(encoding.data, start, markup.end, markup.is_raw)


class _Bytes:
    """Bytes of one array, read one part after the other: raw, or as base64."""

    def __init__(self, data: bytes, start: int, end: int | None, is_raw: bool) -> None:
        self._data, self._at, self._is_raw = data, start, is_raw
        self._end = len(data) if end is None else end

    def content(self, encoding: Encoding, size: int | None) -> bytes:
        """What the array holds, after the words that stand before it: `size` bytes if given."""
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
        """Bytes that are not compressed; their size is coded alone, or together with them."""
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
    """At most one byte more than announced, so that little data cannot fill the memory."""
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
    """Imported late: VTK has the only LZ4 at hand, and few files need it."""
    from .lz4_blocks import from_lz4

    return from_lz4(packed, size)


_DECOMPRESSORS: dict[str, Callable[[bytes, int], bytes] | None] = {
    "": None,
    "vtkZLibDataCompressor": _from_zlib,
    "vtkLZMADataCompressor": _from_lzma,
    "vtkLZ4DataCompressor": _from_lz4,
}
