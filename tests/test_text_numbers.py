"""Numbers in text: every word a number, or an error."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from SDFStentLib.files.formats.text_numbers import numbers_in

KINDS = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_limits_of_every_integer_type_come_back_and_one_more_does_not(kind):
    limits = np.iinfo(kind)
    for value in (limits.min, limits.max, 0):
        assert numbers_in(f" {value} 1\n".encode(), kind).tolist() == [value, 1]
    for value in (limits.min - 1, limits.max + 1, 10**30):
        with pytest.raises(ValueError, match=r"beyond|word|data"):
            numbers_in(f"1 {value}".encode(), kind)


@given(some.lists(some.floats(allow_nan=False)))
def test_written_floats_come_back_bit_by_bit(values):
    text = " ".join(map(repr, values)).encode()
    assert numbers_in(text, np.float64).tobytes() == np.array(values, float).tobytes()


@given(some.lists(some.text(alphabet="0123456789+-.eExna_ ,\n", max_size=6), max_size=5))
def test_what_is_read_is_what_python_reads_word_by_word(words):
    text = " ".join(words)
    try:
        expected = [float(word) for word in text.split() if "_" not in word or 1 / 0]
    except (ValueError, ZeroDivisionError):
        expected = None
    try:
        found = numbers_in(text.encode(), np.float64).tolist()
    except ValueError:
        found = None
    assert (found is None) == (expected is None)
    assert found is None or np.array_equal(found, expected, equal_nan=True)


@pytest.mark.parametrize("text", [b"1.5", b"1e300", b"nan", b"inf", b"0x10", b"1,2", b"1_0"])
def test_other_words_are_no_integers(text):
    with pytest.raises(ValueError, match=r"word|data|number"):
        numbers_in(text, np.int64)
