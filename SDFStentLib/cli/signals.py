"""Ctrl-C and SIGTERM: a single interruption, and none while files are moved to their places.

A sweep waits for its workers, which may not answer, until the second signal.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

INTERRUPTED = 130
SENTENCE = "sdfstent: interrupted; nothing was written."

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_open_blocks: list[None] = []  # of `interruptions`
_asked: list[int] = []  # signals that came within the block
_at_second: list[Callable[[], None]] = []  # what is done at a second one


@contextmanager
def interruptions() -> Iterator[None]:
    """Turn the first signal within the block into a `KeyboardInterrupt`, and ignore
    further ones."""

    def interrupt(number: int, _frame: FrameType | None) -> NoReturn:
        _set(_second if _at_second else signal.SIG_IGN)
        _asked.append(number)
        raise KeyboardInterrupt

    before = _set(interrupt)
    _open_blocks.append(None)
    try:
        yield
    finally:
        _asked.clear()
        _open_blocks.pop()
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def at_second_signal(act: Callable[[], None]) -> Iterator[None]:
    """Let a second signal within the block act; only further ones are ignored.

    This is for work that waits for others when it is interrupted.
    """
    _at_second.append(act)
    try:
        yield
    finally:
        _at_second.pop()


def _second(_number: int, _frame: FrameType | None) -> None:
    _set(signal.SIG_IGN)
    for act in _at_second:
        act()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Ignore signals within the block, which is short and ends in one state or the other."""
    before = _set(signal.SIG_IGN)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def check_interrupted() -> None:
    """Interrupt again if Python lost the interruption, as in the callback of an import."""
    if _asked:
        raise KeyboardInterrupt


def uninterrupted_from_now() -> None:
    """Ignore signals until the block of `interruptions` ends, as its purpose is fulfilled."""
    if _open_blocks:
        _set(signal.SIG_IGN)


def end_at_once() -> None:
    """Let a signal end the process with a sentence from now on, during the imports."""

    def end(_number: int, _frame: FrameType | None) -> NoReturn:
        os.write(2, f"{SENTENCE}\n".encode())
        os._exit(INTERRUPTED)

    _set(end)


def _set(handler: Any) -> dict[int, Any]:
    """Set the handler of the signals that are not ignored already; return the previous handlers."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    found = {number: signal.getsignal(number) for number in _SIGNALS}
    before: dict[int, Any] = {
        number: old for number, old in found.items() if old not in (signal.SIG_IGN, None)
    }
    for number in before:
        signal.signal(number, handler)
    return before
