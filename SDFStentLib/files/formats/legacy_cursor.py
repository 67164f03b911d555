"""A cursor in a legacy VTK file that advances with every word and number taken."""

from __future__ import annotations

import re
from functools import cached_property
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ...validation import in_short
from .stored_polydata import Damage
from .text_numbers import numbers_in

_WORD = re.compile(rb"\s*(\S{0,1000})")
_LONGEST_LINE = 100_000
_MOST_DIGITS = 15


class LegacyCursor:
    """Reads words and numbers of a file from a given place on.

    Parameters
    ----------
    data : bytes
    start : int
    is_text : bool
        Whether numbers are written as text; otherwise they are big-endian.
    """

    def __init__(self, data: bytes, start: int, *, is_text: bool) -> None:
        self._data, self._at, self._is_text = data, start, is_text

    def word(self) -> str:
        """The next word; empty at the end of the file."""
        found = self._match()
        self._at = found.end()
        return found[1].decode("latin-1")

    def next_is(self, word: str) -> bool:
        """Whether the next word is a given one, in upper or lower case."""
        return self._match()[1].upper() == word.encode()

    def skip(self, word: str) -> bool:
        """Take the next word if it is a given one; return whether it was."""
        is_next = self.next_is(word)
        return is_next and bool(self.word())

    def name(self) -> str:
        """The next word as a name, in which VTK writes blanks as %20."""
        word = self.word()
        if not word:
            raise Damage("expected the name of an array, got the end of the file")
        return unquote_to_bytes(word.encode("latin-1")).decode("utf-8", "surrogateescape")

    def count(self) -> int:
        """The next word as a number that is 0 or more."""
        word = self.word()
        if not (word.isascii() and word.isdigit() and len(word) <= _MOST_DIGITS):
            raise Damage(f"expected a number from 0, got {in_short(word) if word else 'the end'}")
        return int(word)

    def numbers(self, count: int, dtype: str) -> NDArray[Any]:
        """The next numbers, in the byte order of this machine."""
        if not self._is_text:
            return np.frombuffer(self._bytes(count * np.dtype(dtype).itemsize), ">" + dtype).astype(
                dtype
            )
        text = self._words(count)
        try:
            values = numbers_in(text, dtype)
        except ValueError as error:
            raise Damage(f"expected {count} numbers, got {error}") from error
        if len(values) != count:
            raise Damage(f"expected {count} numbers, got {len(values)}")
        return values

    def bits(self, count: int) -> NDArray[np.uint8]:
        """The next bits, one number each."""
        if not self._is_text:
            return np.unpackbits(np.frombuffer(self._bytes(-(-count // 8)), np.uint8))[:count]
        values = self.numbers(count, "u1")
        if count and values.max() > 1:
            raise Damage(f"expected bits 0 and 1, got {values.max()}")
        return values

    def colors(self, count: int) -> NDArray[np.uint8]:
        """The next color components: bytes, or in text numbers from 0 to 1."""
        if not self._is_text:
            return self.numbers(count, "u1")
        values = self.numbers(count, "f4")
        if not ((values >= 0) & (values <= 1)).all():
            raise Damage("expected colors from 0 to 1, got others")
        return (values * np.float32(255) + np.float32(0.5)).astype(np.uint8)

    def strings(self, count: int) -> list[bytes]:
        """The next texts: one a line, or each after its length."""
        if count > len(self._data) - self._at:
            raise Damage(f"expected {count} texts, got the end of the file")
        self._end_line()
        if self._is_text:
            return [unquote_to_bytes(self._line()) for _ in range(count)]
        return [self._counted_string() for _ in range(count)]

    def metadata(self, components: int) -> dict[int, str]:
        """The names of components; anything else up to the next empty line is left out."""
        names: dict[int, str] = {}
        self._end_line()
        # Ends: every line moves on in the data.
        while self._at < len(self._data) and (line := self._line().strip()):
            if line == b"COMPONENT_NAMES":
                found = [unquote_to_bytes(self._line()) for _ in range(components)]
                texts = [text.decode("utf-8", "surrogateescape") for text in found]
                names = dict(enumerate(texts))
        return names

    @cached_property
    def _word_starts(self) -> NDArray[np.int64]:
        is_blank = np.frombuffer(self._data, np.uint8) <= ord(" ")
        return np.flatnonzero(is_blank[:-1] & ~is_blank[1:]) + 1

    def _match(self) -> re.Match[bytes]:
        found = _WORD.match(self._data, self._at)
        if found is None or (
            len(found[1]) == 1000 and not self._data[found.end() : found.end() + 1].isspace()
        ):
            raise Damage("expected words, got one of more than 1000 letters")
        return found

    def _words(self, count: int) -> bytes:
        """The text of the next words, without looking at each of them."""
        if count == 0:
            return b""
        first = int(np.searchsorted(self._word_starts, self._at))
        if first + count > len(self._word_starts):
            left = len(self._word_starts) - first
            raise Damage(f"expected {count} numbers, got {left} words up to the end of the file")
        start = self._at
        is_last = first + count == len(self._word_starts)
        self._at = len(self._data) if is_last else int(self._word_starts[first + count]) - 1
        return self._data[start : self._at]

    def _bytes(self, size: int) -> bytes:
        self._end_line()
        if size > len(self._data) - self._at:
            left = len(self._data) - self._at
            raise Damage(f"expected {size} bytes, got {left} up to the end of the file")
        self._at += size
        return self._data[self._at - size : self._at]

    def _end_line(self) -> None:
        """Advance to the line after that of a header."""
        if self._at < len(self._data) and self._line().strip():
            raise Damage("expected the end of a line, got more words")

    def _line(self) -> bytes:
        end = self._data.find(b"\n", self._at, self._at + _LONGEST_LINE)
        if end < 0 and len(self._data) - self._at > _LONGEST_LINE:
            raise Damage(f"expected lines, got one of more than {_LONGEST_LINE} letters")
        start, self._at = self._at, len(self._data) if end < 0 else end + 1
        if start == len(self._data):
            raise Damage("expected another line, got the end of the file")
        return self._data[start : len(self._data) if end < 0 else end].rstrip(b"\r")

    def _counted_string(self) -> bytes:
        """A text after its length in 1, 2, 4 or 8 bytes; its first two bits encode how many."""
        if self._at >= len(self._data):
            raise Damage("expected another text, got the end of the file")
        width = (8, 4, 2, 1)[self._data[self._at] >> 6]
        words = self._data[self._at : self._at + width]
        length = int.from_bytes(words, "big") & ((1 << (8 * width - 2)) - 1)
        self._at += width + length
        if self._at > len(self._data):
            raise Damage("expected another text, got the end of the file")
        return self._data[self._at - length : self._at]
