"""The shell: `sdfstent deploy`, `run`, `measure`, `check` and `demo`."""

from __future__ import annotations

from .shell import main

__all__ = [
    "main",
]


def __dir__() -> list[str]:
    return __all__
