"""The way into the shell that imports nothing before it is taken."""

from __future__ import annotations

from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command as `shell.main` does; returns its exit code.

    The commands import nearly all of the library and NumPy: by then signals have to be taken, and
    the threads of linear algebra chosen.
    """
    from .shell import main as shell

    return shell(argv)
