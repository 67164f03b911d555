"""The shell: `sdfstent deploy`, `run`, `measure`, `check`, `suggest`, `devices` and the others.

What is named here is imported when it is first asked for: signals are taken before anything else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..late import late_names

if TYPE_CHECKING:
    from .shell import main
    from .signals import INTERRUPTED, end_at_once

__all__ = [
    "INTERRUPTED",
    "end_at_once",
    "main",
]

__getattr__, __dir__ = late_names(
    __name__, {"shell": ["main"], "signals": ["INTERRUPTED", "end_at_once"]}
)
