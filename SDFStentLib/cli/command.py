"""The entry to the shell, which imports nothing before it is called."""

from __future__ import annotations

from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command as `shell.main` does; return its exit code.

    The commands import nearly all of the library and NumPy: before that signals have to be handled
    and the number of threads for linear algebra chosen.
    """
    from .shell import main as shell

    return shell(argv)
