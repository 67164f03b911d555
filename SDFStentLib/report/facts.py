"""Facts on a subject: every quantity once, as a `Fact`. Documents, tables, lines and tiles are
views of facts.

A function per subject lists them, such as `stent_facts`; a new number is one more of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .words import UNKNOWN, degree_word, millimeters, number_text

GLANCE, COMPARED, LINES, DETAILS = LEVELS = range(4)
"""Levels by where a fact first appears: at a glance, on tiles and beside the stent; in the
comparison of plans; in the lines of shell and panel; in the report only. Later places have it,
too."""


class Tile(NamedTuple):
    """A quantity of a result: its value large, its name small, before and reference beneath."""

    name: str
    value: str
    beneath: str = ""
    is_caution: bool = False
    """Whether it has to be known before one relies on the others."""


class Fact(NamedTuple):
    """A quantity of a result."""

    key: str = ""
    """Place in a document: names from the outside in, between dots; `{}` is before or after. A fact
    whose key begins with an underscore is in no document."""
    label: str = ""
    """Name for a reader. A fact without a label is a sentence, or is for programs only."""
    before: Any = None
    """The value before; None where treatment does not change it, NaN where it is not known."""
    after: Any = None
    unit: str = ""
    words: str = ""
    """The value after treatment as a reader wants it, with its unit; or the whole sentence."""
    was: str = ""
    """The value before treatment in words, empty where treatment does not change it."""
    level: int = DETAILS
    note: str = ""
    """Words that follow the values in a line."""
    column: str = ""
    """Column in a table with a row per result; `{}` is before or after, of a place x, y, z."""
    short: str = ""
    """Name in the lines beside the stent, where that is not its label,"""
    tile: str = ""
    """and on its tile."""
    worst: Callable[..., Any] = min
    """Choice of the stent for a tile: that with the smallest value, or the largest, `max`."""
    few: str = ""
    """The value in few words, with its unit, where these are not the number to a tenth."""
    hand: str | None = None
    """The line beside the stent, where that is not its name and values; empty for none."""
    beneath: str | None = None
    """Words beneath the value on its tile, where these are not the one before and the note."""
    is_caution: bool = False
    """Whether it has to be known before one relies on the others."""
    within: tuple[float, float] | None = None
    """The smallest and largest value after treatment, by the size of the voxels."""

    @property
    def change(self) -> str:
        """The values of a line: before and after, the unit once."""
        was = self.was if self.words == UNKNOWN else self.was.removesuffix(f" {self.unit}")
        return " -> ".join(filter(None, (was, self.words))) + self.note

    @property
    def cell(self) -> str:
        """Values beside those of other plans, the one after first; lengths to 0.01 mm."""
        words = millimeters(self.after) if self.unit == "mm" else self.words
        return f"{words} (before {self.was})" if self.was else words

    @property
    def is_known(self) -> bool:
        """Whether it has a known value."""
        return {self.was, self.words} != {UNKNOWN}

    @property
    def in_few(self) -> str:
        """Value on tiles, and where there is little room."""
        return self.few or f"{self._rounded[-1]} {self.unit}"

    @property
    def at_hand(self) -> str:
        """The line beside a stent."""
        if self.hand is not None:
            return self.hand
        values = self.few or f"{' -> '.join(self._rounded)} {self.unit}"
        return f"{self.short or self.label} {values}"

    @property
    def tiled(self) -> Tile:
        """Tile of the fact; a unit that ends the note stands once beneath it."""
        unit = "" if self.note.endswith(f" {self.unit}") else f" {self.unit}"
        was = "".join(f"before {one}{unit}" for one in self._rounded[:-1])
        beneath = f"{was}{self.note}".removeprefix(", ") if self.beneath is None else self.beneath
        if self.within is not None and np.isfinite(self.within).all():
            low, high = map(self._in_range, self.within)
            beneath = beneath if low == high else f"({low.removesuffix(' %')}-{high}) {beneath}"
        return Tile(self.tile or self.label, self.in_few, beneath, self.is_caution)

    @property
    def _rounded(self) -> list[str]:
        states = self.before, self.after
        return [number_text(one, self._digits) for one in states if one is not None]

    def _in_range(self, value: float) -> str:
        return degree_word(value) if self.unit == "%" else number_text(value, self._digits)

    @property
    def _digits(self) -> int:
        return 0 if self.unit == "%" else 1

    def __str__(self) -> str:
        return f"{self.label}: {self.change}" if self.label else self.words

    def named_values(self, name: str) -> Iterator[tuple[str, Any]]:
        """Values by `name`, a key or a column: one, two states, or three coordinates."""
        if "{}" not in name:
            yield name, self.after
        elif isinstance(self.after, np.ndarray):
            yield from zip(map(name.format, "xyz"), self.after.tolist(), strict=True)
        else:
            yield name.format("before"), self.before
            yield name.format("after"), self.after


class Facts(tuple[Fact, ...]):
    """Facts of one subject, in order, and the views of all of them."""

    def named(self, key: str) -> Fact:
        """The fact with a key."""
        return next(one for one in self if one.key == key)

    def value(self, key: str) -> Any:
        """Value after treatment of the fact with a key; None without such a fact."""
        return next((one.after for one in self if one.key == key), None)

    def as_dict(self) -> dict[str, Any]:
        """Values by key, for a document."""
        found: dict[str, Any] = {}
        for one in self:
            for path, value in () if one.key[:1] in ("", "_") else one.named_values(one.key):
                inner, (*above, name) = found, path.split(".")
                for step in above:
                    inner = inner.setdefault(step, {})
                inner[name] = value
        return found

    def columns(self) -> dict[str, Any]:
        """Columns of a row of a table."""
        return {
            name: value
            for one in self
            if one.column
            for name, value in one.named_values(one.column)
        }

    def rows(self) -> list[tuple[str, str]]:
        """Names and values of what treatment does not change, for a page."""
        return [(one.label, one.words) for one in self._labeled() if not one.was]

    def changes(self, levels: Sequence[int] = LEVELS) -> list[tuple[str, str, str]]:
        """Names, values before and after, of the facts of some levels, for a page."""
        return [
            (one.label, one.was, one.words)
            for one in self._labeled()
            if one.was and one.level in levels
        ]

    def at(self, level: int) -> list[Fact]:
        """Facts with words of a level and of those before it."""
        return [one for one in self if one.level <= level and one.words]

    @property
    def sentences(self) -> list[str]:
        """The facts that are sentences, for the shell."""
        return [one.words for one in self.at(LINES) if not one.label]

    def _labeled(self) -> Iterable[Fact]:
        return (one for one in self if one.label and one.words)


LISTED = 4
"""The most stents, lesions and branches that are listed; of more the number is given."""


def listed(words: Sequence[str], between: str = ", ") -> str:
    """First of some words, and the number of the others."""
    more = len(words) - LISTED
    return between.join([*words[:LISTED], *([f"and {more} more"] if more > 0 else [])])


def size(key: str, label: str, value: float | None, digits: int = 2, **more: Any) -> Fact:
    """A length that treatment does not change, mm; without words where there is none."""
    words = "" if value is None else millimeters(value, digits)
    return Fact(key, label, None, value, "mm", words, **more)


def width(key: str, label: str, before: float, after: float, **more: Any) -> Fact:
    """A length before and after treatment, mm."""
    return Fact(key, label, before, after, "mm", millimeters(after), millimeters(before), **more)
