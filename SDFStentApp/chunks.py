"""What a browser says of the size of its messages, before memory is taken for them."""

from __future__ import annotations

import struct

LARGEST_UPLOAD = 256 * 2**20
"""Of a file that a browser sends, bytes."""

HEADER = struct.Struct("<III")
"""In front of every chunk of a message: a number of the message, where the chunk begins, and how long the whole is, bytes."""


class Chunks:
    """Of the messages of one browser: together they may be `most` bytes long until they are there.

    The page takes the memory for a whole message when its first chunk comes, whatever that says.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._missing: dict[int, tuple[int, int]] = {}

    def are_bounded(self, chunk: bytes) -> bool:
        """Whether they are with one more chunk, which lies within its message."""
        if len(chunk) < HEADER.size:
            return False
        number, offset, length = HEADER.unpack_from(chunk)
        length, missing = self._missing.pop(number, (length, length))
        came = len(chunk) - HEADER.size
        if missing > came:
            self._missing[number] = length, missing - came
        told = sum(whole for whole, _missing in self._missing.values())
        return offset + came <= length and told <= self._most
