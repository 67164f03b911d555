"""What the command line says: results on stdout, everything else on stderr."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TextIO

from ..cautions import Caution, by_gravity
from ..validation import one_line

if TYPE_CHECKING:
    from ..plan import PlanResult

LINES = 8
"""Of a deployment on the screen, unless all of it is asked for."""

_REMEDIES = (
    ("to", "to", " (--from, --to)"),
    ("units", "units", " (--units mm, cm or m)"),
    ("one_unit", "units", " (--units cm, for example)"),
    ("centerline", "centerline", " (--centerline)"),
    ("right", "right", " (--right X Y Z)"),
    ("cycle", "cycle", " (--cycle T)"),
    ("unusual", "unusual_flow", " (--unusual-flow)"),
    ("names", "names", " (--names F)"),
    ("root", "root", " (--root X Y Z)"),
    ("accept_changed_inputs", "accept_changed_inputs", "(--accept-changed-inputs)"),
    ("straighten", "straightening_fraction", " (--straighten F)"),
    ("foreshortening", "foreshortening", " (--foreshortening F)"),
    ("shortened", "shortened", " (or --shortened: deploy what can lie there)"),
    ("devices", "device_table", "`sdfstent devices`, or give one of your own (--device-table F)"),
)
"""A remedy of the library's sentences, the option that does it, and how it is written there."""


class Console:
    """Where sentences go, and how many of them."""

    def __init__(self, options: argparse.Namespace | None = None, *, quiet: bool = False) -> None:
        self.remedies, self.quiet = remedies_of(options), quiet
        self._bar: _Bar | None = None
        self.verbose = getattr(options, "verbose", True)
        self.units = getattr(options, "units", "mm")
        """Of the files; a plan has its own."""

    def say(self, sentence: str = "") -> None:
        """A line of the result; nothing when quiet."""
        if not self.quiet:
            print(one_line(sentence))

    def warn(self, cautions: Iterable[Caution], thing: str = "stent", units: str = "mm") -> None:
        """Each on a line of stderr; nothing when quiet, for the report has them too.

        Places are told in mm and in the unit of the file.
        """
        if not self.quiet:
            for caution in cautions:
                self.complain(caution.sentence(thing, self.remedies, units))

    def warn_shortly(
        self, cautions: Iterable[Caution], lines: int, units: str, thing: str = "stent"
    ) -> None:
        """The gravest in so many lines at most, and how many more there are."""
        told = by_gravity(cautions)
        rest = len(told) - lines
        if self.verbose or rest <= 0:
            self.warn(told, thing, units)
            return
        self.warn(told[: lines - 1], thing, units)
        last = told[lines - 1].sentence(thing, self.remedies, units)
        self.complain(f"{last} And {rest} more: --verbose tells them.")

    def complain(self, sentence: str) -> None:
        """A sentence as a warning; nothing when quiet."""
        if not self.quiet:
            if self._bar:
                self._bar.clear()
            sys.stdout.flush()  # in the order in which they were said, also in one file
            to_stderr(f"warning: {sentence}")

    @contextmanager
    def progress(self, what: str) -> Iterator[Any]:
        """A bar on a terminal; yields what takes the fraction done and a note."""
        bar = _Bar(what, sys.stderr) if not self.quiet and sys.stderr.isatty() else None
        self._bar = bar
        try:
            yield bar.show if bar else ignored
        finally:
            self._bar = None
            if bar:
                bar.clear()


def tell(
    result: PlanResult, cautions: Iterable[Caution], console: Console, label: str = ""
) -> None:
    """Say what came of a deployment, the certificate last; the line of its files is the caller's.

    Every sentence, warnings too, begins with `label`.
    """
    from ..report import deployment_sentences, deployment_summary

    summary = deployment_summary(result)
    console.say(label + summary.deployed)
    labeled = [caution.labeled(label) for caution in cautions]
    units = result.inputs.surface.units
    # The first line and that of the files are told apart.
    console.warn_shortly(labeled, LINES - 2 - len(summary.results), units)
    told = deployment_sentences(result) if console.verbose else summary.results
    for sentence in told:
        console.say(label + sentence)


def remedies_of(options: argparse.Namespace | None) -> dict[str, str]:
    """How the options of a command are named in the library's sentences."""
    return {remedy: words for remedy, option, words in _REMEDIES if hasattr(options, option)}


def error_line(sentence: str) -> None:
    """The one sentence of a failure."""
    to_stderr(sentence.translate({ord("\n"): " "}))


def to_stderr(sentence: str) -> None:
    """A line of stderr; nothing where nobody can take it, such as a full disk."""
    with suppress(OSError):
        print(one_line(sentence), file=sys.stderr, flush=True)


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


def ignored(fraction: float, note: str = "") -> None:
    """Not a terminal: no bar."""
