"""What the tests give every process that they start and then interrupt."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

INTERRUPTIBLE: dict[str, Any] = (
    {} if os.name == "nt" else {"preexec_fn": partial(signal.signal, signal.SIGINT, signal.SIG_DFL)}
)
"""Arguments of `subprocess.Popen`. A test run in the background of a script ignores Ctrl-C, and so
would its children."""
PATIENCE = 1800
"""So many seconds are waited for what a busy machine does in a few: only a failure reaches them."""


def installed(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """What the installed command does in a folder, as a user starts it."""
    command = Path(sys.executable).with_name("sdfstent")
    return subprocess.run(
        [command, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


_MEASURED = """
import json, resource, subprocess, sys
run = subprocess.run(sys.argv[1:], capture_output=True, text=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
peak = used.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e6 / 1024)
print(json.dumps([run.returncode, run.stdout + run.stderr, peak, used.ru_utime]))
"""


class Measured(NamedTuple):
    """Exit code of a command, what it said, its largest memory, MB, and its processor time, s."""

    code: int
    said: str
    peak_mb: float
    seconds: float


def measured(*arguments: object, folder: Path) -> Measured:
    """What the installed command does, and what that takes.

    By a process between: a child starts with the peak of its parent, that of the tests is high, and
    a parent knows the largest of all its children only.
    """
    command = Path(sys.executable).with_name("sdfstent")
    run = subprocess.run(
        [sys.executable, "-c", _MEASURED, command, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    return Measured(*json.loads(run.stdout))
