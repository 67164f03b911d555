"""A check of the sizes that a browser announces for its messages, before memory is
taken for them."""

from __future__ import annotations

import struct

LARGEST_UPLOAD = 256 * 2**20
"""Largest size of a file that a browser sends, bytes."""

HEADER = struct.Struct("<III")
"""Header of every chunk of a message: the number of the message, the offset of the chunk and the
length of the whole, bytes."""


class Chunks:
    """The chunks of the messages of one browser: unfinished messages together may have `most`
    bytes.

    The page takes the memory for a whole message when its first chunk comes, whatever that says.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._missing: dict[int, tuple[int, int]] = {}

    def are_bounded(self, chunk: bytes) -> bool:
        """Whether the messages stay within the limit with one more chunk, and the chunk lies within
        its message."""
        if len(chunk) < HEADER.size:
            return False
        number, offset, length = HEADER.unpack_from(chunk)
        length, missing = self._missing.pop(number, (length, length))
        came = len(chunk) - HEADER.size
        if missing > came:
            self._missing[number] = length, missing - came
        promised = sum(whole for whole, _missing in self._missing.values())
        return offset + came <= length and promised <= self._most
