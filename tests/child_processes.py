"""What the tests give every process that they start and then interrupt."""

from __future__ import annotations

import os
import signal
from functools import partial
from typing import Any

INTERRUPTIBLE: dict[str, Any] = (
    {} if os.name == "nt" else {"preexec_fn": partial(signal.signal, signal.SIGINT, signal.SIG_DFL)}
)
"""Arguments of `subprocess.Popen`. A test run in the background of a script ignores Ctrl-C, and so
would its children."""
PATIENCE = 600
"""So many seconds are waited for what a busy machine does in a few: only a failure reaches them."""
