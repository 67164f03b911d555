"""Something that is worked out by a copy of this process while it goes on."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any, NoReturn

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class InCopy:
    """Asks for something in a copy of the process, if it can be copied; ends it with the block.

    Threads would take turns: most calls into NumPy are too short to run beside each other. Nothing
    has to be sent to a copy, and what is asked for comes back pickled.

    Parameters
    ----------
    ask : callable
        Its result must not depend on what happens meanwhile.
    """

    def __init__(self, ask: Callable[[], object]) -> None:
        self._ask, self._process, self._pipe = ask, 0, -1

    def __enter__(self) -> InCopy:
        if not _can_be_copied():
            return self
        self._pipe, far = os.pipe()
        # The copy handles signals in its own way from its first step on.
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        with suppress(OSError):  # as many processes as there may be
            self._process = os.fork()
            if self._process == 0:
                _answer(self._ask, far)
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        os.close(far)
        return self

    def result(self) -> Any:
        """What came of it; None where nothing did, so that whoever asks here is told why."""
        if not self._process:
            return None
        with open(self._pipe, "rb", closefd=False) as pipe, suppress(EOFError, pickle.PickleError):
            return pickle.load(pipe)
        return None

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._pipe >= 0:
            os.close(self._pipe)
        if self._process:
            os.kill(self._process, signal.SIGKILL)
            with suppress(ChildProcessError):  # where nobody may wait for processes
                os.waitpid(self._process, 0)


def _can_be_copied() -> bool:
    """Whether this is Linux, and no other thread could hold a lock that nobody opens in a copy."""
    try:
        return sys.platform == "linux" and len(os.listdir("/proc/self/task")) == 1
    except OSError:
        return False


def _answer(ask: Callable[[], object], pipe: int) -> NoReturn:
    """What the copy does: it never comes back."""
    try:
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
        with open(pipe, "wb") as far:
            far.write(pickle.dumps(ask()))
    finally:
        os._exit(0)
