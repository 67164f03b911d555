"""Checks at the door, where values of Python itself are extreme."""

import pytest

from SDFStentLib.validation import InputError, as_number


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (
            10**400,
            r"got 1000000000000000000000000000000000000000\.\.\. \(401 characters\); choose such",
        ),
        (
            -(10**400),
            r"got -100000000000000000000000000000000000000\.\.\. \(402 characters\); choose such",
        ),
        (10**5000, "got (a number of thousands of digits|1000)"),  # older Pythons write it
        ("x" * 1000, r"got 'x+\.\.\. \(1002 characters\); choose such"),
    ],
    ids=["large", "negative", "huge", "text"],
)
def test_a_number_that_no_float_can_hold_is_refused_in_a_short_sentence(value, said):
    with pytest.raises(InputError, match=rf"^size: expected a number \(mm\), {said}") as caught:
        as_number(value, "size", unit="mm")
    assert len(str(caught.value)) < 120
