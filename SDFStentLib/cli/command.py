"""The entry to the shell, which imports nothing before it is called."""

from __future__ import annotations

import gc
from collections.abc import Sequence
from importlib import import_module


def load() -> None:
    """Import the commands before `main`, in a process that is there for nothing else.

    What is imported is never garbage: Python does not look through it again and again.
    """
    gc.disable()
    import_module(".shell", __package__)
    gc.freeze()
    gc.enable()


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command as `shell.main` does; return its exit code.

    The commands import nearly all of the library and NumPy: before that signals have to be handled
    and the number of threads for linear algebra chosen.
    """
    from .shell import main as shell

    return shell(argv)
