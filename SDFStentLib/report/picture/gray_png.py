"""A picture in gray as a PNG: what a page shows without anything that renders."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray


def gray_png(gray: NDArray[np.uint8]) -> bytes:
    """The bytes of a PNG file of (rows, columns), 0 is black."""
    rows, columns = gray.shape
    # Eight bits of gray, no palette, not interlaced; each row begins with its filter, none.
    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    body = zlib.compress(np.pad(gray, ((0, 0), (1, 0))).tobytes(), 9)
    parts = ((b"IHDR", head), (b"IDAT", body), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*part) for part in parts)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
