"""The arrays of a VTP file: from its markup and text, or from bytes, to numbers and names.

Source: VTK's file formats, "XML".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...validation import in_short
from .stored_polydata import Damage, Kind, StoredArray
from .text_numbers import numbers_in
from .vtp_bytes import DECOMPRESSORS, Encoding, StoredBytes
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


def encoding_of(markup: Markup, data: bytes) -> Encoding:
    """The encoding that the root element names; `Damage` for an unknown one."""
    attributes = markup.root.attributes
    order = _choice(
        attributes, "byte_order", {"LittleEndian": "<", "BigEndian": ">"}, "LittleEndian"
    )
    word = _choice(attributes, "header_type", {"UInt32": "u4", "UInt64": "u8"}, "UInt32")
    decompress = _choice(attributes, "compressor", DECOMPRESSORS, "")
    return Encoding(order, np.dtype(order + word), decompress, markup, data)


def read_array(element: Element, count: int | None, encoding: Encoding) -> StoredArray:
    """Decode one array.

    Parameters
    ----------
    element : Element
        `DataArray` or `Array`.
    count : int or None
        Number of rows that it must have; `None` where the file may choose.
    encoding : Encoding

    Raises
    ------
    Damage
        Unknown type or format, or data other than announced.
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
    """Number of the markup, at least 0; `Damage` for anything else."""
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
    """Values of an array, in a single row."""
    form = element.attributes.get("format", "ascii")
    if form == "ascii":
        return _from_text("".join(element.texts), kind)
    if form == "binary":
        text = "".join(element.texts).encode("ascii", "replace")
        found = StoredBytes(b"".join(text.split()), 0, None, False)
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


def _appended(element: Element, encoding: Encoding) -> StoredBytes:
    markup = encoding.markup
    start = markup.start + whole_number(element.attributes, "offset", 0)
    if not markup.start or "offset" not in element.attributes or start >= markup.end:
        raise Damage("expected a place in the appended data, got none")
    return StoredBytes(encoding.data, start, markup.end, markup.is_raw)
