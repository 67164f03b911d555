"""What the tests give every process that they start and then interrupt."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

INTERRUPTIBLE: dict[str, Any] = (
    {} if os.name == "nt" else {"preexec_fn": partial(signal.signal, signal.SIGINT, signal.SIG_DFL)}
)
"""Arguments of `subprocess.Popen`. A test run in the background of a script ignores Ctrl-C, and so
would its children."""
PATIENCE = 600
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
