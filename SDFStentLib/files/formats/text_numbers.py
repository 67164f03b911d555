"""Numbers written as text, each checked to be whole and in the range of its type."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

_LONGEST = 100
"""Number of bytes at the end of a text in which its last word is searched."""


def numbers_in(text: bytes, kind: DTypeLike) -> NDArray[Any]:
    """The numbers of a text, separated by blanks and line ends.

    Parameters
    ----------
    text : bytes
    kind : numpy type
        An integer type, or float32 or float64. Text such as `43.0` is an integer, too.

    Returns
    -------
    array, shape (n,), of that type

    Raises
    ------
    ValueError
        A word that is no number, an integer with a fraction or beyond the range of its type.
    """
    dtype = np.dtype(kind)
    if not text.strip():  # NumPy makes a number of nothing
        return np.zeros(0, dtype)
    if dtype.kind == "f":
        with np.errstate(over="ignore"):  # too large for float32: infinity
            return _parsed(text, np.float64).astype(dtype)
    try:
        numbers = _integers(text, dtype)
    except ValueError:
        values = _parsed(text, np.float64)
        # Beyond 2**53 a float is no longer every integer.
        if not (np.abs(values) <= 2.0**53).all() or (values != np.rint(values)).any():
            raise
        numbers = values.astype(np.int64)
    limits = np.iinfo(dtype)
    if len(numbers) and (int(numbers.min()) < limits.min or int(numbers.max()) > limits.max):
        raise ValueError(f"a number is beyond {limits.min} to {limits.max}")
    return numbers.astype(dtype, copy=False)


def _integers(text: bytes, dtype: np.dtype[Any]) -> NDArray[Any]:
    wide = np.dtype(np.uint64 if dtype == np.uint64 else np.int64)
    numbers = _parsed(text, wide)
    # A number that is too large becomes the largest of its type, and a negative one wraps around.
    is_largest = len(numbers) and numbers.max() == np.iinfo(wide).max
    is_least = len(numbers) and wide.kind == "i" and numbers.min() == np.iinfo(wide).min
    if is_largest or is_least or (wide.kind == "u" and b"-" in text):
        try:
            return np.array([int(word) for word in text.split()], dtype=wide)
        except OverflowError as error:
            raise ValueError("a number is beyond 64 bits") from error
    return numbers


def _parsed(text: bytes, kind: DTypeLike) -> NDArray[Any]:
    try:
        numbers = np.fromstring(text, dtype=kind, sep=" ")
    except DeprecationWarning as error:  # an older NumPy that is told to raise its warnings
        raise ValueError(str(error)) from error
    # A NumPy before 2.3 stops silently, also within a word.
    if not _is_whole(text, len(numbers)) or not _is_number(_last_word(text), numbers.dtype.kind):
        raise ValueError("a word is no number")
    return numbers


def _last_word(text: bytes) -> bytes:
    end = text[-_LONGEST:].split() or text.split()
    return end[-1]


def _is_number(word: bytes, kind: str) -> bool:
    try:
        float(word) if kind == "f" else int(word)
    except ValueError:
        return False
    return b"_" not in word


def _is_whole(text: bytes, count: int) -> bool:
    """Whether a text has a given number of words, without making them."""
    is_blank = np.frombuffer(text, np.uint8) <= ord(" ")
    starts = np.count_nonzero(is_blank[:-1] & ~is_blank[1:]) + int(not is_blank[0])
    return bool(starts == count)
