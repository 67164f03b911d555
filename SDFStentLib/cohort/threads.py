"""How a worker process begins; imports nothing that starts threads."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import NoReturn

ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Variables that libraries of linear algebra read once, when they are loaded."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Processes that start within the block have one thread of linear algebra."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


_begun: list[Connection] = []


def start_worker(sweep: Connection, begun: Connection | None = None) -> None:
    """Leave Ctrl-C to the sweep, and end when the other end of its pipe is closed.

    Where it is to know what is begun, `begun` is what tells it.
    """
    if begun is not None:
        _begun.append(begun)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
    threading.Thread(target=_end_with, args=(sweep,), daemon=True).start()


def begin(case: str) -> None:
    """Tell the sweep that this process begins a case, where it is to know.

    Workers share the pipe without a lock, which one that is stopped would keep: so few bytes are
    written at once.
    """
    for pipe in _begun:
        with suppress(OSError):
            pipe.send_bytes(f"{os.getpid()} {case}".encode())


def _end_with(sweep: Connection) -> NoReturn:
    with suppress(EOFError, OSError):
        sweep.recv_bytes()
    os._exit(1)
