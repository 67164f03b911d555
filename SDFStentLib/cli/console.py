"""The console of the command line: results go to stdout, everything else to stderr."""

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
"""Lines about a deployment on the screen without `--verbose`."""

_REMEDIES = (
    ("to", "to", " (--from, --to)"),
    ("units", "units", " (--units mm, cm or m)"),
    ("one_unit", "units", " (--units cm, for example)"),
    ("centerline", "centerline", " (--centerline)"),
    ("right", "right", " (--right X Y Z)"),
    ("cycle", "cycle", " (--cycle T)"),
    ("unusual", "unusual_flow", " (--unusual-flow)"),
    ("names", "names", " (--names F)"),
    ("frame", "frame", " (--frame RAS or LPS)"),
    ("root", "root", " (--root X Y Z)"),
    ("accept_changed_inputs", "accept_changed_inputs", "(--accept-changed-inputs)"),
    ("straighten", "straightening_fraction", " (--straighten F)"),
    ("foreshortening", "foreshortening", " (--foreshortening F)"),
    ("shortened", "shortened", " (or --shortened: deploy what can lie there)"),
    ("devices", "device_table", "`sdfstent devices`, or give one of your own (--device-table F)"),
)
"""Remedies in the library's sentences: the name, the option that applies it, and its
words there."""


class Console:
    """Output of a command: sentences, as many as the options ask for."""

    def __init__(self, options: argparse.Namespace | None = None, *, quiet: bool = False) -> None:
        self.remedies, self.quiet = remedies_of(options), quiet
        self._bar: _Bar | None = None
        self.verbose = getattr(options, "verbose", True)
        self.units = getattr(options, "units", "mm")
        """Unit of the files; a plan has its own."""

    def say(self, sentence: str = "") -> None:
        """Print a line of the result; nothing when quiet."""
        if not self.quiet:
            print(one_line(sentence))

    def warn(self, cautions: Iterable[Caution], thing: str = "stent", units: str = "mm") -> None:
        """Print each caution on a line of stderr; nothing when quiet, as the report has them too.

        Places are given in mm and in the unit of the file.
        """
        if not self.quiet:
            for caution in cautions:
                self.complain(caution.sentence(thing, self.remedies, units))

    def warn_shortly(
        self, cautions: Iterable[Caution], lines: int, units: str, thing: str = "stent"
    ) -> None:
        """Print the gravest cautions in a number of lines at most, and how many more there are."""
        graded = by_gravity(cautions)
        rest = len(graded) - lines
        if self.verbose or rest <= 0:
            self.warn(graded, thing, units)
            return
        self.warn(graded[: lines - 1], thing, units)
        last = graded[lines - 1].sentence(thing, self.remedies, units)
        self.complain(f"{last} And {rest} more: --verbose tells them.")

    def complain(self, sentence: str) -> None:
        """Print a sentence as a warning; nothing when quiet."""
        if not self.quiet:
            if self._bar:
                self._bar.clear()
            sys.stdout.flush()  # keeps the order of both streams, even in one file
            to_stderr(f"warning: {sentence}")

    @contextmanager
    def progress(self, what: str) -> Iterator[Any]:
        """Show a bar on a terminal; yields a function that takes the fraction done and a note."""
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
    """Report a deployment, the certificate last; the caller adds the line about its files.

    Every sentence, warnings too, begins with `label`.
    """
    from ..report import deployment_sentences, deployment_summary

    summary = deployment_summary(result)
    console.say(label + summary.deployed)
    labeled = [caution.labeled(label) for caution in cautions]
    units = result.inputs.surface.units
    # The first line and that about the files are printed separately.
    console.warn_shortly(labeled, LINES - 2 - len(summary.results), units)
    sentences = deployment_sentences(result) if console.verbose else summary.results
    for sentence in sentences:
        console.say(label + sentence)


def remedies_of(options: argparse.Namespace | None) -> dict[str, str]:
    """Words for the options of a command in the library's sentences."""
    return {remedy: words for remedy, option, words in _REMEDIES if hasattr(options, option)}


def error_line(sentence: str) -> None:
    """Print the one sentence of a failure."""
    to_stderr(sentence.translate({ord("\n"): " "}))


def to_stderr(sentence: str) -> None:
    """Print a line to stderr; drop it where that fails, as on a full disk."""
    with suppress(OSError):
        print(one_line(sentence), file=sys.stderr, flush=True)


class _Bar:
    """A progress bar: one line, rewritten in place and wiped at the end."""

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
    """Progress without a terminal: shows no bar."""
