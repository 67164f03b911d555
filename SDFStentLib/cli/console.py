"""What the command line says: results on stdout, everything else on stderr."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from ..validation import printable

_OPTIONS = (
    ("to", "between two points to choose", "between two points (--from, --to) to choose"),
    ("units", "the unit of the files.", "the unit of the files (--units mm, cm or m)."),
    ("units", "the unit of the file if it", "the unit of the file (--units mm, cm or m) if it"),
    ("units", "in one unit and name that", "in one unit and name that (--units cm, for example)"),
    ("centerline", "give the file as centerline.", "give the file as centerline (--centerline)."),
    ("accept_changed_inputs", "(accept_changed_inputs)", "(--accept-changed-inputs)"),
    ("straighten", "or straighten the axis.", "or straighten the axis (--straighten F)."),
)
"""An option, what the library's sentences say of its thing, and the same with the option."""


class Console:
    """Where sentences go, and how many of them."""

    def __init__(self, options: argparse.Namespace | None = None, *, quiet: bool = False) -> None:
        self.options, self.quiet = options, quiet

    def say(self, sentence: str = "") -> None:
        """A line of the result; nothing when quiet."""
        if not self.quiet:
            print(printable(sentence))

    def warn(self, sentences: Iterable[str]) -> None:
        """Each on a line of stderr; nothing when quiet, for the report has them too."""
        if not self.quiet:
            for sentence in sentences:
                words = with_options(sentence, self.options)
                print(printable(f"warning: {words}"), file=sys.stderr)

    @contextmanager
    def progress(self, what: str) -> Iterator[Any]:
        """A bar on a terminal; yields what takes the fraction done and a note."""
        bar = _Bar(what, sys.stderr) if not self.quiet and sys.stderr.isatty() else None
        try:
            yield bar.show if bar else _ignored
        finally:
            if bar:
                bar.clear()


def with_options(sentence: str, options: argparse.Namespace | None) -> str:
    """The library's sentence, with those options of the command that do what it says."""
    for name, words, more in _OPTIONS:
        if hasattr(options, name):
            sentence = sentence.replace(words, more)
    return sentence


def error_line(sentence: str) -> None:
    """The one sentence of a failure."""
    print(printable(" ".join(sentence.split("\n"))), file=sys.stderr)


class _Bar:
    """One line that is written again and again, and wiped at the end."""

    WIDTH = 30

    def __init__(self, what: str, stream: TextIO) -> None:
        self.what, self.stream, self.written = what, stream, 0

    def show(self, fraction: float, note: str = "") -> None:
        filled = round(self.WIDTH * min(max(fraction, 0.0), 1.0))
        bar = "#" * filled + "." * (self.WIDTH - filled)
        line = f"{self.what} [{bar}] {100 * fraction:3.0f} % {note}"
        self.stream.write("\r" + line.ljust(self.written))
        self.stream.flush()
        self.written = len(line)

    def clear(self) -> None:
        self.stream.write("\r" + " " * self.written + "\r")
        self.stream.flush()


def _ignored(fraction: float, note: str = "") -> None:
    """Not a terminal: no bar."""
