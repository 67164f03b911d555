"""Helpers to start processes and to wait for them, so that all of them can be interrupted."""

import json
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

PROJECT = Path(__file__).resolve().parents[1]
COMMAND = Path(sys.executable).with_name("sdfstent")
INTERRUPTIBLE: dict[str, Any] = (
    {} if os.name == "nt" else {"preexec_fn": partial(signal.signal, signal.SIGINT, signal.SIG_DFL)}
)
"""Arguments of `subprocess.Popen`. A test run in the background of a script ignores Ctrl-C, and so
would its children."""
PATIENCE = 1800
"""So many seconds are waited for what a busy machine does in a few: only a failure reaches them."""


def begun(*words: object, folder: Path = PROJECT, **more: Any) -> subprocess.Popen[str]:
    """A new process with these words as its command line, in a folder."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([*map(str, words)], cwd=folder, **{**streams, **INTERRUPTIBLE, **more})


def ended(process: subprocess.Popen[str]) -> subprocess.CompletedProcess[str]:
    """The outcome of a process, after it has ended."""
    said = process.communicate(timeout=PATIENCE)
    return subprocess.CompletedProcess(process.args, process.returncode, *said)


def installed(*words: object, folder: Path, **more: Any) -> subprocess.CompletedProcess[str]:
    """The outcome of the installed command in a folder, started as a user starts it."""
    return ended(begun(COMMAND, *words, folder=folder, **more))


def python(program: str, *words: object, **more: Any) -> subprocess.CompletedProcess[str]:
    """The outcome of a Python program in a process of its own, where every RuntimeWarning is an
    error."""
    strict = ["-W", "error::RuntimeWarning"]
    return ended(begun(sys.executable, *strict, "-c", program, *words, **more))


_MEASURED = """
import json, resource, subprocess, sys
run = subprocess.run(sys.argv[1:], capture_output=True, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
peak = used.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e6 / 1024)
print(json.dumps([run.returncode, run.stdout + run.stderr, peak, used.ru_utime]))
"""


class Measured(NamedTuple):
    """Exit code of a command, its output, its largest memory in MB, and its processor time in s."""

    code: int
    said: str
    peak_mb: float
    seconds: float


def measured(*arguments: object, folder: Path) -> Measured:
    """The outcome of the installed command, with its memory and processor time.

    A process in between measures it: a child starts with the peak memory of its parent, which is
    high for the tests, and a parent knows only the largest peak of all its children.
    """
    return Measured(*json.loads(python(_MEASURED, COMMAND, *arguments, folder=folder).stdout))
