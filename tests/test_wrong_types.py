"""Every public function with something that it does not take: a sentence, not a Python error."""

from __future__ import annotations

import contextlib
import inspect
import sys
from unicodedata import category

import numpy as np
import pytest

import SDFStentLib
from SDFStentLib import Stent
from SDFStentLib.cautions import Caution
from SDFStentLib.cli.console import Console, error_line
from SDFStentLib.validation import InputError, as_number, one_line

WRONG = [
    None, "8", b"x", 3, 3.5, float("nan"), [], {}, object(), np.zeros((2, 2)), [None], 1e400, -1,
    True, "\ud800", np.array(["a"]),
]  # fmt: skip


def public_callables():
    for name in SDFStentLib.__all__:
        value = getattr(SDFStentLib, name)
        is_error = inspect.isclass(value) and issubclass(value, BaseException)
        if callable(value) and not is_error and value is not Stent:
            yield name


@pytest.mark.parametrize("name", list(public_callables()))
def test_a_wrong_argument_is_said_in_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function = getattr(SDFStentLib, name)
    needed = [
        parameter
        for parameter in inspect.signature(function).parameters.values()
        if parameter.default is parameter.empty and parameter.kind.name.startswith("POSITIONAL")
    ]
    for value in WRONG:
        with contextlib.suppress(InputError):
            function(*[value] * len(needed))


@pytest.mark.parametrize("kind", ["Cc", "Zl", "Zp", "Cs"])
def test_no_character_that_controls_or_is_half_of_one_is_left(kind):
    """The classes of Unicode; of its formats (Cf) those that turn the direction of writing."""
    every = "".join(c for c in map(chr, range(sys.maxunicode + 1)) if category(c) == kind)
    left = one_line(every + "\N{RIGHT-TO-LEFT MARK}\N{ARABIC LETTER MARK}\N{LEFT-TO-RIGHT MARK}")
    assert left.isprintable()
    assert left.isascii()


def test_what_the_shell_says_of_a_name_is_one_printable_line(capsys):
    name = "a\nb\x1b[2J\u202e\ud800"
    console = Console()
    console.say(name)
    console.warn([Caution("switched-off", label=f"{name}: ")])
    error_line(name)
    said = capsys.readouterr()
    lines = [*said.out.splitlines(), *said.err.splitlines()]
    assert len(lines) == 3
    assert all(line.isprintable() for line in lines)


# Checks at the door, where values of Python itself are extreme.


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
