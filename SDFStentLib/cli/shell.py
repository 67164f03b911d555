"""The command `sdfstent`: parses the command line and turns every failure into one sentence."""

from __future__ import annotations

import argparse
import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import TextIO

from ..files import cannot_write
from ..threads import use_threads
from ..units import in_file
from ..validation import DeploymentError, InputError
from .console import Console, error_line, remedies_of
from .options import parser
from .signals import INTERRUPTED, SENTENCE, interruptions

DONE, UNEXPECTED, BAD_INPUT, NOT_CERTIFIED = 0, 1, 2, 3

_BESIDE = {
    "run": "deploy",
    "check": "measure",
    "centerline": "extract",
    "prepare": "extract",
    "simulate": "flow",
    "devices": "suggest",
}
"""Commands that share the file of another command."""

_NEGATIVE = re.compile(r"-\.?\d[^.]*(\.(\d[^.]*|[eE][-+]?\d+|\w+/\w+)?)?")
"""A negative number with or without a unit, unlike the name of a file such as -1.vtp."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.
    """
    # A stream is None if whoever started the process has closed it.
    sys.stdout, sys.stderr = sys.stdout or _nowhere(), sys.stderr or _nowhere()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    arguments = [_as_value(word) for word in (sys.argv[1:] if argv is None else argv)]
    try:
        options = parser().parse_args(arguments)
    except SystemExit as end:  # after --help, --version and errors of usage
        return int(end.code or 0)
    console = Console(options, quiet=options.quiet)
    try:
        if hasattr(options, "threads"):
            use_threads(options.threads)
        command = _imported(options.command)
        with interruptions():
            code = command(options, console)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader of the output has seen enough.
        _drop_stdout()
        return DONE
    except (Exception, KeyboardInterrupt) as error:
        return _failed(error, options, console.units)


def _imported(name: str) -> Callable[[argparse.Namespace, Console], int]:
    """The function of a command, imported late: vtk and scipy take longer than finding most
    mistakes."""
    module = import_module(f".{_BESIDE.get(name, name)}", __package__)
    command: Callable[[argparse.Namespace, Console], int] = getattr(module, f"{name}_command")
    return command


def _drop_stdout() -> None:
    """Redirect stdout to nowhere, so that flushing it at the end cannot fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")


def _failed(error: BaseException, options: argparse.Namespace, units: str) -> int:
    if options.debug:
        traceback.print_exception(error)
    if isinstance(error, KeyboardInterrupt):
        error_line(SENTENCE)
        return INTERRUPTED
    if isinstance(error, InputError):
        text = error.sentence(remedies_of(options), in_file(error.place, units))
        error_line(f"sdfstent {options.command}: {text}")
        return BAD_INPUT
    if isinstance(error, DeploymentError):
        error_line(f"sdfstent {options.command}: {error}")
        return BAD_INPUT
    if isinstance(error, OSError) and error.filename is None and error.strerror:
        # Errors of files have their names, so this one is of the standard output.
        _drop_stdout()
        sentence = cannot_write("standard output", error)
        error_line(f"sdfstent {options.command}: {sentence}")
        return BAD_INPUT
    hint = "" if options.debug else " Run it again with --debug to see where."
    words = " ".join(f"{type(error).__name__}: {error}".split())
    error_line(f"sdfstent {options.command}: unexpected error ({words}).{hint}")
    return UNEXPECTED


def _as_value(word: str) -> str:
    """The word, with a space before a negative number: argparse takes -1e-3 and -3L/min for
    options."""
    return f" {word}" if _NEGATIVE.fullmatch(word) else word
